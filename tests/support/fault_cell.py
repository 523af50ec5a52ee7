"""A block of the library on a virtual robot, for repeated disturbances.

The block's small program is generated and compiled once. Every case starts from a snapshot.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from plc_bench import LIBRARY
from rcx_harness import Cell, RobotConfig
from rcx_harness.robot import Point, RobotProgram
from rcx_harness.trace import Record, Scan
from structured_text.language import syntax as s
from structured_text.language.parser import parse_text

#: Timeout of the block under test: T#500ms in scans of 10 ms.
TIMEOUT_SCANS = 50

_ROBOT = RobotConfig(
    boot_time=50.0,
    servo_on_delay=30.0,
    origin_time=60.0,
    programs=(RobotProgram(loop=True),),
    points={19: Point((60_000, -20_000, 10_000, 0, 0, 0))},
)

#: Inputs that sequences request: SI(01), SI(10), SI(12), SI(14) to SI(17) in word n + 32.
_REQUESTS = 0b1111_0101_0000_0010
_BIT = {f"SO{byte}{bit}": (32 + byte, 1 << bit) for byte in (0, 1) for bit in range(8)}


class CaseFailure(AssertionError):  # noqa: N818 - a failed assertion, told with its case
    """The error for a case with a wrong result."""


@dataclass(frozen=True)
class Library:
    """The blocks of plc/lib, selected by their pins, so that no block can be forgotten.

    Attributes:
        edge: Blocks with Robot, Execute, Done, Busy and Error.
        level: Blocks with Robot and Enable.
        pins: Inputs and outputs of each of these blocks.
        shared: For each block, the VAR_IN_OUT variables besides Robot and the areas: maps a name to
        its type.
        areas: For each block that takes the areas of the program, the arguments for them.
    """

    edge: tuple[str, ...]
    level: tuple[str, ...]
    pins: Mapping[str, frozenset[str]]
    shared: Mapping[str, Mapping[str, str]]
    areas: Mapping[str, str]

    def declared(self, block: str) -> str:
        """Return declarations of the variables that a program passes to the block, except Robot."""
        return "".join(f"    {one} : {kind};\n" for one, kind in self._shared(block))

    def given(self, block: str) -> str:
        """Return the arguments of the block's call, except Robot."""
        given = "".join([f", {one} := {one}" for one, _ in self._shared(block)])
        return self.areas.get(block, "") + given

    def _shared(self, block: str) -> Iterable[tuple[str, str]]:
        return self.shared.get(block, {}).items()


@lru_cache(maxsize=1)
def library() -> Library:
    """Return the blocks of plc/lib to which the contract applies.

    If two blocks differ only in the type of the image, the block for bytes is returned.
    """
    found = [one for one in _blocks() if "RCX_IMAGE_WORDS" not in one[2].values()]
    areas = {"InputImage": "InputArea", "OutputImage": "OutputArea"}
    pins = {name: frozenset(held) for name, held, _ in found}
    edge = {"Robot", "Execute", "Done", "Busy", "Error"}
    return Library(
        tuple(name for name, held in pins.items() if edge <= held),
        tuple(name for name, held in pins.items() if {"Robot", "Enable"} <= held),
        pins,
        {name: own for name, _, shared in found if (own := _without(shared, areas))},
        {
            name: "".join(f", {pin} := {area}" for pin, area in areas.items())
            for name, _, shared in found
            if areas.keys() <= shared.keys()
        },
    )


def _without(shared: Mapping[str, str], left_out: Iterable[str]) -> dict[str, str]:
    return {name: kind for name, kind in shared.items() if name not in left_out}


def place(block: str, name: str) -> str:
    """Return the path of a pin, or of a variable that the block shares (`Moves[1].Point`)."""
    shared = library().shared.get(block, {})
    return name if name.partition("[")[0] in shared else f"Block.{name}"


@lru_cache(maxsize=1)
def heads() -> Sequence[tuple[Path, s.Pou]]:
    """Return the declarations of each function block of plc/lib, without its statements.

    Reading the statements would take most of the time, and the collection of tests needs only
    names.
    """
    found = []
    for file in LIBRARY:
        if file.stem.startswith("FB_"):
            head, mark, _ = file.read_text(encoding="utf-8").rpartition("END_VAR")
            text = f"{head}{mark}\nEND_FUNCTION_BLOCK\n"
            found += [
                (file, pou)
                for pou in parse_text(text, file).declarations
                if isinstance(pou, s.Pou) and pou.kind == "FUNCTION_BLOCK"
            ]
    return found


