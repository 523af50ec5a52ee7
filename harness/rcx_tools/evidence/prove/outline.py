"""Blocks whose proofs use the proofs of the blocks inside them (assume-guarantee).

If users can also call an inner block, its call is not executed. The proof only assumes the
`guarantee` that is proved for the inner block. The instance and its telegram get arbitrary values.
The solver can therefore handle blocks with many inner blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import z3

from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.standard import BLOCKS
from structured_text.prove.logic import Bool, both
from structured_text.prove.machine import Call, Machine
from structured_text.prove.symbolic_memory import Alternatives, Leaf, Path
from structured_text.prove.values import Value

__all__ = [
    "ANY",
    "ASKS",
    "COMMAND_RUN",
    "OUTLINED",
    "RELEASES",
    "REQUESTS",
    "Outline",
    "Outlined",
    "is_outside",
    "law_of",
]

#: Blocks with many inner blocks. Their proofs use the proofs of the inner blocks.
OUTLINED = ("FB_MOVETABLE", "FB_PICKPLACE", "FB_WORKCYCLE")
#: Position of PHASE_COMMAND_RUN in RCX_PHASE.
COMMAND_RUN = 3
#: Dedicated inputs that a block may request, as bits of bytes n + 32 and n + 33 (chapter 5, 1):
#: SI(01), SI(10), SI(12), SI(14), SI(15), SI(16), SI(17). SI(00) and SI(06) are levels.
_SERVO_ON, _SEQUENCE, _START, _INCREMENTAL = 1 << 1, 1 << 8, 1 << 10, 1 << 12
_PROGRAM_RESET, _ALARM_RESET, _ABSOLUTE = 1 << 13, 1 << 14, 1 << 15
REQUESTS = {
    "FB_SERVOON": _SERVO_ON,
    "FB_SERVOONFROMEMERGENCYSTOP": _SERVO_ON | _ALARM_RESET,
    "FB_POWERUP": _SERVO_ON | _ALARM_RESET | _PROGRAM_RESET | _START,
    "FB_WORKCYCLE": _SERVO_ON | _ALARM_RESET | _PROGRAM_RESET | _START,
    "FB_ALARMRESET": _ALARM_RESET,
    "FB_AUTOSTART": _START,
    "FB_PROGRAMCONTINUE": _START,
    "FB_PROGRAMRESET": _PROGRAM_RESET,
    "FB_RETURNTOORIGIN": _INCREMENTAL | _ABSOLUTE,
    "FB_SEQUENCECONTROL": _SEQUENCE,
}
#: FB_Operator contains blocks for all inputs that FB_PowerUp requests.
REQUESTS["FB_OPERATOR"] = REQUESTS["FB_POWERUP"]
ANY = _SERVO_ON | _SEQUENCE | _START | _INCREMENTAL | _PROGRAM_RESET | _ALARM_RESET | _ABSOLUTE
#: Fields that blocks may write freely: turns (the properties turn-... are about them), holds (see
#: RELEASES), and numbers of the robots that work or carry a part.
_FREE = ("COMMAND", "SEQUENCE", "HOLDEMERGENCY", "HOLDSTOP", "WORKS", "WORKED", "CARRIES")
#: Flags of a scan. Blocks may only set them, and only FB_WriteArea clears them.
_RISING = ("KEEPEMERGENCY", "KEEPSTOP", "STOPJOG", "CODEREQUEST")
#: Fields with requests and turns. A call outside of a scan does not change them (property `place`).
ASKS = ("COMMAND", "SEQUENCE", "CODE", "DATA", "CODEREQUEST", "REQUEST")
#: Maps a hold of SI(00) or SI(06) to the block that releases it on a rising edge.
RELEASES = {"HOLDEMERGENCY": "FB_SERVOONFROMEMERGENCYSTOP", "HOLDSTOP": "FB_PROGRAMCONTINUE"}


def law_of(path: Path) -> str:
    """Return the rule for a scalar of RCX_REF, by its path in the structure.

    "free": any change is legal. "rising": blocks may only set the scalar. "request": a block may
    only set its own inputs. "telegram": no change while a command is sent. "kept": no change.
    """
    name = path[1] if path[0] == "INNER" else ""
    if name in _FREE or (name == "GENERAL" and path[2] > 0):
        return "free"
    if name in _RISING:
        return "rising"
    if name == "REQUEST":
        return "request"
    return "telegram" if name in ("CODE", "DATA") else "kept"


def is_outside(project: Project, block: str) -> bool:
    """Return whether users call the block between FB_ReadArea and FB_WriteArea.

    The guarantee is proved for such blocks.
    """
    name = block.upper()
    if name.startswith("FB_RCX") or block in BLOCKS:
        return False
    pou = project.pous[name]
    return "ROBOT" in [symbol.name.upper() for symbol in pou.section("VAR_IN_OUT")]


@dataclass(frozen=True)
class Outlined:
    """A call that was replaced by the guarantee of its block, with the memory around it."""

    instance: Path
    block: str
    when: Bool
    before: dict[Path, Value]
    after: dict[Path, Value]


class Outline(Machine):
    """A machine that replaces calls of inner blocks by their guarantees.

    Only inner blocks that users can also call are replaced.

    Attributes:
        outlined: All calls that were replaced.
    """

    def __init__(
        self,
        project: Project,
        summaries: Mapping[str, Callable[[Machine, list[Value]], Value]] | None = None,
    ) -> None:
        super().__init__(project, summaries)
        self.outlined: list[Outlined] = []

    def call_block(
        self, instance: Path, block: str, in_outs: Mapping[str, Path | Alternatives]
    ) -> None:
        """Run a block, or replace the call by the guarantee of the block."""
        if not self._frames or not is_outside(self.project, block):
            super().call_block(instance, block, in_outs)
            return
        # The body is not executed. Instead, instance and VAR_IN_OUTs become arbitrary, and RCX_REF
        # changes as far as `law_of` permits. The call is recorded with the memory before and after
        # it, because `restart.known` adds the promises of the block about these two states.
        # `when` is the condition of the path that makes the call.
        when = both(*self._guards)
        self.calls.append(Call(instance, block, when))
        before = self.snapshot()
        pou = self.project.pous[block.upper()]
        self._become_anything(instance, pou)
        for symbol in pou.section("VAR_IN_OUT"):
            places = in_outs[symbol.name.upper()]
            for _, path in places if isinstance(places, list) else [(True, places)]:
                if symbol.name.upper() != "ROBOT":
                    self.havoc(path, symbol.type)
                    continue
                for leaf in self.leaves(symbol.type):
                    self._do(block.upper(), path, leaf)
        self.outlined.append(Outlined(instance, block.upper(), when, before, self.snapshot()))

    def _become_anything(self, instance: Path, pou: t.Pou) -> None:
        """Make all variables of an instance arbitrary, except its inputs."""
        assert pou.block is not None
        given = {
            path: self[path]
            for symbol in pou.section("VAR_INPUT")
            for leaf in self.leaves(symbol.type)
            for path in [(*instance, symbol.name.upper(), *leaf.suffix)]
        }
        self.havoc(instance, pou.block)
        for path, value in given.items():
            self[path] = value

    def _do(self, block: str, robot: Path, leaf: Leaf) -> None:
        """Apply the guarantee of a block to one scalar of RCX_REF."""
        path, law = robot + leaf.suffix, law_of(leaf.suffix)
        if law == "kept":
            return
        was = self.term(path)
        self.havoc(path, leaf.type)
        new = self.term(path)
        if leaf.suffix[1] in (*ASKS, *RELEASES):
            placed = self.term((*robot, "INNER", "INSCAN"))
            rises = z3.Or(was, new) if leaf.suffix[1] in RELEASES else was
            new = z3.If(placed, new, rises)
            self[path] = new
        if leaf.suffix[1] in RELEASES and RELEASES[leaf.suffix[1]] != block:
            law = "rising"
        if law == "rising":
            self[path] = z3.Or(was, new)
        elif law == "request":
            self[path] = was | new & z3.BitVecVal(REQUESTS.get(block, 0), was.size())
        elif law == "telegram":
            runs = self.term((*robot, "INNER", "PHASE")) == COMMAND_RUN
            self[path] = z3.If(runs, was, new)
