"""A block that is called before FB_ReadArea or after FB_WriteArea ends with an error.

It sends nothing. One program contains all blocks, and the test calls one block at a time. With
matiec the program contains only some blocks, because compiling takes long.

Source: docs/reference/errors.md, 16#8017; docs/explanation/scan-model.md, where a block is called.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from both_engines import ENGINES
from fault_cell import library
from fault_scenarios import LEVELS, SCENARIOS
from plc_bench import PlcBench
from structured_text.engines.base import Value

OUT_OF_PLACE = 0x8017
PLACES = ("Early", "Late")
#: Blocks that only read. At a wrong place in the program they show values of an earlier scan.
LOOKING = ("FB_AutoMode", "FB_Interlock", "FB_Status")
#: Blocks that turn their input OFF at any place in the program; see
#: tests/area/test_out_of_place.py.
STOPPING = {"FB_EmergencyStop": 0x0001, "FB_ProgramStop": 0x0040}
BLOCKS = [name for name in (*library().edge, *library().level) if name not in LOOKING]
_MATIEC_BLOCKS = (
    *("FB_MoveIDirectMm", "FB_RemoteCommand", "FB_ContinuousPosition", "FB_Jog", "FB_ServoOn"),
    *("FB_PowerUp", "FB_EmergencyStop", "FB_SequenceControl", "FB_ToolPosition"),
)
#: Outputs of the controller that keep each of these blocks Busy for some scans.
_OUTPUTS = {
    "FB_AlarmReset": {"SO03": True},
    "FB_ProgramReset": {"SO14": False},
    "FB_ServoOn": {"SO02": False},
    "FB_ServoOnFromEmergencyStop": {"SO00": True},
}
_BOTH = {**SCENARIOS, **LEVELS}
_END, _READY = 0x0200, 0x0000
#: SI(00) and SI(06): the dedicated inputs that are ON without a request.
_LEVELS = 0x0041


class Places(PlcBench):
    """A program that calls a block before FB_ReadArea, after FB_WriteArea, or between them.

    Another command block is always called between them.

    Args:
        engine: The engine that runs the program.
    """

    def __init__(self, engine: str) -> None:
        self.blocks = BLOCKS if engine == "builtin" else list(_MATIEC_BLOCKS)
        self.code, self.on = 0, 0
        self.codes: list[int] = []
        with TemporaryDirectory() as folder:
            program = Path(folder) / "Places.st"
            program.write_text(_program(self.blocks), encoding="utf-8")
            super().__init__(program=program, engine=engine, contract=False)
        self.outputs(SO02=True, SO11=True, SO14=True)
        self.power_up()
        self["Other.Code"], self["Other.Data"] = 0x0501, [0] * 15
        self._start = self.program.snapshot(), self.now_us, bytes(self.so)

    def choose(self, block: str) -> None:
        """Restore the initial state, and select a block.

        The program does not call the block yet.
        """
        snapshot, self.now_us, so = self._start
        self.program.restore(snapshot)
        self.so[:] = so
        self["Chosen"] = self.blocks.index(block) + 1
        self.name = f"B{self['Chosen']}"
        self.start = "Execute" if block in library().edge else "Enable"
        self.code, self.on, self.codes = 0, 0, []
        self.outputs(**_OUTPUTS.get(block, {}))
        inputs = _BOTH[block].inputs if block in _BOTH else {}
        for pin, value in inputs.items():
            shared = pin.partition("[")[0] in library().shared.get(block, {})
            self[f"{self.name}{'' if shared else '.'}{pin}"] = value

    def call(self, *places: str) -> None:
        """Let the program call the block at the given places in each later scan."""
        for place in ("Early", "There", "Late"):
            self[place] = place in places

    def go(self, on: bool = True) -> None:
        """Set the block's input Execute or Enable to TRUE or FALSE."""
        self[f"{self.name}.{self.start}"] = on

    def pin(self, name: str) -> Value:
        """Return the value of a pin of the block."""
        return self[f"{self.name}.{name}"]

    @property
    def error(self) -> int:
        """Return the block's ErrorID, or 0 if Error is FALSE."""
        return int(self.pin("ErrorID")) if self.pin("Error") else 0

    @property
    def works(self) -> bool:
        """Return whether the block is Busy, or Valid if it has an input Enable."""
        return bool(self.pin("Busy")) or (self.start == "Enable" and bool(self.pin("Valid")))

    @property
    def applied(self) -> int:
        """Return the 16 dedicated inputs in the output area as a number, SI(00) in bit 0."""
        return int.from_bytes(self.image[32:34], "little")

    def scan(self, count: int = 1) -> None:
        """Run scans, and record the codes that are sent and the dedicated inputs that turn ON."""
        for _ in range(count):
            super().scan()
            area = self.image[:34]
            code = int.from_bytes(area[:2], "little")
            if code and not self.code:
                self.codes.append(code)
            self.code = code
            self.on |= int.from_bytes(area[32:], "little") & ~_LEVELS

    def finish(self) -> None:
        """Answer all commands as a controller does, until the block and the other block have ended.

        After a jog, the other command waits until SI(06) is ON again.
        """
        for scan in range(60):
            self.answer(_END if self.code else _READY)
            self.scan()
            if scan > 15 and self["Other.Done"]:
                return


