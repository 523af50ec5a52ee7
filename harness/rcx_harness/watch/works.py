"""Two blocks that send several commands to one robot, and that can run at the same time.

Such a block relies on the position in which its last command has left the robot. If a second block
works in between, one of them ends with 16#805D (docs/explanation/scan-model.md, two blocks on one
robot). A finding needs evidence: both starts depend only on variables that the program never
writes, such as push buttons.
"""

from __future__ import annotations

from collections.abc import Iterator

from rcx_harness.watch.robots_used import Call, Robot, RobotsUsed
from structured_text.language import tree as t

__all__ = ["mixing_works"]

#: Blocks that send several commands (docs/explanation/scan-model.md).
_WORKS = ("FB_MOVETABLE", "FB_PICKPLACE")
#: A condition of a start: a variable, and the value that it needs.
_Start = frozenset[tuple[object, bool]]


def mixing_works(robot: Robot, used: RobotsUsed) -> Iterator[tuple[Call, Call]]:
    """Yield each call that can start while the block of an earlier call works, with this call."""
    works = [call for call in robot.calls if call.block.name.upper() in _WORKS]
    starts = [(call, _start(call, used)) for call in works]
    for place, (call, start) in enumerate(starts):
        for earlier, other in starts[:place]:
            if start is None or other is None or earlier.instance == call.instance:
                continue
            number = _robot_number(call)
            same = number is not None and number == _robot_number(earlier)
            if same and not _exclude(start, other):
                yield call, earlier
                break


def _exclude(one: _Start, other: _Start) -> bool:
    """Return whether a variable must be TRUE for one start and FALSE for the other."""
    return any((place, not value) in other for place, value in one)


def _start(call: Call, used: RobotsUsed) -> _Start | None:
    """Return the conditions of `Execute`; None if the source does not decide them."""
    given = [value for name, value in call.node.inputs if name.upper() == "EXECUTE"]
    if not given or (call.block.name.upper(), "EXECUTE") in used.set_apart:
        return None
    found: set[tuple[object, bool]] = set()
    waiting = [(given[0], True)]
    while waiting:
        value, wanted = waiting.pop()
        if isinstance(value, t.Binary) and value.op in ("AND", "&") and wanted:
            waiting += [(value.left, True), (value.right, True)]
        elif isinstance(value, t.Unary) and value.op == "NOT":
            waiting.append((value.operand, not wanted))
        elif (place := used.input_place(value, call.frame)) is not None:
            found.add((place, wanted))
        else:
            return None
    return frozenset(found)


def _robot_number(call: Call) -> int | None:
    """Return the number of the robot; None if the source does not decide it."""
    for name, value in call.node.inputs:
        if name.upper() == "ROBOTNUMBER":
            return max(1, int(value.value)) if isinstance(value, t.Constant) else None
    return 1
