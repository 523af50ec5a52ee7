"""A check of block calls in the source: their number and their order.

A block that takes a `Robot : RCX_REF`, or contains such blocks, remembers the state of its last
call. It needs exactly one call in each scan, always for the same robot, between FB_ReadArea and
FB_WriteArea. If a block that requests something from the robot is called elsewhere, it ends with
16#8017. Blocks that read or write one bit or word of an image have no memory, so they may be called
anywhere.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from structured_text.language import cache
from structured_text.language import syntax as s
from structured_text.language.walk import bodies, statements

__all__ = ["AREAS", "CallFinding", "CallPlan", "call_findings", "call_plan", "steady_instances"]

_HERE = Path(__file__)

#: The blocks that begin and end a robot's scan.
AREAS = {
    "FB_READAREA": "read",
    "FB_READAREAWORDS": "read",
    "FB_WRITEAREA": "write",
    "FB_WRITEAREAWORDS": "write",
}
_OWNERS = ("PROGRAM", "FUNCTION_BLOCK")
_REF, _IMAGES = "RCX_REF", ("RCX_IMAGE", "RCX_IMAGE_WORDS")
_STARTS = ("EXECUTE", "ENABLE")
#: Blocks of the library with two intended calls in a scan.
_TWICE = ("FB_RCXCLAIM",)
#: A block requests something from the robot if it is one of these blocks or contains one. The stop
#: blocks stop the robot even outside of the two area blocks.
_ASKING = ("FB_RCXJOB", "FB_SEQUENCECONTROL")
_STOPPING = ("FB_EMERGENCYSTOP", "FB_PROGRAMSTOP")


class CallFinding(NamedTuple):
    """A wrong call of a block.

    Attributes:
        certain: Whether the call fails each time that it runs; otherwise this depends on
            conditions.
        kind: The section of docs/how-to/first-mistakes.md that explains it.
    """

    file: Path
    at: s.Position
    text: str
    certain: bool
    kind: str = "called-out-of-place"


class CallPlan(NamedTuple):
    """The calls to watch at run time, because the source does not decide them.

    Attributes:
        blocks: Types to watch, in upper case, with the index of the RCX_REF among their VAR_IN_OUT;
            None for a block that declares its robots itself.
        owners: The user's programs and blocks, by type in upper case, with the watched instances in
            each. Empty if every call is certain and nothing needs watching.
    """

    blocks: dict[str, int | None]
    owners: dict[str, frozenset[str]]


def call_findings(files: Sequence[Path], library: Sequence[Path] = ()) -> list[CallFinding]:
    """Check the calls in a program's own files.

    The files must be free of errors; `library` has the files of the blocks that they use.
    """
    every = (*files, *library)
    found = cache.made_of("called", _key(files, library), every, lambda: _findings(files, library))
    return list(found)


def _findings(files: Sequence[Path], library: Sequence[Path]) -> list[CallFinding]:
    blocks = _blocks([*files, *library])
    return [
        finding
        for file in files
        for owner in _owners(file)
        for finding in _Calls(file, owner, blocks).findings()
    ]


def _key(files: Sequence[Path], library: Sequence[Path]) -> str:
    """Return a cache key of all files.

    This module is part of the key, because the result depends on its code. It also separates the
    user's files from the files of the library.
    """
    return cache.sources_key((*files, _HERE, *library))


def call_plan(files: Sequence[Path], library: Sequence[Path] = ()) -> CallPlan:
    """Return the calls that the source does not decide; arguments as in `call_findings`."""
    key = _key(files, library)
    return cache.made_of("calls", key, (*files, *library), lambda: _plan(files, library))


def _plan(files: Sequence[Path], library: Sequence[Path]) -> CallPlan:
    blocks = _blocks([*files, *library])
    called = [_Calls(file, owner, blocks) for file in files for owner in _owners(file)]
    if not any(calls.findings() or calls.varies for calls in called):
        return CallPlan({}, {})
    owners = {calls.owner.name.key: frozenset(calls.called) for calls in called}
    used = {kind for calls in called for kind in calls.kinds}
    return CallPlan({kind: blocks[kind].place for kind in sorted(used)}, owners)


def steady_instances(files: Sequence[Path], library: Sequence[Path] = ()) -> set[str]:
    """Find the instances whose calls and Execute are certain from the source.

    With several programs or tasks the result is empty, since not every program runs in every scan.
    An instance qualifies if its owner (a program or block) calls it exactly once, at the top level
    of its body and before any RETURN. No statement after that call may assign its Execute or
    Enable.

    Returns:
        Names as `OWNER.INSTANCE` in upper case, with the name of the owner's type.
    """
    every = (*files, *library)
    key = cache.sources_key((*every, _HERE))
    return cache.made_of("steady", key, every, lambda: _instances(every))


@dataclass(frozen=True)
class _Block:
    """A type of block.

    Attributes:
        name: The name of the type in upper case.
        pin: The block's VAR_IN_OUT of type RCX_REF, in upper case; empty if there is none.
        place: Index of `pin` among the VAR_IN_OUT.
        watched: Whether the block needs exactly one call in each scan.
        works: Whether the block has an Execute or Enable, is an area block, or contains such
            blocks.
        asks: Whether the block requests something from the robot. A call outside of the area blocks
            then fails.
    """

    name: str
    pin: str
    place: int | None
    watched: bool
    works: bool
    asks: bool


def _declarations(file: Path) -> tuple[s.Declaration, ...]:
    from structured_text.language.parser import parse  # imported only if there is no cached answer

    return parse(file).declarations


def _owners(file: Path) -> Iterator[s.Pou]:
    for one in _declarations(file):
        if isinstance(one, s.Pou) and one.kind in _OWNERS:
            yield one


def _blocks(files: Sequence[Path]) -> dict[str, _Block]:
    """Return the types of blocks by name, with the properties inherited from blocks inside."""
    pous = [pou for file in files for pou in _owners(file) if pou.kind == "FUNCTION_BLOCK"]
    found = {pou.name.key: _block(pou) for pou in pous}
    inside = {pou.name.key: {kind for _, kind in _variables(pou, "VAR")} for pou in pous}
    more = True
    while more:
        more = False
        for name, kinds in inside.items():
            block = found[name]
            parts = [found[kind] for kind in kinds if kind in found]
            works = any(part.watched and part.works for part in parts)
            whole = replace(
                block,
                watched=block.watched or works,
                works=block.works or works,
                asks=block.asks or any(part.asks for part in parts),
            )
            if whole != block:
                found[name] = whole
                more = True
    return found


def _block(pou: s.Pou) -> _Block:
    in_outs = list(_variables(pou, "VAR_IN_OUT"))
    refs = [place for place, (_, kind) in enumerate(in_outs) if kind == _REF]
    pin, place = (in_outs[refs[0]][0], refs[0]) if refs else ("", None)
    area = pou.name.key in AREAS
    passing = any(kind in _IMAGES for _, kind in in_outs) and not area
    starts = any(name in _STARTS for name, _ in _variables(pou, "VAR_INPUT"))
    watched = bool(refs) and (starts or not passing) and pou.name.key not in _TWICE
    asks = pou.name.key in _ASKING
    return _Block(pou.name.key, pin, place, watched, watched and (starts or area), asks)


def _variables(pou: s.Pou, kind: str) -> Iterator[tuple[str, str]]:
    """Yield names and types of a kind of variables, in upper case."""
    for section in pou.sections:
        if section.kind == kind:
            for one in section.variables:
                spec = one.spec.name.key if isinstance(one.spec, s.NamedSpec) else ""
                yield from ((name.key, spec) for name in one.names)


class _Call(NamedTuple):
    """A call statement: its instance and robot, and the branches around it."""

    at: s.Position
    name: str
    block: _Block
    robot: str
    guards: tuple[int, ...]
    loop: bool

    @property
    def key(self) -> str:
        """Return the robot's name for comparisons."""
        return self.robot.upper()


