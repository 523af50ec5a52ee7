"""Names of the standard library that only some systems have, and their uses in sources.

Source: typeshed, the declarations that mypy brings.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import mypy

SYSTEMS = ("win32", "darwin", "linux")

#: Methods of an event loop that exist on Windows but raise an error.
_LOOP = frozenset(
    {
        "add_reader",
        "add_signal_handler",
        "add_writer",
        "connect_read_pipe",
        "connect_write_pipe",
        "create_unix_connection",
        "create_unix_server",
        "open_unix_connection",
        "remove_signal_handler",
        "start_unix_server",
    }
)
_STUBS = Path(mypy.__file__).parent / "typeshed" / "stdlib"
_ASKS = ("getattr", "hasattr")


@cache
def names_of(module: str, system: str) -> frozenset[str]:
    """Return the names of a standard library module on a system, or nothing without the module.

    Members of its classes have the form `Class.member`.
    """
    file = _stub(module)
    if file is None:
        return frozenset()
    return frozenset(_declared(ast.parse(file.read_text(encoding="utf-8")).body, system, ""))


def _stub(module: str) -> Path | None:
    path = _STUBS.joinpath(*module.split("."))
    either = path / "__init__.pyi", path.with_name(f"{path.name}.pyi")
    return next((one for one in either if one.is_file()), None)


def _declared(body: list[ast.stmt], system: str, prefix: str) -> Iterator[str]:
    for node in body:
        if isinstance(node, ast.If):
            holds = _holds(node.test, system)
            yield from _declared(node.body if holds else node.orelse, system, prefix)
        elif isinstance(node, ast.ClassDef):
            yield prefix + node.name
            yield from _declared(node.body, system, f"{prefix}{node.name}.")
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield prefix + node.name
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield prefix + node.target.id
        elif isinstance(node, ast.Assign):
            yield from (prefix + one.id for one in node.targets if isinstance(one, ast.Name))
        elif isinstance(node, ast.ImportFrom) and node.names[0].name == "*":
            # The submodules of a package are the same on all systems.
            yield from (name for name in names_of(str(node.module), system) if "." not in name)
        elif isinstance(node, ast.ImportFrom):
            yield from (prefix + one.name for one in node.names if one.asname == one.name)


def _holds(test: ast.expr, system: str) -> bool:
    known = SimpleNamespace(platform=system, version_info=sys.version_info)
    names = {"sys": known, "TYPE_CHECKING": True}
    return bool(eval(compile(ast.Expression(test), "typeshed", "eval"), names))


def of_some(module: str) -> frozenset[str]:
    """Return the names of a module that at least one of the systems lacks."""
    every = [names_of(module, system) for system in SYSTEMS]
    return frozenset.union(*every) - frozenset.intersection(*every)


def hidden_on(module: str, system: str) -> frozenset[str]:
    """Return the names in a module that Linux has and this system lacks."""
    return names_of(module, "linux") - names_of(module, system)


def absent_on(system: str) -> set[str]:
    """Return the modules that this system lacks and Linux has."""
    every = {one for one in sys.stdlib_module_names if _stub(one) is not None}
    return {one for one in every if _is_on(one, "linux") and not _is_on(one, system)}


def members_of_some(modules: frozenset[str]) -> frozenset[str]:
    """Return the names of class members in these modules that at least one system lacks."""
    found = set(_LOOP)
    # typeshed declares members written in C there
    for module in modules | {f"_{one}" for one in modules}:
        for name in of_some(module):
            owner, _, member = name.rpartition(".")
            if owner and owner not in of_some(module):
                found.add(member)
    return frozenset(found)


def used(text: str) -> set[str]:
    """Return the names that a module's source uses and that one of the systems lacks.

    The result includes names that are texts for `getattr`, and attributes of modules that are
    imported under a calculated name.
    """
    tree = ast.parse(text)
    aliases, found = _imported(tree)
    modules = frozenset(aliases.values())
    members = members_of_some(modules)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            module = aliases.get(node.value.id) if isinstance(node.value, ast.Name) else None
            if module is not None and node.attr in of_some(module):
                found.add(f"{module}.{node.attr}")
            elif module is None and node.attr in members:
                found.add(node.attr)
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") in _ASKS:
            found |= set(_asked(node.args, aliases))
    return found


def _asked(arguments: list[ast.expr], aliases: Mapping[str, str]) -> Iterator[str]:
    owner, name = arguments[:2]
    module = aliases.get(owner.id) if isinstance(owner, ast.Name) else None
    if module is not None:
        written = isinstance(name, ast.Constant) and name.value not in of_some(module)
        if not written:
            yield f"{module}.{ast.unparse(name)}"


def _imported(tree: ast.Module) -> tuple[dict[str, str], set[str]]:
    """Return imported modules by their local names, and imported names that some system lacks."""
    aliases: dict[str, str] = {}
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for one in node.names:
                if one.name.partition(".")[0] in sys.stdlib_module_names:
                    own = one.name if one.asname else one.name.partition(".")[0]
                    aliases[one.asname or own] = own
                    found |= _lacking(one.name)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            module = str(node.module)
            if module.partition(".")[0] in sys.stdlib_module_names:
                found |= _lacking(module)
                some = of_some(module)
                found |= {f"{module}.{one.name}" for one in node.names if one.name in some}
                aliases |= dict(_submodules(module, node.names))
    return aliases, found


def _submodules(module: str, names: list[ast.alias]) -> Iterator[tuple[str, str]]:
    for one in names:
        if _stub(f"{module}.{one.name}") is not None:
            yield one.asname or one.name, f"{module}.{one.name}"


def _lacking(module: str) -> set[str]:
    there = [_is_on(module, system) for system in SYSTEMS]
    return {module} if any(there) and not all(there) else set()


def _is_on(module: str, system: str) -> bool:
    return any(not name.startswith("_") for name in names_of(module, system))
