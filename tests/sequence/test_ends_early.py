"""Events end a sequence block before its answer: conditions, the link, the time limit.

The test plays the controller.

Source: manual chapter 5, 2 and 3; the link: chapter 1, 5.2.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest

from plc_bench import PlcBench
from sequence_bench import pins, program_stopped, servo_on


def _up(**outputs: bool) -> Callable[[], PlcBench]:
    """Return a bench that has powered up, with these outputs of the controller."""

    def bench() -> PlcBench:
        plc = PlcBench()
        plc.power_up()
        plc.outputs(**outputs)
        return plc

    return bench


class Block(NamedTuple):
    """A sequence block that can begin at once, and the dedicated input that it sets."""

    ready: Callable[[], PlcBench]
    signal: str


_BLOCKS = {
    "AlarmReset": Block(_up(SO03=True), "SI16"),
    "AutoStart": Block(_up(SO02=True, SO14=True), "SI12"),
    "ProgramReset": Block(_up(), "SI15"),
    "ServoOn": Block(_up(), "SI01"),
    "Origin": Block(servo_on, "SI14"),
    "Resume": Block(program_stopped, "SI12"),
}
_ERRORS = {
    "Connected=0": 0x8001,
    "SO01=0": 0x8002,
    "SO00=1": 0x8003,
    "EmergencyStopOk=0": 0x8003,
    "SO03=1": 0x8004,
    "SO04=0": 0x8005,
    "SO10=0": 0x8006,
    "StopOk=0": 0x8007,
    "SO13=1": 0x8008,
    "SO02=0": 0x800C,
}
#: Conditions of the application and of the link that end a sequence.
_PINS = "EmergencyStopOk=0 StopOk=0 Connected=0"


def _rows(table: dict[str, str]) -> list[tuple[str, str]]:
    return [(block, cause) for block, causes in table.items() for cause in causes.split()]


@pytest.mark.parametrize(
    ("block", "cause"),
    _rows(
        {
            "AlarmReset": "SO00=1 EmergencyStopOk=0 Connected=0",
            "AutoStart": f"SO01=0 SO00=1 SO03=1 SO10=0 SO13=1 {_PINS}",
            "ProgramReset": "SO01=0 SO10=0 Connected=0",
            "ServoOn": "SO01=0 SO00=1 SO03=1 SO04=0 EmergencyStopOk=0 Connected=0",
            "Origin": f"SO01=0 SO00=1 SO03=1 SO02=0 SO13=1 {_PINS}",
            "Resume": "SO01=0 SO00=1 SO03=1 SO10=0 StopOk=0 Connected=0",
        }
    ),
)
def test_without_its_conditions_a_block_is_refused_and_sends_nothing(
    block: str, cause: str
) -> None:
    """If a condition is not met, the block ends with an error and sends nothing.

    It ends in the next scan. FB_ProgramContinue first releases the stop input and waits. It is
    assumed that a return-to-origin needs servos and no running program.
    """
    plc = _BLOCKS[block].ready()
    plc.let(cause)
    plc.scan(20)
    allowed = [plc.inputs, ["SI00", "SI06"]] if block == "Resume" else [plc.inputs]
    plc.change(f"{block}.Execute", to=True)
    assert plc[f"{block}.Busy"]
    assert plc.inputs in allowed
    plc.scan(19 if block == "Resume" else 1)
    assert plc[f"{block}.ErrorID"] == _ERRORS[cause]
    plc.scan(30)
    assert plc.inputs in allowed


@pytest.mark.parametrize(
    ("block", "cause"),
    _rows(
        {
            "AutoStart": "SO00=1 SO03=1 SO10=0 Connected=0",
            "ProgramReset": "SO10=0 Connected=0",
            "ServoOn": "SO00=1 SO03=1 Connected=0",
            "Origin": "SO00=1 SO03=1 SO02=0 Connected=0",
        }
    ),
)
def test_a_condition_that_is_lost_after_the_start_ends_the_block(block: str, cause: str) -> None:
    """If a condition is lost after the start, the block ends with an error and resets its input."""
    ready, signal = _BLOCKS[block]
    plc = ready()
    plc.change(f"{block}.Execute", to=True, scans=5)
    assert plc.inputs == sorted(["SI00", "SI06", signal])
    plc.let(cause)
    plc.scan()
    assert plc[f"{block}.ErrorID"] == _ERRORS[cause]
    plc.scan(12)
    assert plc.inputs == ([] if cause == "Connected=0" else ["SI00", "SI06"])


@pytest.mark.parametrize("block", _BLOCKS)
def test_a_missing_answer_ends_the_block_at_the_time_limit_and_resets_its_input(block: str) -> None:
    """A missing answer ends the block at the time limit, and the input is reset.

    For example, an alarm that needs a power restart is not reset: chapter 5, 2, SI(16).
    """
    plc = _BLOCKS[block].ready()
    plc[f"{block}.Timeout"] = "T#300ms"
    plc.change(f"{block}.Execute", to=True, scans=30)
    assert pins(plc, block) == "Busy Active"
    plc.scan()
    assert plc[f"{block}.ErrorID"] == 0x8010
    plc.scan(12)
    assert plc.inputs == ["SI00", "SI06"]
