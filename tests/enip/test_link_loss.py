"""When a connection over real sockets ends, the controller behaves as the manual says."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Iterator

import pytest

from live_master import LiveMaster
from rcx_harness.enip.cyclic.connections import ConnectionKind, OwnerState
from rcx_harness.robot import Led

Lose = Callable[[LiveMaster], None]


@pytest.fixture
def master() -> Iterator[LiveMaster]:
    made = LiveMaster(multiplier=5, boot_time=100)
    yield made
    made.close()


def fall_silent(master: LiveMaster) -> None:
    """Stop the master's packets. The connection times out after 128 RPIs, which are 1.28 s."""
    master.scanner.stop()


def close_by_forward_close(master: LiveMaster) -> None:
    master.scanner.close_connection()


def leds(master: LiveMaster) -> tuple[Led, Led]:
    """Return the states of the LEDs Module Status and Network Status."""
    return master.robot.module_led, master.robot.network_led


@pytest.mark.exhaustive(but=["close_by_forward_close-5"])
@pytest.mark.parametrize(
    ("lose", "state"),
    [(fall_silent, OwnerState.TIMED_OUT), (close_by_forward_close, OwnerState.CLOSED)],
)
def test_after_a_lost_connection_alarm_reset_and_servo_on_are_needed(
    master: LiveMaster, lose: Lose, state: OwnerState
) -> None:
    """After silence or a Forward Close, SI(00) and SI(06) are OFF and the servos turn off.

    Alarm reset and servo ON bring the robot back.

    Source: manual chapter 1, 5.2; chapter 1, 3 (LEDs).
    """
    master.servo_on()
    assert leds(master) == (Led.GREEN, Led.GREEN)
    assert master.alarms == []

    lose(master)
    master.until(lambda: not master.connected)
    assert master.adapter.shared.status().owner is state
    master.cycle(10)
    assert not master.robot.machine.si00
    assert not master.robot.machine.si06
    assert master.shows("SO00")
    assert not master.shows("SO02")
    assert master.alarms == ["12.552", "12.600"]
    assert leds(master)[0] is not Led.GREEN
    assert leds(master)[1] is Led.RED_FLASHING

    master.scanner.open()
    master.until(lambda: master.connected)
    master.until(lambda: master.scanner.read().connected and master.on("SO03"))
    assert leds(master)[1] is Led.GREEN
    assert not master.on("SO02"), "nothing restarts by itself"
    master.pulse("SI16")
    master.until(lambda: not master.on("SO03") and not master.on("SO00"))
    master.pulse("SI01")
    master.until(lambda: master.on("SO02"))
    assert master.alarms == []


def end_the_session(client: socket.socket) -> None:
    client.close()


def reset_the_session(client: socket.socket) -> None:
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    client.close()


@pytest.mark.exhaustive
@pytest.mark.parametrize("end", [end_the_session, reset_the_session])
def test_the_cyclic_connection_continues_without_the_tcp_session(
    master: LiveMaster, end: Callable[[socket.socket], None]
) -> None:
    """The cyclic connection continues when the TCP session that opened it ends."""
    master.servo_on()
    before = master.adapter.shared.status()
    end(master.scanner.client.socket)
    master.until(lambda: master.adapter.shared.status().received >= before.received + 50)
    master.until(lambda: master.adapter.shared.status().sent >= before.sent + 50)
    after = master.adapter.shared.status()
    assert (after.owner, after.generation) == (OwnerState.RUN, before.generation)
    assert master.on("SO02")
    assert master.alarms == []

    master.scanner.close_connection()  # the Forward Close uses a new session
    master.until(lambda: not master.connected)
    assert master.adapter.shared.status().owner is OwnerState.CLOSED


@pytest.mark.exhaustive
def test_an_input_only_connection_has_no_effect_on_the_controller(master: LiveMaster) -> None:
    """An input-only connection that opens and closes has no effect on the controller."""
    master.servo_on()
    with master.connect(kind=ConnectionKind.INPUT_ONLY) as reader:
        reader.open()
        master.until(lambda: reader.read().connected)
        assert reader.read().image == master.adapter.shared.to_master.read()
        master.cycle(20)
    master.until(lambda: master.adapter.shared.status().input_only == 0)
    assert master.on("SO02")
    assert master.alarms == []
    assert master.connected


@pytest.mark.exhaustive
def test_a_reader_alone_is_no_connection_to_the_controller(master: LiveMaster) -> None:
    """With an input-only connection alone, the alarm 12.551 of a missing master comes.

    Source: manual chapter 1, 5.3
    """
    master.until(lambda: master.robot.online)
    with master.connect(kind=ConnectionKind.INPUT_ONLY) as reader:
        reader.open()
        master.until(lambda: reader.read().connected)
        master.until(lambda: master.alarms == ["12.551"])
        assert not master.connected


@pytest.mark.exhaustive
def test_after_a_power_cycle_a_new_connection_can_be_opened(master: LiveMaster) -> None:
    """After a power cycle the master can open a new connection, and the servos are off."""
    master.servo_on()
    master.robot.inject("power_cycle")
    master.until(lambda: master.robot.online)
    master.until(lambda: not master.scanner.read().connected)
    assert not master.connected
    master.scanner.open()
    master.until(lambda: master.connected and master.scanner.read().connected)
    master.until(lambda: master.on("SO01"))
    assert not master.on("SO02")
