"""Which blocks are called exactly once whenever their owner is, read from the source."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from rcx_harness.engine import cache
from rcx_harness.engine.cache import is_lasting
from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.parser import parse

__all__ = ["bodies_of", "steady_instances"]

_OWNERS = ("PROGRAM", "FUNCTION_BLOCK")
_STARTS = ("EXECUTE", "ENABLE")


def steady_instances(files: Sequence[Path], library: Sequence[Path] = ()) -> set[str]:
    """Find the instances whose every call and whose Execute can be known from outside.

    Where there are several programs or tasks none is named, since not every program runs in
    every scan. An instance counts if its owner, program or block, calls it once, at the top
    level of its body, before any RETURN, and if nothing assigns its Execute or Enable after
    that call.

    Args:
        files: The program's own files, free of errors.
        library: The files of the blocks that it uses.

    Returns:
        Names as `OWNER.INSTANCE` in upper case, with the name of the owner's type.
    """
    key = cache.sources_key((*files, *library))
    lasting = key if is_lasting((*files, *library)) else ""

    def kept() -> set[str]:
        return cache.kept("steady", lasting, lambda: _instances((*files, *library)))

    return cache.remembered("steady", key, kept)


def _instances(files: Sequence[Path]) -> set[str]:
    declared = [entry for file in files for entry in parse(file).declarations]
    owners = [one for one in declared if isinstance(one, s.Pou) and one.kind in _OWNERS]
    tasks = [task for one in declared if isinstance(one, s.Configuration) for task in one.tasks]
    if sum(owner.kind == "PROGRAM" for owner in owners) != 1 or len(tasks) > 1:
        return set()
    return {f"{owner.name.key}.{name}" for owner in owners for name in _steady(owner.body)}


def _steady(body: tuple[s.Statement, ...]) -> set[str]:
    calls: Counter[str] = Counter()
    top: set[str] = set()
    late: set[str] = set()
    returned = False
    for statement in body:
        if not returned:
            top |= _called(statement)
        for inner in _flat(statement):
            calls.update(_called(inner))
            if isinstance(inner, s.Return):
                returned = True
            elif isinstance(inner, s.Assign):
                late |= _start_of(inner.target) & top
    return {name for name in top if calls[name] == 1 and name not in late}


def _called(statement: s.Statement) -> set[str]:
    """The instance that this very statement calls."""
    if isinstance(statement, s.CallStatement) and isinstance(statement.callee, s.Name):
        return {statement.callee.key}
    return set()


def _start_of(target: s.Variable) -> set[str]:
    """`SERVO` for an assignment to `Servo.Execute`."""
    if not isinstance(target, s.Field) or target.name.key not in _STARTS:
        return set()
    return {target.base.key} if isinstance(target.base, s.Name) else set()


def _flat(statement: s.Statement) -> Iterator[s.Statement]:
    """The statement and all inside it, in the order of the text."""
    yield statement
    for body in bodies_of(statement):
        for inner in body:
            yield from _flat(inner)


def bodies_of(statement: s.Statement) -> list[tuple[s.Statement, ...]]:
    """The bodies inside a statement: of an IF or CASE one for each way, also an empty one."""
    if isinstance(statement, s.If):
        return [*(body for _, body in statement.branches), statement.otherwise]
    if isinstance(statement, s.Case):
        return [*(branch.body for branch in statement.branches), statement.otherwise]
    if isinstance(statement, (s.For, s.While, s.Repeat)):
        return [statement.body]
    return []
