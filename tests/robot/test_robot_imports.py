"""Modules of the virtual controller do not import each other in a circle, not even for types."""

from __future__ import annotations

import ast
from pathlib import Path

import rcx_harness.robot

_ROOM = Path(rcx_harness.robot.__file__).parent


def _modules() -> dict[str, Path]:
    files = {file.relative_to(_ROOM).with_suffix(""): file for file in _ROOM.rglob("*.py")}
    return {
        ".".join(("rcx_harness", "robot", *path.parts)).removesuffix(".__init__"): file
        for path, file in files.items()
    }


def _imports(file: Path) -> set[str]:
    """Return the imports of a module, also under TYPE_CHECKING and in functions."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
    return found


def test_no_module_of_the_controller_imports_itself_by_way_of_others() -> None:
    modules = _modules()
    graph = {name: _imports(file) & modules.keys() - {name} for name, file in modules.items()}
    while done := {name for name, needs in graph.items() if not needs}:
        graph = {name: needs - done for name, needs in graph.items() if name not in done}
    assert sorted(graph) == []
