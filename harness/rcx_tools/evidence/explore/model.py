"""Models: a program with a few blocks, and all possible actions of its environment."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import NamedTuple

from rcx_harness.spec.wire import ABNORMAL_END, NORMAL_END, READY, RUN

__all__ = ["DOWN", "SKIPPED", "UP", "Block", "Choice", "Model", "Quiet", "Situation", "Wire"]

#: Treatment of a block in a scan: Execute or Enable is FALSE (DOWN) or TRUE (UP), or the block is
#: not called (SKIPPED).
DOWN, UP, SKIPPED = 0, 1, 2


@dataclass(frozen=True)
class Block:
    """An instance of a block in a model.

    Attributes:
        name: Name of the instance.
        type: Type of the block.
        pins: The other arguments of the call, as text.
        kind: The kind of block, which decides how the oracle judges the block: `command`, `jog`,
            `continuous`, `sequence`, `emergency`, `release emergency`, `stop`, `release stop`,
            `level` or `job`.
        code: Code of the remote command.
        bits: Numbers of the dedicated inputs that the block switches on (SI(12), octal, is bit 10).
        answer: For a sequence block: mask and value of the dedicated outputs that confirm the
            input.
        does: The values out of DOWN, UP, SKIPPED that the environment may choose.
    """

    name: str
    type: str
    pins: str = ""
    kind: str = "command"
    code: int = 0
    bits: tuple[int, ...] = ()
    answer: tuple[int, int] = (0, 0)
    does: tuple[int, ...] = (DOWN, UP, SKIPPED)

    @property
    def start(self) -> str:
        """Return the name of the pin that starts the block."""
        return "Enable" if self.kind in ("jog", "continuous", "level") else "Execute"

    @property
    def is_level(self) -> bool:
        """Return whether the block works as long as its pin is TRUE."""
        return self.start == "Enable"

    @property
    def channel(self) -> str:
        """Return the channel in which the block waits for its turn, or an empty text."""
        if self.kind in ("command", "jog", "continuous"):
            return "command"
        return "sequence" if self.kind in ("sequence", "release stop", "job") else ""


@dataclass(frozen=True, eq=False)
class Situation:
    """The values that the PLC reads in a scan.

    Two situations are equal only if they are the same object.

    Attributes:
        label: Description in words.
        connected: Connection status of the PLC's scanner.
        status: SOW(0).
        so: Dedicated outputs, bytes m + 32 and m + 33 as one word.
    """

    label: str
    connected: bool = True
    status: int = 0
    so: int = 0


class Wire(NamedTuple):
    """The values that the PLC has written in a scan."""

    code: int
    first: int
    """SIW(1)."""
    bits: int


class Choice(NamedTuple):
    """All values that the environment chooses for one scan."""

    number: int
    ticks: int
    situation: Situation
    emergency_ok: bool
    stop_ok: bool
    does: tuple[int, ...]
    image: bytes
    values: tuple[tuple[str, bool], ...]


class Quiet(NamedTuple):
    """An environment without new requests, for the proof that no block hangs.

    Attributes:
        title: Description in words.
        does: Treatment of all blocks: DOWN or SKIPPED.
        situation: Function that returns the label of the next situation from the values on the
            wire.
        idle_blocks: If TRUE, the end is reached when no block is busy. If FALSE, the channels must
            also be free.
        most: Limit of the scans until the end; 0 means no limit.
    """

    title: str
    does: int
    situation: Callable[[Wire], str]
    idle_blocks: bool = False
    most: int = 0


@dataclass(frozen=True)
class Model:
    """A program and its environment.

    Attributes:
        name: Short name.
        title: Subject of the model.
        blocks: The blocks in the order of their calls.
        situations: Situations that a scan can read. Any situation may follow any other.
        pins: Possible values of (EmergencyStopOk, StopOk).
        quiet: Environments in which all work must end.
        tick_ms: Unit of time [ms]. Every scan comes one of `gaps` ticks after the previous scan.
        gaps: Possible numbers of ticks between two scans.
        margin_ms: Value of the pin Margin of FB_WriteArea.
        longest_ms: The longest time of any timer.
        queue: Limit of the tickets on a channel. The ticket of a waiting block that gives up stays
            in the queue until its turn. Without a limit the number of states would be infinite.
        variables: Additional declarations of the program.
        statements: Additional statements at the start of the program.
        switches: Additional BOOL variables of the program that the environment sets, each with its
            possible values.
    """

    name: str
    title: str
    blocks: tuple[Block, ...]
    situations: tuple[Situation, ...]
    quiet: tuple[Quiet, ...]
    pins: tuple[tuple[bool, bool], ...] = ((True, True),)
    tick_ms: int = 50
    gaps: tuple[int, ...] = (1,)
    margin_ms: int = 0
    longest_ms: int = 200
    queue: int = 3
    variables: str = ""
    statements: str = ""
    switches: Mapping[str, tuple[bool, ...]] | None = None

    def program(self) -> str:
        """Return the ST program of the model."""
        held = "".join(f"    {one.name} : {one.type};\n" for one in self.blocks)
        names = [f"Go{one.name}" for one in self.blocks] + [
            f"Call{one.name}" for one in self.blocks
        ]
        names += list(self.switches or ())
        calls = "".join(
            f"  IF Call{one.name} THEN\n"
            f"    {one.name}({'' if one.kind == 'job' else 'Robot := Robot, '}"
            f"{one.start} := Go{one.name}{', ' if one.pins else ''}{one.pins});\n  END_IF;\n"
            for one in self.blocks
        )
        return (
            f"(* Exploration, model {self.name}: {self.title}. *)\n"
            "PROGRAM Explored\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n"
            f"    Connected, EmergencyStopOk, StopOk : BOOL;\n    {', '.join(names)} : BOOL;\n"
            "    CallRead, CallWrite : BOOL := TRUE;\n"
            "    Robot : RCX_REF;\n    ReadArea : FB_ReadArea;\n    WriteArea : FB_WriteArea;\n"
            f"{held}{self.variables}  END_VAR\n{self.statements}"
            "  IF CallRead THEN\n"
            "    ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);\n"
            f"  END_IF;\n{calls}"
            "  IF CallWrite THEN\n"
            "    WriteArea(Robot := Robot, Image := OutputArea, Interval := T#100ms,\n"
            f"              Margin := T#{self.margin_ms}ms, EmergencyStopOk := EmergencyStopOk,\n"
            "              StopOk := StopOk);\n  END_IF;\nEND_PROGRAM\n"
        )

    def free(self) -> set[str]:
        """Return the variables that are set before each scan or are only written."""
        names = {"InputArea", "OutputArea", "Connected", "EmergencyStopOk", "StopOk"}
        names |= {"CallRead", "CallWrite"}
        names |= {f"{what}{one.name}" for one in self.blocks for what in ("Go", "Call")}
        return names | set(self.switches or ())

    def choices(self) -> list[Choice]:
        """Return all choices of the environment for one scan."""
        switches = self.switches or {}
        found: list[Choice] = []
        for gap, situation, pins, does, values in product(
            self.gaps,
            self.situations,
            self.pins,
            product(*(one.does for one in self.blocks)),
            product(*switches.values()),
        ):
            extra = tuple(zip(switches, values, strict=True))
            found.append(self._choice(len(found), gap, situation, pins, does, extra))
        return found

    def _choice(
        self,
        number: int,
        gap: int,
        situation: Situation,
        pins: tuple[bool, bool],
        does: tuple[int, ...],
        extra: Sequence[tuple[str, bool]],
    ) -> Choice:
        image = bytearray(34)
        if situation.connected:
            image[0:2] = situation.status.to_bytes(2, "little")
            image[2:4] = response(situation.status).to_bytes(2, "little")
            image[32:34] = situation.so.to_bytes(2, "little")
        values = [("CONNECTED", situation.connected), ("CALLREAD", True), ("CALLWRITE", True)]
        values += [("EMERGENCYSTOPOK", pins[0]), ("STOPOK", pins[1])]
        for block, do in zip(self.blocks, does, strict=True):
            values.append((f"CALL{block.name.upper()}", do != SKIPPED))
            if do != SKIPPED:
                values.append((f"GO{block.name.upper()}", do == UP))
        values += [(name.upper(), value) for name, value in extra]
        return Choice(number, gap, situation, *pins, does, bytes(image), tuple(values))

    def tell(self, choice: Choice) -> str:
        """Return a description of a choice in words."""
        parts = [choice.situation.label]
        parts += [
            f"{block.name} {'not called' if do == SKIPPED else 'up' if do == UP else 'down'}"
            for block, do in zip(self.blocks, choice.does, strict=True)
        ]
        if len(self.pins) > 1:
            parts += [
                f"{name} {'ON' if value else 'OFF'}"
                for name, value in (("E", choice.emergency_ok), ("S", choice.stop_ok))
            ]
        parts += [f"{name} {value}" for name, value in choice.values if name in self.switch_names()]
        if choice.ticks != 1:
            parts.append(f"{choice.ticks} ticks later")
        return ", ".join(parts)

    def switch_names(self) -> set[str]:
        """Return the names of the model's additional BOOL variables, in upper case."""
        return {name.upper() for name in self.switches or ()}

    def write(self, folder: Path) -> Path:
        """Write the program of the model into a folder."""
        path = folder / f"{self.name}.st"
        path.write_text(self.program(), encoding="utf-8")
        return path


def response(status: int) -> int:
    """Return SOW(1) for a status.

    Each status has its own value, so that a late copy of the response is detected.
    """
    return {READY: 0, RUN: 0, NORMAL_END: 0x1234, ABNORMAL_END: 12}[status]