#: The calls on one path through the body: by instance, or by area and robot.
_Way = dict[tuple[str, str], tuple[_Call, ...]]


@dataclass
class _Calls:
    """The calls in one program or block.

    Attributes:
        blocks: All types of blocks.
        called: The watched instances of the program or block, in upper case.
        varies: Whether an index that is not constant selects a robot.
    """

    file: Path
    owner: s.Pou
    blocks: dict[str, _Block]
    called: set[str] = field(default_factory=set)
    kinds: set[str] = field(default_factory=set)
    varies: bool = False

    def __post_init__(self) -> None:
        self._types = {
            name: kind
            for section in ("VAR", "VAR_EXTERNAL", "VAR_IN_OUT")
            for name, kind in _variables(self.owner, section)
        }
        self._found: dict[tuple[s.Position, str], CallFinding] = {}
        self._robots: dict[str, _Call] = {}
        self._exits: list[list[_Way]] = []
        self._branches = 0
        self._returned = False
        self._reads: dict[str, s.CallStatement] = {}
        for call, block in self._all(self.owner.body):
            if AREAS.get(block.name) == "read":
                self._reads.setdefault(_text(_argument(call, block)).upper(), call)
        self._run(self.owner.body, {}, (), loop=False)

    def findings(self) -> list[CallFinding]:
        """Return the findings, in the order of the lines."""
        return sorted(self._found.values(), key=lambda one: one.at)

    # --- paths through the body ---

    def _run(
        self, body: Iterable[s.Statement], way: _Way, guards: tuple[int, ...], *, loop: bool
    ) -> _Way | None:
        """Follow statements; return the calls at their end, or None if no path leads there.

        Each path has the list of calls made on it so far. An IF or CASE splits the path, and the
        branches merge after it. A loop body is one branch; its EXIT paths merge after the loop.
        RETURN and EXIT end the path. `guards` are the numbers of the branches around the
        statements.
        """
        for one in body:
            if isinstance(one, s.CallStatement):
                block = self._called(one)
                if block is not None:
                    way = self._call(one, block, way, guards, loop)
            elif isinstance(one, (s.If, s.Case)):
                after = [self._branch(inner, way, guards, loop) for inner in bodies(one)]
                live = [end for end in after if end is not None]
                if not live:
                    return None
                way = _joined(live)
            elif isinstance(one, (s.For, s.While, s.Repeat)):
                self._exits.append([])
                end = self._branch(one.body, way, guards, loop=True)
                ways = [*self._exits.pop(), *([end] if end is not None else []), way]
                way = _joined(ways)
            elif isinstance(one, s.Exit):
                self._exits[-1].append(way)
                return None
            elif isinstance(one, s.Return):
                self._returned = True
                return None
        return way

    def _branch(
        self, body: Iterable[s.Statement], way: _Way, guards: tuple[int, ...], loop: bool
    ) -> _Way | None:
        self._branches += 1
        return self._run(body, way, (*guards, self._branches), loop=loop)

    def _called(self, one: s.CallStatement) -> _Block | None:
        """Return the watched type that a statement calls, or None."""
        if not isinstance(one.callee, s.Name):
            return None
        block = self.blocks.get(self._types.get(one.callee.key, ""))
        return block if block is not None and block.watched else None

    def _all(self, body: Iterable[s.Statement]) -> Iterator[tuple[s.CallStatement, _Block]]:
        for one in statements(body):
            if isinstance(one, s.CallStatement) and (block := self._called(one)) is not None:
                yield one, block

    # --- checks of one call ---

    def _call(
        self, one: s.CallStatement, block: _Block, way: _Way, guards: tuple[int, ...], loop: bool
    ) -> _Way:
        assert isinstance(one.callee, s.Name)
        name = one.callee.text
        call = _Call(one.at, name, block, _text(_argument(one, block)), guards, loop)
        self.called.add(name.upper())
        self.kinds.add(block.name)
        self.varies = self.varies or _varies(_argument(one, block))
        self._once(call, way)
        self._one_robot(call)
        area = AREAS.get(block.name, "")
        self._order(call, area, way)
        if block.works and not loop and (guards or self._returned):
            why = "after a RETURN that may come first" if not guards else "only under a condition"
            self._tell(
                call,
                f"{name} is called {why}: a block that is skipped while it is busy loses its turn "
                "(16#8013); call it in every scan and switch its Execute or Enable",
                certain=False,
                kind="call-under-a-condition",
            )
        keys = [("", name.upper()), *([(area, call.key)] if area else [])]
        return {**way, **{key: (*way.get(key, ()), call) for key in keys}}

    def _once(self, call: _Call, way: _Way) -> None:
        """Report a second call of an instance, or a second block for an area of the robot."""
        if call.loop:
            text = f"{call.name} is called inside a loop; call it once per scan, outside"
            self._tell(call, text, kind="call-in-a-loop")
            return
        before = way.get(("", call.name.upper()), ())
        if before:
            self._tell(
                call,
                f"{call.name} is called a second time in a scan (first in line "
                f"{before[0].at.line}); call it once, with all its inputs",
                certain=_both_run(before, call),
                kind="called-twice",
            )
            return
        area = AREAS.get(call.block.name)
        others = way.get((area, call.key), ()) if area else ()
        if others:
            self._tell(
                call,
                f"{call.name} is a second block that {area}s the area of {call.robot} in a scan "
                f"(the first is {others[0].name} in line {others[0].at.line}); one for each robot",
                certain=_both_run(others, call),
                kind="called-twice",
            )

    def _one_robot(self, call: _Call) -> None:
        first = self._robots.setdefault(call.name.upper(), call)
        if first.key != call.key:
            self._tell(
                call,
                f"{call.name} is used for {call.robot} here and for {first.robot} in line "
                f"{first.at.line}; declare an instance for each robot",
                kind="several-robots",
            )

    def _order(self, call: _Call, area: str, way: _Way) -> None:
        """Report calls before the read or after the write of the robot's area."""
        if not call.block.works or call.loop:
            return
        written = way.get(("write", call.key), ())
        read = self._reads.get(call.key)
        refused = "it ends with 16#8017 (Called out of place) and nothing is executed"
        if call.block.name in _STOPPING:
            refused = "it ends with 16#8017 (Called out of place), although it stops the robot"
        if written and area == "read":
            self._tell(
                call,
                f"{call.name} is called after {written[0].name} in line {written[0].at.line}: "
                f"the area is used only in the next scan; call FB_ReadArea first",
                certain=_both_run(written, call),
            )
        elif written and call.block.asks:
            self._tell(
                call,
                f"{call.name} is called after {written[0].name} in line {written[0].at.line}: "
                f"{refused}; move the call in front of that line",
                certain=_both_run(written, call),
            )
        elif area != "read" and read is not None and ("read", call.key) not in way:
            # If the body writes before it reads, a block in front of both belongs to the scan of
            # the last read.
            late = "it sees the scan before; call FB_ReadArea first"
            if call.block.asks and not self._is_written_before(read, call.key):
                late = f"{refused}; move the call behind {_name(read)} in line {read.at.line}"
            self._tell(
                call, f"{call.name} is called before the area of {call.robot} is read: {late}"
            )

    def _is_written_before(self, read: s.CallStatement, robot: str) -> bool:
        """Return whether the body writes the robot's area before it reads it."""
        return any(
            AREAS.get(block.name) == "write"
            and call.at < read.at
            and _text(_argument(call, block)).upper() == robot
            for call, block in self._all(self.owner.body)
        )

    def _tell(
        self,
        call: _Call,
        text: str,
        *,
        certain: bool = True,
        kind: str = "called-out-of-place",
    ) -> None:
        found = CallFinding(self.file, call.at, text, certain, kind)
        self._found.setdefault((call.at, text), found)


