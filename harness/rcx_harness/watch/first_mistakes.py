"""The most frequent first mistakes of a program, found in its checked source.

All of them are legal Structured Text: the program runs, but its robot does nothing. They are: no
FB_ReadArea or no FB_WriteArea for a robot, a required pin that is not wired, a block that is used
but never called, a robot that a block takes as a copy, two blocks that can work with one robot at
the same time. All findings are warnings. Nothing is
reported if the source does not decide whether it is a mistake. An example is a robot behind a
pointer or an index that is not constant.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from rcx_harness.watch.calls_source import AREAS
from rcx_harness.watch.robots_used import Call, Robot, RobotsUsed, pins_of, robot_pins
from rcx_harness.watch.time_pins import MARGIN, TIMEOUT, TimePin, time_of
from rcx_harness.watch.works import mixing_works
from structured_text.errors import place_text
from structured_text.language import cache
from structured_text.language.checked import analysed
from structured_text.language.project import Project
from structured_text.language.syntax import Position
from structured_text.language.types import BlockType

__all__ = ["Mistake", "first_mistakes", "time_pins"]

_NAMES = ("first_mistakes.py", "robots_used.py", "time_pins.py", "works.py")
_FILES = tuple(Path(__file__).with_name(name) for name in _NAMES)

#: Blocks that switch servos on. They need SI(00) (manual chapter 5, 3.1).
_SERVOS = ("FB_SERVOON", "FB_SERVOONFROMEMERGENCYSTOP", "FB_POWERUP", "FB_SERVO", "FB_MOTORPOWER")
#: Blocks that move the robot or start its program. They need SI(00) and SI(06) (chapter 5, 2 and
#: 3.2).
_MOVES = (
    "FB_ABSOLUTERESETMOVEMENT",
    "FB_AUTOSTART",
    "FB_INCHING",
    "FB_JOG",
    "FB_PICKPLACE",
    "FB_PROGRAMCONTINUE",
    "FB_RETURNTOORIGIN",
    "FB_RETURNTOORIGINAXIS",
    "FB_RETURNTOORIGINROBOT",
    "FB_WORKCYCLE",
)
_MOVES_BEGIN = ("FB_MOVE", "FB_DRIVE", "FB_PUSH", "FB_PALLETMOVE")
#: Blocks without Execute that send something to the controller.
_SENDING = ("FB_CONTINUOUSPOSITION", "FB_OPERATOR", "FB_OVERRIDE", "FB_SEQUENCECONTROL")
#: For each area block: the wrong image, the right image, and the consequence of the mistake.
_OTHER_IMAGE = {
    "read": (
        "OutputArea",
        "InputArea",
        "reads OutputArea, which is the area to the controller: it never sees the controller",
    ),
    "write": (
        "InputArea",
        "OutputArea",
        "writes into InputArea, which is the area from the controller: nothing reaches the "
        "controller",
    ),
}


class Mistake(NamedTuple):
    """A first mistake: its position in the source, its consequence, and the remedy.

    `kind` is the section of docs/how-to/first-mistakes.md that explains it.
    """

    file: Path
    at: Position
    text: str
    kind: str

    def __str__(self) -> str:
        return f"{place_text(self.file, self.at.line, self.at.column)}: warning: {self.text}"


def first_mistakes(files: Sequence[Path], library: Sequence[Path] = ()) -> list[Mistake]:
    """Return a warning for each first mistake in a program's own files.

    Returns:
        The warnings, in the order of files and lines; none if the sources have errors.
    """
    return list(_found(files, library)[0])


def time_pins(files: Sequence[Path], library: Sequence[Path] = ()) -> list[TimePin]:
    """Return the constant pins `Timeout` and `Margin` of the calls in a program's own files."""
    return list(_found(files, library)[1])


_Found = tuple[list[Mistake], list[TimePin]]


def _found(files: Sequence[Path], library: Sequence[Path]) -> _Found:
    every = (*files, *library)
    key = cache.sources_key((*files, *_FILES, *library))
    return cache.made_of("mistakes", key, every, lambda: _read(files, every))