def _program(blocks: list[str]) -> str:
    declared, calls = [], []
    for number, block in enumerate(blocks, 1):
        shared = library().shared.get(block, {})
        declared += [f"B{number} : {block};"]
        declared += [f"B{number}{name} : {kind};" for name, kind in shared.items()]
        given = library().areas.get(block, "")
        given += "".join(f", {name} := B{number}{name}" for name in shared)
        calls.append(f"{number}: B{number}(Robot := Robot{given});")
    chosen = "CASE Chosen OF\n" + "\n".join(calls) + "\nEND_CASE;"
    variables = "\n".join(declared)
    return f"""PROGRAM Places
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Other : FB_RemoteCommand;
    Early, There, Late : BOOL;
    Chosen : INT;
{variables}
  END_VAR
  IF Early THEN {chosen} END_IF;
  ReadArea(Robot := Robot, Image := InputArea, Connected := TRUE);
  IF There THEN {chosen} END_IF;
  Other(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,
            EmergencyStopOk := TRUE, StopOk := TRUE);
  IF Late THEN {chosen} END_IF;
END_PROGRAM
"""


@cache
def _bench(engine: str) -> Places:
    return Places(engine)


def _each(engine: str, judge: Callable[[Places, str], None]) -> None:
    """Run a check for every block, and report all blocks that fail."""
    plc, failed = _bench(engine), []
    for block in plc.blocks:
        plc.choose(block)
        try:
            judge(plc, block)
        except AssertionError as error:
            failed.append(f"{block}: {str(error).partition(chr(10))[0]}")
    assert not failed, f"{len(failed)} blocks:\n" + "\n".join(failed)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("place", PLACES)
def test_a_block_that_starts_out_of_place_ends_at_once_and_sends_nothing(
    engine: str, place: str
) -> None:
    """A block that starts at a wrong place ends with 16#8017 in this call.

    While Execute stays TRUE, the block sends nothing. The other block works.

    Source: docs/reference/errors.md, 16#8017.
    """

    def judge(plc: Places, block: str) -> None:
        plc.call(place)
        plc.go()
        for scan in range(5):
            plc.scan()
            assert (plc.error, plc.pin("Busy")) == (OUT_OF_PLACE, False), f"scan {scan}"
        assert not plc.codes
        assert not plc.on
        plc["Other.Execute"] = True
        plc.finish()
        assert plc["Other.Done"]
        assert plc.codes == [0x0501]
        assert not plc.on
        plc.go(False)
        plc.scan(2)
        assert plc.error == 0

    _each(engine, judge)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("also", [False, True], ids=["moved", "twice"])
def test_a_busy_block_that_is_called_out_of_place_ends_and_sends_nothing_more(
    engine: str, place: str, also: bool
) -> None:
    """A busy block that is called at a wrong place ends with 16#8017.

    A command that was already sent stays in the output area until its end. Then the other block
    works.

    Source: docs/reference/errors.md, 16#8017; guide chapter 2: code and data stand until the
    status is seen.
    """

    def judge(plc: Places, block: str) -> None:
        plc.call("There")
        plc.go()
        plc.scan(6)
        assert plc.works
        plc["Other.Execute"] = True
        sent, asked = len(plc.codes), plc.on
        plc.call(place, *(["There"] if also else []))
        plc.scan()
        assert (plc.error, plc.pin("Busy")) == (OUT_OF_PLACE, False)
        plc.call(place)
        plc.finish()
        assert plc.error == OUT_OF_PLACE
        assert plc.codes[sent:] == [0x0501], "only the code of the other block"
        assert plc["Other.Done"]
        assert plc.on == asked
        assert plc.applied == _LEVELS & ~STOPPING.get(block, 0)
        for channel in ("Command", "Sequence"):
            turn = f"Robot.Inner.{channel}"
            assert plc[f"{turn}.Serving"] == plc[f"{turn}.NextTicket"]

    _each(engine, judge)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_block_in_its_place_again_starts_once_at_the_next_edge(
    engine: str,
) -> None:
    """A block that is called at its right place again starts once, at the next rising edge.

    Source: docs/reference/errors.md, 16#8017, remedy.
    """

    def judge(plc: Places, block: str) -> None:
        for place in PLACES:
            plc.call(place)
            plc.go()
            plc.scan(2)
            plc.go(False)
            plc.scan()
        plc.call("There")
        plc.scan(2)
        assert plc.error == 0
        plc.go()
        plc.scan()
        assert plc.works
        plc.scan(5)
        assert plc.error == 0
        assert len(plc.codes) <= 1
        assert plc.on & (plc.on - 1) == 0

    _each(engine, judge)