def _joined(ways: Sequence[_Way]) -> _Way:
    """Merge paths: for each key, keep the longest list of possible calls."""
    keys = dict.fromkeys(key for way in ways for key in way)
    return {key: max((way.get(key, ()) for way in ways), key=len) for key in keys}


def _both_run(before: Sequence[_Call], call: _Call) -> bool:
    """Return whether the branches allow that `call` and a call of `before` run in the same scan."""
    pairs = [(one.guards, call.guards) for one in before]
    return any(a == b[: len(a)] or b == a[: len(b)] for a, b in pairs)


def _argument(one: s.CallStatement, block: _Block) -> s.Expression | None:
    """Return the argument for the block's robot, or None."""
    for argument in one.arguments:
        if argument.name is not None and argument.name.key == block.pin:
            return argument.value
    return None


def _name(one: s.CallStatement) -> str:
    """Return the name of the called instance."""
    return one.callee.text if isinstance(one.callee, s.Name) else ""


def _varies(node: s.Expression | None) -> bool:
    """Return whether the expression is an array element with a non-constant index."""
    if isinstance(node, s.Field):
        return _varies(node.base)
    return isinstance(node, s.Index) and not all(isinstance(i, s.Literal) for i in node.indices)


def _text(node: object) -> str:
    if isinstance(node, (s.Name, s.Literal)):
        return node.text
    if isinstance(node, s.Field):
        return f"{_text(node.base)}.{node.name.text}"
    if isinstance(node, s.Index):
        return f"{_text(node.base)}[{', '.join(map(_text, node.indices))}]"
    return ""


def _instances(files: Sequence[Path]) -> set[str]:
    declared = [entry for file in files for entry in _declarations(file)]
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
        for inner in statements([statement]):
            calls.update(_called(inner))
            if isinstance(inner, s.Return):
                returned = True
            elif isinstance(inner, s.Assign):
                late |= _start_of(inner.target) & top
    return {name for name in top if calls[name] == 1 and name not in late}


def _called(statement: s.Statement) -> set[str]:
    """Return the instance that this statement itself calls."""
    if isinstance(statement, s.CallStatement) and isinstance(statement.callee, s.Name):
        return {statement.callee.key}
    return set()


def _start_of(target: s.Variable) -> set[str]:
    """Return `SERVO` for an assignment to `Servo.Execute`."""
    if not isinstance(target, s.Field) or target.name.key not in _STARTS:
        return set()
    return {target.base.key} if isinstance(target.base, s.Name) else set()