def _read(files: Sequence[Path], every: Sequence[Path]) -> _Found:
    project, _ = analysed(every)
    if project is None:
        return [], []
    mistakes = _Mistakes(project, {str(file): file for file in files})
    ranks = {file: rank for rank, file in enumerate(files)}
    found = dict.fromkeys(mistakes.findings())
    pins = list(dict.fromkeys(mistakes.time_pins()))
    return sorted(found, key=lambda one: (ranks[one.file], one.at)), pins


class _Mistakes:
    """The first mistakes of a project."""

    def __init__(self, project: Project, files: dict[str, Path]) -> None:
        self._project, self._files = project, files
        self._used = RobotsUsed(project, files)

    def findings(self) -> Iterator[Mistake]:
        """Yield all findings."""
        for robot in self._used.robots.values():
            yield from self._missing(robot)
            yield from self._open_pins(robot)
            yield from self._wrong_images(robot)
            yield from self._mixing(robot)
        yield from self._never_called()

    def _at(self, call: Call, text: str, kind: str) -> Mistake:
        return Mistake(self._files[call.file], call.node.at, text, kind)

    # --- missing calls of FB_ReadArea and FB_WriteArea ---

    def _missing(self, robot: Robot) -> Iterator[Mistake]:
        """Find a robot with calls of blocks, but without FB_ReadArea or FB_WriteArea."""
        if not robot.known:
            return
        working = [one for one in robot.calls if _sends(one.block, self._is_users(one))]
        reads = [one for one in robot.calls if one.area == "read"]
        writes = [one for one in robot.calls if one.area == "write"]
        no_read = bool(working or writes or robot.others) and not reads
        no_write = bool(working) and not writes
        no_read = no_read and not self._used.read_any
        no_write = no_write and not self._used.written_any
        if not no_read and not no_write:
            return
        first = (working or robot.others or writes)[0]
        if robot.copy is not None:
            symbol, pou = robot.copy
            text = (
                f"{symbol.name} is a VAR_INPUT, so {pou.name} works on a copy of the robot: the "
                f"requests of its blocks never reach FB_WriteArea; declare it in VAR_IN_OUT"
            )
            yield Mistake(self._files[pou.file], symbol.at, text, "copied-robot")
            return
        name = robot.name
        read = f"FB_ReadArea(Robot := {name}, Image := ..., Connected := ...) first in the scan"
        write = (
            f"FB_WriteArea(Robot := {name}, Image := ..., EmergencyStopOk := ..., StopOk := ...) "
            "last in the scan"
        )
        text = f"{first.name} is called for {name}, but "
        if no_read and no_write:
            text += "neither FB_ReadArea nor FB_WriteArea is: its blocks receive nothing and "
            text += f"nothing goes out; call {read} and {write}{self._another(robot)}"
        elif no_read:
            text += (
                "FB_ReadArea is not: its blocks never see the controller, and nothing goes out; "
            )
            text += f"call {read}{self._declared(first, 'read')}"
        else:
            text += "FB_WriteArea is not: nothing that its blocks ask for reaches the controller; "
            text += f"call {write}{self._declared(first, 'write')}"
        yield self._at(first, text, "no-area-block")

    def _declared(self, call: Call, area: str) -> str:
        """Return a text about an instance of the missing block that is declared but not called."""
        for symbol in call.pou.symbols.values():
            kind = symbol.type
            missing = isinstance(kind, BlockType) and AREAS.get(kind.name.upper()) == area
            if missing and not self._used.is_used(call.pou, symbol):
                return f"; {symbol.name} is declared in line {symbol.at.line}, but not called"
        return ""

    def _another(self, robot: Robot) -> str:
        """Return a text with the robots that are read and written; the user may have meant one."""
        others = [
            one.name
            for one in self._used.robots.values()
            if one is not robot and {"read", "write"} <= {call.area for call in one.calls}
        ]
        return f", or use {' or '.join(others)}" if others else ""

    # --- pins that have to be wired ---

    def _open_pins(self, robot: Robot) -> Iterator[Mistake]:
        by_instance: dict[object, list[Call]] = {}
        for call in robot.calls:
            if call.area:
                by_instance.setdefault(call.instance or id(call.node), []).append(call)
        needs = robot.calls if robot.known else []
        moves = [one for one in needs if _moves(one.block)]
        servos = [one for one in needs if one.block.name.upper() in _SERVOS]
        for calls in by_instance.values():
            first = calls[0]
            if first.area == "read" and self._open(calls, "Connected"):
                yield self._at(
                    first,
                    f"Connected of {first.name} is not wired and stays FALSE: the data from the "
                    f"controller is ignored, and every block of {robot.name} ends in error "
                    "16#8001 (Not connected); wire the status of your scanner to it",
                    "connected-not-wired",
                )
            if first.area != "write":
                continue
            for pin, signal, blocks, what in (
                ("EmergencyStopOk", "SI(00)", [*servos, *moves], "stays in emergency stop"),
                ("StopOk", "SI(06)", moves, "does not move and starts no program"),
            ):
                if blocks and self._open(calls, pin):
                    yield self._at(
                        first,
                        f"{pin} of {first.name} is not wired and stays FALSE: {signal} stays OFF, "
                        f"the controller {what}, and {blocks[0].name} (line "
                        f"{blocks[0].node.at.line}) ends in error; wire the answer of your safety "
                        "circuit to it",
                        "safety-pin-not-wired",
                    )

    def _open(self, calls: Sequence[Call], pin: str) -> bool:
        """Return whether a pin is always FALSE, as far as the source shows."""
        block = calls[0].block
        return (
            pin.upper() in pins_of(block)
            and (block.name.upper(), pin.upper()) not in self._used.set_apart
            and all(self._used.stays_false(call, pin) for call in calls)
        )

    # --- wrong process images ---

    def _wrong_images(self, robot: Robot) -> Iterator[Mistake]:
        """Find an area block with the image of the other direction."""
        for call in robot.calls:
            other, right, text = _OTHER_IMAGE.get(call.area, ("", "", ""))
            if call.image and call.image[-1] == other.upper():
                yield self._at(call, f"{call.name} {text}; give it {right}", "swapped-image")

    # --- several works, and times ---

    def _mixing(self, robot: Robot) -> Iterator[Mistake]:
        """Find two blocks with several commands that can work with one robot at once."""
        for call, earlier in mixing_works(robot, self._used) if robot.known else ():
            text = (
                f"{call.name} can start while {earlier.name} (line {earlier.node.at.line}) works "
                f"with {robot.name}: both send several commands, so one of them ends with 16#805D "
                f"(Another block) in the middle of its work; start {call.name} only while "
                f"{earlier.name} is not Busy, and the other way round"
            )
            yield self._at(call, text, "two-works-at-once")

    def time_pins(self) -> Iterator[TimePin]:
        """Yield the pins with times that must suit the packet interval."""
        for call in (call for robot in self._used.robots.values() for call in robot.calls):
            if call.area == "write":
                pin, kind = "Margin", MARGIN
            elif not call.area and _sends(call.block, self._is_users(call)):
                pin, kind = "Timeout", TIMEOUT
            else:
                continue
            value = time_of(call, pin, self._used)
            if value is not None:
                yield TimePin(self._files[call.file], call.node.at, kind, call.name, value)

    # --- blocks that are never called ---

    def _never_called(self) -> Iterator[Mistake]:
        for pou in self._used.pous:
            for symbol in pou.symbols.values():
                kind = symbol.type
                if symbol.section != "VAR" or not isinstance(kind, BlockType):
                    continue
                own = self._project.pous.get(kind.name.upper())
                if own is None or own.file in self._files or not robot_pins(kind):
                    continue
                if kind.name.upper() in AREAS or not self._used.only_members(pou, symbol):
                    continue
                text = (
                    f"{symbol.name} is never called: it does nothing, and its outputs stay as they "
                    f"are; call {symbol.name}(Robot := ...) in every scan, between FB_ReadArea and "
                    "FB_WriteArea"
                )
                yield Mistake(self._files[pou.file], symbol.at, text, "block-never-called")

    def _is_users(self, call: Call) -> bool:
        pou = self._project.pous.get(call.block.name.upper())
        return pou is None or pou.file in self._files


def _moves(block: BlockType) -> bool:
    name = block.name.upper()
    return name in _MOVES or name.startswith(_MOVES_BEGIN)


def _sends(block: BlockType, users: bool) -> bool:
    """Return whether a block, or a block that it calls, sends something to the controller."""
    name = block.name.upper()
    if _moves(block) or name in (*_SERVOS, *_SENDING):
        return True
    return not users and "EXECUTE" in pins_of(block)
