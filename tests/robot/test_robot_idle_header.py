"""The controller interprets the idle header in the master's cyclic packets."""

from __future__ import annotations

import struct

from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.robot import RobotConfig
from served import ServedHost

_LOSS = "12.552 EtherNet/IP overtime error"


def _image(word: int = 0, bits: int = 0x41) -> bytes:
    """Return the master's area with word 2 and byte n+32."""
    return struct.pack("<4xH26xB15x", word, bits)


def _served(idle_header: str) -> ServedHost:
    """Return a served controller with a master that runs its program."""
    served = ServedHost(RobotConfig(idle_header=idle_header))
    served.network.send(_image(7))
    served.run(20)
    return served


def test_an_idle_master_counts_as_a_loss_of_the_link() -> None:
    """Rule: idle-header."""
    served = _served("loss")
    served.network.become(OwnerState.IDLE)
    status = served.run(5)
    assert (status.si, status.network_led) == ("", "red, flashing")
    assert _LOSS in status.alarms
    served.network.become(OwnerState.RUN)
    assert served.run(5).network_led == "green"


def test_the_last_data_before_idle_stay_if_the_setting_is_hold() -> None:
    """Rule: idle-header."""
    served = _served("hold")
    served.network.to_robot.write(_image(9, 0))
    served.network.become(OwnerState.IDLE)
    status = served.run(20)
    assert bytes.fromhex(status.si) == _image(7)
    assert (status.network_led, status.alarms) == ("green", ())
    served.network.become(OwnerState.RUN)
    assert bytes.fromhex(served.run(5).si) == _image(9, 0)


def test_the_inputs_are_zero_if_the_master_was_idle_from_the_start() -> None:
    """Rule: idle-header."""
    served = ServedHost(RobotConfig(idle_header="hold"))
    served.network.to_robot.write(_image(9))
    served.network.become(OwnerState.IDLE)
    assert bytes.fromhex(served.run(5).si) == bytes(48)


def test_a_connection_loss_of_an_idle_master_is_an_alarm_even_if_idle_holds_the_data() -> None:
    """Rule: idle-header."""
    served = _served("hold")
    served.network.become(OwnerState.IDLE)
    served.run(5)
    served.network.become(OwnerState.TIMED_OUT)
    assert _LOSS in served.run(5).alarms