def _blocks() -> Iterator[tuple[str, list[str], dict[str, str]]]:
    outside = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")
    for _, pou in heads():
        pins = [
            (one.kind, name.text, decl.spec)
            for one in pou.sections
            if one.kind in outside
            for decl in one.variables
            for name in decl.names
        ]
        shared = {
            name: kind.name.text
            for section, name, kind in pins
            if section == "VAR_IN_OUT" and name != "Robot" and isinstance(kind, s.NamedSpec)
        }
        yield pou.name.text, [name for _, name, _ in pins], shared


def _program(block: str, helpers: Sequence[str]) -> str:
    """Return a program that calls `block` in every scan.

    It calls the helpers while Helping is TRUE.
    """
    held = "".join(f"    {name[3:]} : {name};\n" for name in helpers)
    calls = "".join(f"    {name[3:]}(Robot := Robot);\n" for name in helpers)
    return (
        "PROGRAM Faults\n  VAR\n"
        "    InputArea, OutputArea : RCX_IMAGE;\n    Connected, Helping : BOOL;\n"
        "    EmergencyStopOk, StopOk : BOOL := TRUE;\n    Robot : RCX_REF;\n"
        f"    ReadArea : FB_ReadArea;\n    WriteArea : FB_WriteArea;\n    Block : {block};\n{held}"
        f"{library().declared(block)}"
        "  END_VAR\n"
        "  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);\n"
        f"  Block(Robot := Robot{library().given(block)});\n  IF Helping THEN\n{calls}  END_IF;\n"
        "  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,\n"
        "            EmergencyStopOk := EmergencyStopOk, StopOk := StopOk);\n"
        "END_PROGRAM\n"
    )


class Pins(NamedTuple):
    """The outputs of an edge-triggered block, or of a level block (Valid is `done`)."""

    done: bool
    busy: bool
    error: bool
    error_id: int
    active: bool = False
    aborted: bool = False

    def __str__(self) -> str:
        named = zip(("Done/Valid", "Busy", "Error"), self[:3], strict=True)
        named_more = zip(("Active", "CommandAborted"), self[4:], strict=True)
        shown = [name for name, on in (*named, *named_more) if on]
        return f"{' '.join(shown) or '-'}{f' 16#{self.error_id:04X}' if self.error_id else ''}"


