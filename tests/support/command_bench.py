"""A PLC with many command blocks. It calls one of them, and the test plays the controller."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from plc_bench import PlcBench
from rcx_tools.library.tables import Block, library
from structured_text.engines.base import Value

#: The generated blocks by name, in the order of the table.
BLOCKS: Mapping[str, Block] = {
    name: block for name, block in library().blocks.items() if not block.handwritten
}

#: Number of blocks in a program. Larger programs run slowly, and more programs take longer to
#: compile.
_TOGETHER = 24


class CommandBench(PlcBench):
    """Command blocks between FB_ReadArea and FB_WriteArea, with the controller up.

    Args:
        names: The blocks; `choose` selects the block that is called.
        engine: `matiec` or `builtin`.
    """

    def __init__(self, names: Sequence[str], engine: str) -> None:
        self._names = list(names)
        self._block = names[0]
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "Bench.st"
            program.write_text(_program(names), encoding="utf-8")
            # `choose` restores a snapshot, which would confuse the contract monitor
            super().__init__(program=program, engine=engine, contract=False)
        self.power_up()
        self._start = self.program.snapshot(), self.now_us, bytes(self.so)

    def choose(self, name: str) -> None:
        """Return to the start with all pins at their defaults, and call this block from now on."""
        snapshot, self.now_us, so = self._start
        self.program.restore(snapshot)
        self.so[:] = so
        self._block = name
        self["Chosen"] = self.chosen

    @property
    def chosen(self) -> int:
        """Return the value of `Chosen` with which the program calls the block."""
        return self._names.index(self._block) + 1

    @property
    def instance(self) -> str:
        """Return the name of the block's instance."""
        return _instance(self._block)

    @property
    def shown(self) -> list[str]:
        """Return which of the outputs Busy, Active, Done and Error are TRUE."""
        return [name for name in ("Busy", "Active", "Done", "Error") if self.pin(name)]

    def pin(self, name: str) -> Value:
        """Return the value of a pin."""
        return self[f"{_instance(self._block)}.{name}"]

    def pins(self, names: Iterable[str]) -> dict[str, Value]:
        """Return the values of some pins."""
        return {name: self.pin(name) for name in names}

    def set(self, pins: Mapping[str, Value]) -> None:
        """Set pins."""
        for name, value in pins.items():
            self[f"{_instance(self._block)}.{name}"] = value

    def send(self, pins: Mapping[str, Value]) -> list[int]:
        """Set pins, raise Execute, and return the 16 words once the code is on the wire.

        Before the edge, all data words are 16#FFFF, as after another command.
        """
        self["Robot.Inner.Data"] = [0xFFFF] * 15
        self.set({**pins, "Execute": True})
        self.scan_until(lambda: self.words[0] != 0 or self.pin("Error"), most=3)
        assert not self.pin("Error"), f"refused with 16#{self.pin('ErrorID'):04X}: {pins}"
        return self.words

    def end(self, status: int = 0x0200, response: Sequence[int] = ()) -> None:
        """Answer with an end status and up to 15 response words, and scan once."""
        self.answer(status, response)
        self.scan()

    def finish(self) -> None:
        """Reset Execute and the status, and check that the code is withdrawn."""
        self.set({"Execute": False})
        self.answer(0)
        self.scan(2)
        assert self.words[0] == 0

    def exchange(self, pins: Mapping[str, Value], response: Sequence[int] = ()) -> list[int]:
        """Run a whole command with a normal end, and return the words that were sent."""
        words = self.send(pins)
        self.end(response=response)
        assert self.pin("Done")
        self.finish()
        return words


@cache
def _build(first: int, engine: str) -> CommandBench:
    return CommandBench(list(BLOCKS)[first : first + _TOGETHER], engine)


def bench_of(name: str, engine: str) -> CommandBench:
    """Return a bench that calls the generated block of this name. Each program is compiled once."""
    place = list(BLOCKS).index(name)
    bench = _build(place - place % _TOGETHER, engine)
    bench.choose(name)
    return bench


def _instance(block: str) -> str:
    return f"{block.removeprefix('FB_')}Block"


def _program(names: Sequence[str]) -> str:
    declared = "".join(f"    {_instance(name)} : {name};\n" for name in names)
    called = "".join(
        f"    {k}: {_instance(name)}(Robot := Robot);\n" for k, name in enumerate(names, 1)
    )
    return f"""PROGRAM Bench
  VAR
    InputArea  : RCX_IMAGE;
    OutputArea : RCX_IMAGE;
    Connected  : BOOL := TRUE;
    CallRival  : BOOL := TRUE;
    Chosen     : INT;
    Robot      : RCX_REF;
    ReadArea   : FB_ReadArea;
    WriteArea  : FB_WriteArea;
    Rival      : FB_RemoteCommand;
{declared}  END_VAR

  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  IF CallRival THEN
    Rival(Robot := Robot);
  END_IF;
  CASE Chosen OF
{called}  END_CASE;
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""
