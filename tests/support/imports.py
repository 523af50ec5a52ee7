"""Find imports and private names in the sources, including imports inside functions."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

#: Maps the name of a module, or of a top-level package, to the names that it imports.
Graph = Mapping[str, frozenset[str]]

#: The template of a user's project. Its files do not belong to the package.
_NO_PART = "new/template"

_BY_NAME = ("setattr", "delattr", "getattr", "hasattr", "attrgetter", "patch", "object")
_CALLS_BY_NAME = re.compile(rf"\b({'|'.join(_BY_NAME)})\s*\(")
_PRIVATE = re.compile(r"([A-Za-z]\w*\.)*_[A-Za-z]\w*(\.\w+)*")


def modules(package: Path) -> dict[str, Path]:
    """Return the files of a package's modules by name; `__init__` has the name of its package."""
    found = {}
    for file in sorted(package.rglob("*.py")):
        parts = file.relative_to(package.parent).with_suffix("").parts
        if _NO_PART not in file.as_posix():
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


#: The packages of the wheel, from top to bottom.
PACKAGES = ("rcx_harness", "structured_text")


def shipped(repository: Path) -> dict[str, Path]:
    """Return the modules of the packages that users install, by name."""
    every = (modules(repository / "harness" / package) for package in PACKAGES)
    return {name: file for found in every for name, file in found.items()}


def imports(*packages: Path) -> Graph:
    """Map each module of the packages to the modules of the packages that it imports.

    `import a.b` and `from a import b` are imports of `a.b`, or of `a` if `b` is not a module.
    """
    known = {name: file for package in packages for name, file in modules(package).items()}
    graph = {}
    for name, file in known.items():
        imported = set()
        for text in _named(file, name):
            while text and text not in known:
                text = text.rpartition(".")[0]
            imported.add(text)
        graph[name] = frozenset(imported - {"", name})
    return graph


def _named(file: Path, module: str) -> Iterator[str]:
    """Return everything that a file imports, with its full name."""
    package = module if file.stem == "__init__" else module.rpartition(".")[0]
    for node in _statements(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.rsplit(".", node.level - 1)[0] if node.level else ""
            start = ".".join(filter(None, (above, node.module)))
            yield from (f"{start}.{alias.name}" for alias in node.names)


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Return all statements below a node. Expressions, the larger part of a tree, are left out."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, (ast.expr, ast.expr_context, ast.arguments)):
            yield child
            yield from _statements(child)


def room_graph(graph: Graph) -> Graph:
    """Return the imports between the rooms: the top-level modules and subpackages of a package.

    `__init__` and `__main__` of the package are not rooms, because they may import all rooms.
    """
    rooms: dict[str, set[str]] = {}
    for module, imported in graph.items():
        room = _room(module)
        if room:
            own = rooms.setdefault(room, set())
            own |= {other for other in map(_room, imported) if other not in ("", room)}
    return {room: frozenset(others) for room, others in rooms.items()}


def _room(module: str) -> str:
    """Return the top-level name of a module; empty for `__init__` and `__main__` of the package."""
    room = module.partition(".")[2].partition(".")[0]
    return "" if room == "__main__" else room


def find_cycle(graph: Graph) -> list[str]:
    """Return a circle of imports as names. The first name is repeated at the end."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(reversed(error.args[1]))
    return []


def floors(graph: Graph) -> int:
    """Return the length of the longest chain of imports in a graph without circles."""
    level: dict[str, int] = {}
    for one in TopologicalSorter(graph).static_order():
        level[one] = 1 + max((level[other] for other in graph.get(one, ())), default=0)
    return max(level.values(), default=0)


def private_names(text: str) -> set[str]:
    """Return private names that a module imports, or passes as text to `setattr` and the like.

    Names after a dot, as in `thing._name`, are reported by ruff (SLF).
    """
    found: set[str] = set()
    tree = ast.parse(text)
    for node in _statements(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {alias.name for alias in node.names}
    for node in ast.walk(tree) if _CALLS_BY_NAME.search(text) else ():
        if isinstance(node, ast.Call):
            called = getattr(node.func, "attr", getattr(node.func, "id", ""))
            texts = [one.value for one in node.args[:2] if isinstance(one, ast.Constant)]
            if called in _BY_NAME:
                found |= {one for one in texts[:1] if isinstance(one, str)}
    return {name for name in found if _PRIVATE.fullmatch(name)}