class FaultCell:
    """A cell with one block under test, `Main.Block`.

    Args:
        block: Type of the block.
        inputs: Values of the block's input pins (except Execute or Enable) and tables.
        helpers: Blocks that take the cell from one state to another.
        robot: Properties of the robot that differ from the defaults.
        lib: Folder of the library; None for plc/lib.
    """

    def __init__(
        self,
        block: str,
        inputs: Mapping[str, Any],
        helpers: Sequence[str],
        robot: Mapping[str, Any],
        lib: Path | None = None,
    ) -> None:
        self.block = block
        self._folder = tempfile.TemporaryDirectory()
        file = Path(self._folder.name) / "Faults.st"
        file.write_text(_program(block, helpers), encoding="utf-8")
        properties = replace(_ROBOT, **robot)
        self.cell = Cell.build(file, lib=lib, scan="10ms", timeout="40ms", robot=properties)
        self.cell.trace.listen(self._listen)
        self._last = Scan(0, 0, bytes(48), bytes(48), None)
        self._history: list[tuple[int, tuple[bytes, Pins]]] = []
        self.quiet = False
        """While this is True, a new request or a new command fails the case."""
        pins = library().pins[block]
        level = "Enable" in pins
        self.start_pin = "Enable" if level else "Execute"
        names = ("Valid" if level else "Done", "Busy", "Error", "ErrorID", "Active")
        self._outputs = [(name, name in pins) for name in (*names, "CommandAborted")]
        self._look = self.cell.program.reader(
            [f"Main.Block.{name}" for name, there in self._outputs if there]
        )
        if "Timeout" in pins:
            self["Block.Timeout"] = "T#500ms"
        for name, value in inputs.items():
            self[place(block, name)] = value

    def __getitem__(self, path: str) -> Any:
        return self.cell.program.read(f"Main.{path}")

    def __setitem__(self, path: str, value: Any) -> None:
        self.cell.program.write(f"Main.{path}", value)

    def close(self) -> None:
        """Free the program and its source."""
        self.cell.close()
        self._folder.cleanup()

    def restore(self, snapshot: object) -> None:
        """Restore the cell from `snapshot`."""
        self.cell.restore(snapshot)
        self._history.clear()
        self.quiet = False

    @property
    def pins(self) -> Pins:
        """Return the block's outputs."""
        found = iter(self._look())
        done, busy, error, number, active, aborted = (
            next(found) if there else 0 for _, there in self._outputs
        )
        return Pins(bool(done), bool(busy), bool(error), number, bool(active), bool(aborted))

    def start(self, on: bool) -> None:
        """Set the block's start pin: Execute or Enable."""
        self[f"Block.{self.start_pin}"] = on

    def on(self, output: str) -> bool:
        """Return whether the PLC has last read an output such as `SO02` as ON."""
        at, mask = _BIT[output]
        return self.cell.connected and bool(self._last.so[at] & mask)

    @property
    def status(self) -> int:
        """Return the remote status that the PLC has last read."""
        return int.from_bytes(self._last.so[:2], "little")

    @property
    def requests(self) -> int:
        """Return the dedicated inputs that are ON on the wire, without SI(00) and SI(06)."""
        return int.from_bytes(self._last.si[32:34], "little") & _REQUESTS

    @property
    def code(self) -> int:
        """Return the command code on the wire."""
        return int.from_bytes(self._last.si[:2], "little")

    def wire(self) -> bytes:
        """Return code, status and dedicated signals. Each change is a step of a sequence."""
        so, si = self._last.so, self._last.si
        return so[:2] + so[32:34] + si[:2] + si[32:34]

    def free(self, channel: str) -> bool:
        """Return whether no block uses this channel or waits for it."""
        return bool(
            self[f"Robot.Inner.{channel}.Serving"] == self[f"Robot.Inner.{channel}.NextTicket"]
        )

    def scan(self) -> Pins:
        """Run one scan, and return the block's outputs after it."""
        requested, code = self.requests, self.code
        self.cell.scan()
        pins = self.pins
        if self.quiet and (self.requests & ~requested or (self.code and not code)):
            self.note(pins)
            self.fail("a request or a command starts by itself")
        self.note(pins)
        return pins

    def note(self, pins: Pins) -> None:
        """Add the present outputs and signals to the history if they have changed."""
        seen = (self.wire(), pins)
        if not self._history or self._history[-1][1] != seen:
            self._history.append((self._last.scan, seen))

    def until(self, condition: Callable[[], bool], most: int, what: str) -> None:
        """Scan until `condition` holds, for at most this number of scans."""
        for _ in range(most + 1):
            if condition():
                return
            self.scan()
        self.fail(f"not within {most} scans: {what}")

    def help(self, name: str) -> None:
        """Run the helper block `FB_ServoOn` once to its end."""
        self["Helping"] = True
        self[f"{name[3:]}.Execute"] = True
        self.scan()
        self.until(lambda: not self[f"{name[3:]}.Busy"], 300, f"{name} ends")
        done, error = self[f"{name[3:]}.Done"], self[f"{name[3:]}.ErrorID"]
        if not done:
            self.fail(f"{name} ends with 16#{error:04X} instead of Done")
        self[f"{name[3:]}.Execute"] = False
        self.scan()
        self["Helping"] = False

    def fail(self, text: str) -> NoReturn:
        """Fail the case.

        Raises:
            CaseFailure: always; the message has the last events.
        """
        lines = [
            f"    scan {scan}: {_signals(wire)}  {pins}"
            for scan, (wire, pins) in self._history[-14:]
        ]
        raise CaseFailure("\n".join([f"{text} (scan {self._last.scan})", *lines]))

    def _listen(self, record: Record) -> None:
        if isinstance(record, Scan):
            self._last = record


def _signals(wire: bytes) -> str:
    """Return `FaultCell.wire` as readable text: inputs and code, outputs and status."""

    def listed(word: int) -> str:
        return ",".join(f"{k >> 3}{k & 7}" for k in range(16) if word >> k & 1)

    status, so, code, si = (int.from_bytes(wire[k : k + 2], "little") for k in (0, 2, 4, 6))
    return f"SI {listed(si)} {code:04X} | SO {listed(so)} {status:04X} |"
