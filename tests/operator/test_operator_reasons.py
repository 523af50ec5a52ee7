"""FB_RcxPanelReasons gives for each key the reason why it is not possible.

The tests run the block alone and change one signal at a time.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from alone import Alone

_NOTHING, _ESTOP, _NOT_READY = 0, 0x8003, 0x8005
_STOP, _OFF, _BUSY = 0x8007, 0x800C, 0x8076


@cache
def _block() -> Alone:
    return Alone("FB_RcxPanelReasons", {"Robot": "RCX_REF"}, "builtin")


def _shown(output: str, **changed: Any) -> int:
    """Return an output of the block for a robot with servos on, in AUTO mode, not moving.

    `changed` overrides signals of this state.
    """
    block = _block()
    block.restart()
    fields: dict[str, Any] = {
        **{f"Robot__{name}": True for name in ("Connected", "EmergencyStopOk", "StopOk")},
        **{f"Robot__SO__{name}": True for name in ("SO01_CpuOk", "SO02_ServoOn", "SO04_MpRdy")},
        "Robot__SO__SO10_AutoMode": True,
        "Robot__SO__SO11_ReturnToOriginComplete": True,
        "Robot__SI__SI00_EmergencyStop": True,
        "Robot__Settled": True,
        "Block__HmiOk": True,
        **changed,
    }
    for name, value in fields.items():
        block[name.replace("__", ".")] = value
    block.scan(0)
    found = block[f"Block.{output}"]
    assert isinstance(found, int)
    return found


@pytest.mark.parametrize(
    ("servo_on", "mp_rdy", "reason"),
    [
        (True, True, _NOTHING),
        (True, False, _NOTHING),
        (False, True, _OFF),
        (False, False, _NOT_READY),
    ],
)
def test_without_servos_motor_power_comes_first(servo_on: bool, mp_rdy: bool, reason: int) -> None:
    """Source: manual chapter 5, 3.1: servo-on needs MP RDY."""
    given = {"Robot__SO__SO02_ServoOn": servo_on, "Robot__SO__SO04_MpRdy": mp_rdy}
    assert _shown("Jog", **given) == reason


@pytest.mark.parametrize(
    ("turn", "holder", "busy"),
    [(1, 0x1001, True), (0, 0x1001, False), (1, 0, False), (1, 0x0403, False), (1, 0x003B, True)],
)
def test_a_running_command_of_category_1_may_move_the_robot(
    turn: int, holder: int, busy: bool
) -> None:
    """Source: remote command guide 4.2: the codes of category 1 have 0 there."""
    given = {"Robot__Inner__Command__NextTicket": turn, "Robot__Inner__Command__Holder": holder}
    assert _shown("Teach", **given) == _BUSY * busy


@pytest.mark.parametrize(
    ("ok", "stop", "si", "settled", "reason"),
    [
        (True, False, True, True, _NOTHING),
        (False, False, True, True, _ESTOP),
        (True, True, True, True, _ESTOP),
        (True, True, False, True, _NOTHING),
        (True, True, True, False, _NOTHING),
    ],
)
def test_only_a_remaining_emergency_stop_prevents_servo_on(
    ok: bool, stop: bool, si: bool, settled: bool, reason: int
) -> None:
    """ServoOn is not possible only while an emergency stop remains.

    An emergency stop of the PLC is over when SI(00) is ON and answered.

    Source: manual chapter 5, 3.1
    """
    given = {
        "Robot__EmergencyStopOk": ok,
        "Robot__SO__SO00_EmergencyStop": stop,
        "Robot__SI__SI00_EmergencyStop": si,
        "Robot__Settled": settled,
    }
    assert _shown("ServoOn", Robot__SO__SO02_ServoOn=False, **given) == reason


@pytest.mark.parametrize(
    ("mp_rdy", "alarm", "stop", "reason"),
    [
        (False, False, False, _NOT_READY),
        (True, False, False, _NOTHING),
        (False, True, False, _NOTHING),
        (False, False, True, _NOTHING),
    ],
)
def test_motor_power_returns_after_an_alarm_or_an_emergency_stop(
    mp_rdy: bool, alarm: bool, stop: bool, reason: int
) -> None:
    """Source: manual chapter 5, 3.1: the reset comes before servo-on."""
    given = {
        "Robot__SO__SO04_MpRdy": mp_rdy,
        "Robot__SO__SO03_Alarm": alarm,
        "Robot__SO__SO00_EmergencyStop": stop,
        "Robot__SI__SI00_EmergencyStop": not stop,
    }
    assert _shown("ServoOn", Robot__SO__SO02_ServoOn=False, **given) == reason


@pytest.mark.parametrize(
    ("halt", "kept", "stop_ok", "held", "reason"),
    [
        (False, False, True, False, _NOTHING),
        (True, False, True, False, _STOP),
        (False, True, True, False, _STOP),
        (False, False, False, False, _STOP),
        (False, False, False, True, _NOTHING),
    ],
)
def test_a_start_waits_for_the_end_of_stops_except_the_stop_that_it_ends(
    halt: bool, kept: bool, stop_ok: bool, held: bool, reason: int
) -> None:
    """Source: manual chapter 5, 3.3: the start after a stop ends it."""
    given = {
        "Block__Halt": halt,
        "Robot__Inner__KeepStop": kept,
        "Robot__StopOk": stop_ok,
        "Robot__Inner__HoldStop": held,
    }
    assert _shown("Start", Block__Automatic=True, **given) == reason
