"""A hold that is put back, two blocks that end one, and waits without a limit."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import pytest

from plc_bench import LIBRARY, ROOT, PlcBench
from structured_text.engines import build
from structured_text.engines.base import Program
from structured_text.projects.needed import needed

_PROGRAM = """PROGRAM Holds
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL := TRUE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Stop : FB_ProgramStop;
    First, Second : FB_ProgramContinue;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  Stop(Robot := Robot);
  First(Robot := Robot);
  Second(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms, EmergencyStopOk := TRUE,
            StopOk := TRUE);
END_PROGRAM
"""
_SI06 = 0x40
#: CPU_OK, servo on, MP RDY, AUTO mode; an alarm besides.
_OUTPUTS, _ALARM = 0x0116, 0x0008


@cache
def _compiled() -> Program:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "Holds.st"
        file.write_text(_PROGRAM, encoding="utf-8")
        return build([file, *needed([file], LIBRARY)]).program


class _Stopped:
    """The controller is up, and FB_ProgramStop has just taken SI(06) away."""

    def __init__(self) -> None:
        self._program = _compiled()
        self._start = self._program.snapshot()
        self.outputs, self._now = _OUTPUTS, 0
        self.scan(60)
        assert self.stop_input
        self.put("Stop.Execute", True)
        self.scan()
        assert not self.stop_input

    def close(self) -> None:
        """Back to the state before the first scan."""
        self._program.restore(self._start)

    def put(self, name: str, value: bool) -> None:
        self._program.write(f"Main.{name}", value)

    def shown(self, name: str) -> object:
        return self._program.read(f"Main.{name}")

    def scan(self, count: int = 1) -> None:
        """Scans of 10 ms."""
        for _ in range(count):
            area = bytes(32) + self.outputs.to_bytes(2, "little")
            self._program.write_bytes("Main.InputArea", area)
            self._program.scan(self._now)
            self._now += 10_000

    @property
    def stop_input(self) -> bool:
        """SI(06) as written."""
        return bool(self._program.read_bytes("Main.OutputArea")[32] & _SI06)


@pytest.fixture
def stopped() -> object:
    bench = _Stopped()
    yield bench
    bench.close()


def test_a_continuation_that_the_link_ends_puts_the_hold_back_in_the_same_scan(
    stopped: _Stopped,
) -> None:
    """SI(06) had not gone ON yet: the interval since its switch-off was not over.

    Source: manual chapter 5, 3.1, caution, and 3.3; head of FB_ProgramContinue.
    """
    stopped.scan(1)
    stopped.put("Stop.Execute", False)
    stopped.scan(60)
    assert stopped.shown("Stop.Busy") is False
    stopped.put("Connected", False)
    stopped.scan()
    stopped.put("Connected", True)
    stopped.put("First.Execute", True)
    stopped.scan()
    assert stopped.shown("First.Busy") is True
    assert not stopped.stop_input
    stopped.put("First.Execute", False)
    stopped.put("Connected", False)
    stopped.scan()
    assert stopped.shown("First.ErrorID") == 0x8001
    stopped.put("Connected", True)
    stopped.scan(60)
    assert not stopped.stop_input


def test_one_that_was_refused_does_not_hold_against_another(stopped: _Stopped) -> None:
    """It puts the hold back once, although its Execute stays TRUE; SI(06) waits for its interval.

    Source: manual chapter 5, 3.3; head of FB_ProgramContinue.
    """
    stopped.put("Stop.Execute", False)
    stopped.scan(60)
    stopped.put("Connected", False)
    stopped.scan()
    stopped.put("Connected", True)
    stopped.put("First.Execute", True)
    stopped.scan()
    stopped.put("Connected", False)
    stopped.scan()
    assert stopped.shown("First.ErrorID") == 0x8001
    stopped.put("Connected", True)
    stopped.scan(60)
    assert not stopped.stop_input
    stopped.put("Connected", False)
    stopped.scan()
    stopped.put("Connected", True)
    stopped.put("Second.Execute", True)
    stopped.scan(30)
    assert stopped.stop_input


def test_without_a_limit_the_power_up_waits_in_every_stage() -> None:
    """Source: head of FB_PowerUp: T#0s = no limit."""
    plc = PlcBench(program=ROOT / "tests/data/library/Sequences.st")
    plc["Connected"] = plc["EmergencyStopOk"] = plc["StopOk"] = False
    plc["PowerUp.Timeout"] = "T#0s"
    plc["PowerUp.Execute"] = True
    gifts: list[tuple[str, dict[str, bool] | str]] = [
        ("CONNECTION", "Connected"),
        ("CPU_OK", {"SO00": True, "SO01": True, "SO03": True}),
        ("CELL_SAFE", "EmergencyStopOk"),
        ("EMERGENCY_RELEASE", {"SO00": False}),
        ("ALARM_RESET", {"SO03": False}),
        ("MP_READY", {"SO04": True}),
        ("SERVO_ON", {"SO02": True}),
        ("STOP_RELEASE", "StopOk"),
        ("AUTO_MODE", {"SO10": True}),
        ("PROGRAM_RESET", {"SO14": True}),
        ("PROGRAM_START", {"SO13": True}),
    ]
    for stage, gift in gifts:
        plc.scan(40)
        assert plc["PowerUp.Stage"] == f"POWER_UP_{stage}"
        if isinstance(gift, str):
            plc[gift] = True
        else:
            plc.outputs(**gift)
    plc.scan(40)
    assert plc["PowerUp.Done"] is True
