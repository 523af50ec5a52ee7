"""A served controller on its network behaves as in chapter 1, 5 of the manual."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import LinkState, Status
from rcx_harness.robot import RobotConfig
from rcx_harness.spec import signals
from rcx_harness.trace import Cycle, Trace, Violation, read_trace
from served import ServedHost

_SI00, _SI06, _SI01 = 0x01, 0x40, 0x02


def image(bits: int = 0, *words: int, size: int = 48) -> bytes:
    """Return the area that the master sends, with these words from n on, and byte n+32."""
    area = bytearray(size)
    struct.pack_into(f"<{len(words)}H", area, 0, *words)
    area[32] = bits
    return bytes(area)


def on(served: ServedHost, name: str) -> bool:
    """Return whether a dedicated output is ON, as the master reads it."""
    signal = signals().find(name)
    return bool(served.network.to_master.read()[signal.byte] >> signal.bit & 1)


def link_of(served: ServedHost) -> LinkState:
    """Return the link state that the adapter's processes report."""
    return served.network.link


@pytest.fixture
def served() -> ServedHost:
    """Return a controller that has just been switched on, without a master."""
    return ServedHost()


def test_the_data_are_read_after_the_connection_state(
    served: ServedHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The controller reads the connection state first, then the data that belong to it.

    If the first packet arrives between the two readings, zeros must not be used as data.
    """
    served.run(150)
    network, status = served.network, served.network.status

    def arriving() -> Status:
        network.send(image(_SI00 | _SI06))
        return status()

    monkeypatch.setattr(network, "status", arriving)
    served.station.step(served.now_us + 5000)
    assert served.station.report().si == image(_SI00 | _SI06).hex()


@pytest.fixture
def running(served: ServedHost) -> ServedHost:
    """Return a served controller with a connected master and the servos on."""
    served.network.send(image(_SI00))
    served.run(150)
    served.network.send(image(_SI00 | _SI06))
    served.run(150)
    served.network.send(image(_SI00 | _SI06 | _SI01))
    served.run(150)
    assert on(served, "SO02")
    return served


def test_without_a_master_at_power_on_there_is_a_link_error(served: ServedHost) -> None:
    """Source: manual chapter 1, 5.3."""
    status = served.run(200)
    assert status.alarms == ("12.551 EtherNet/IP link error",)
    assert (status.module_led, status.network_led) == ("green, flashing", "green, flashing")
    assert status.si == ""


def test_an_open_connection_without_packets_does_not_count_yet(served: ServedHost) -> None:
    served.network.become(OwnerState.WAITING)
    assert served.run(200).network_led == "green, flashing"
    assert served.status.connection.state == "waiting"


def test_the_first_packet_makes_the_connection_and_clears_the_link_error(
    served: ServedHost,
) -> None:
    """Source: manual chapter 1, 5.1."""
    served.run(200)
    served.network.send(image(_SI00))
    status = served.run(10)
    assert (status.module_led, status.network_led) == ("green", "green")
    assert status.alarms == ()
    assert bytes.fromhex(status.si) == image(_SI00)


@pytest.mark.parametrize("end", [OwnerState.TIMED_OUT, OwnerState.CLOSED])
def test_the_end_of_the_owners_connection_is_the_loss_of_the_link(
    running: ServedHost, end: OwnerState
) -> None:
    """Source: manual chapter 1, 5.2."""
    running.network.become(end)
    status = running.run(5)
    assert status.alarms == ("12.552 EtherNet/IP overtime error", "12.600 Emergency stop on")
    assert status.network_led == "red, flashing"
    assert on(running, "SO00")
    assert not on(running, "SO02")

    running.network.send(image(_SI00 | _SI06))
    running.run(20)
    assert running.status.network_led == "green"
    assert not on(running, "SO02"), "nothing restarts by itself"


def test_a_loss_and_a_new_connection_between_two_cycles_is_a_loss(running: ServedHost) -> None:
    running.network.become(OwnerState.TIMED_OUT)
    running.network.become(OwnerState.WAITING)
    running.network.become(OwnerState.RUN)
    status = running.run(5)
    assert "12.552 EtherNet/IP overtime error" in status.alarms
    assert running.run(5).network_led == "green"


def test_a_cut_cable_cuts_the_adapter_off_and_the_controller_learns_it_by_the_time_out(
    running: ServedHost,
) -> None:
    running.station.happen("link_down")
    status = running.run(5)
    assert link_of(running) is LinkState.CUT
    assert status.link_cut
    assert status.network_led == "green", "neither side has noticed the loss yet"
    running.network.become(OwnerState.TIMED_OUT)
    assert running.run(5).network_led == "red, flashing"
    running.station.happen("link_up")
    assert not running.run(5).link_cut
    assert link_of(running) is LinkState.UP


def test_without_power_the_adapter_is_off_until_the_controller_has_booted(
    running: ServedHost,
) -> None:
    running.station.happen("power_cycle")
    running.run(5)
    assert link_of(running) is LinkState.OFF
    assert running.status.module_led == "green and red, flashing"
    assert running.status.si == "", "old data in the memory do not count as received"
    running.run(250)
    assert link_of(running) is LinkState.UP


def test_an_ip_address_that_is_not_set_keeps_the_adapter_off() -> None:
    served = ServedHost(RobotConfig(ip_address="duplicate"))
    served.network.send(image(_SI00))
    status = served.run(50)
    assert link_of(served) is LinkState.OFF
    assert (status.network_led, status.si) == ("red", "")


def test_an_event_happens_before_the_next_cycle(running: ServedHost) -> None:
    running.station.happen("alarm", {"group": 12, "category": 762})
    assert running.run(5).alarms[0].startswith("12.762")
    assert on(running, "SO03")


def test_a_remote_command_is_listed_while_it_runs_and_with_its_end(running: ServedHost) -> None:
    running.run(150)
    running.network.send(image(_SI00 | _SI06, 0x0505))
    note = running.run(5).commands[-1]
    assert note.request == "ReadPositionPulses (16#R505): Current position reference, pulse units"
    assert note.result == ""
    running.run(50)
    assert running.status.commands[-1].result == "normal end"
    running.network.send(image(_SI00 | _SI06))
    running.run(20)
    running.network.send(image(_SI00 | _SI06, 0x0FFF))
    assert running.run(50).commands[-1].request == "16#0FFF: no command of the manual"
    assert running.status.commands[-1].result.startswith(
        "abnormal end, alarm 12.75 Illegal remote command"
    )
    assert [one.t_us for one in running.status.commands] == sorted(
        {one.t_us for one in running.status.commands}
    )


def test_a_command_that_the_master_takes_back_is_given_up(running: ServedHost) -> None:
    running.run(150)
    running.network.send(image(_SI00 | _SI06, 0x1031))
    running.network.send(image(_SI00 | _SI06, 0x0505, 0x0001))  # continuous: runs until cleared
    running.run(100)
    assert running.status.commands[-1].result == ""
    running.network.send(image(_SI00 | _SI06))
    assert running.run(50).commands[-1].result.startswith("dropped by the master")


def test_only_the_latest_commands_and_broken_rules_are_stored(running: ServedHost) -> None:
    for number in range(60):
        running.network.send(image(_SI00 | _SI06, 0x0FFF))
        running.run(50)
        running.network.send(image(_SI00 | _SI06 | _SI01 * (number % 2)))
        running.run(45)
    assert len(running.status.commands) == 20
    assert len(running.status.violations) == 20
    assert running.status.violation_count == 29  # every second change is earlier than allowed


def test_a_broken_rule_after_skipped_cycles_says_that_this_computer_was_late(
    running: ServedHost,
) -> None:
    running.run(150)
    running.network.send(image(_SI00 | _SI06))
    running.run(50)
    running.network.send(image(_SI00 | _SI06 | _SI01))
    running.now_us += 20_000
    running.station.step(running.now_us, skipped=4)
    status = running.run(5)
    assert status.skipped == 4
    assert status.violations[-1].text.endswith(
        "(this computer was late just before; that may be the cause)"
    )
    running.run(300)
    running.network.send(image(_SI00 | _SI06))
    running.run(50)
    running.network.send(image(_SI00 | _SI06 | _SI01))
    assert running.run(5).violations[-1].text.endswith("not recognised")


def test_changes_of_the_chart_are_reported_once_with_their_time(running: ServedHost) -> None:
    start = running.run(150).t_us
    running.network.send(image(_SI00 | _SI06, 0, 0, 5))
    (change,) = running.run(20).changes  # only SI(01) OFF: the chart does not show word 2
    assert (change.t_us - start, change.connected, change.si) == (5000, True, "00004100")
    assert running.run(20).changes == ()
    running.network.become(OwnerState.CLOSED)
    first = running.run(20).changes[0]
    assert (first.connected, first.si) == (False, "00000000")


def test_further_connections_are_counted(running: ServedHost) -> None:
    running.network.listeners = 2
    connection = running.run(5).connection
    assert (connection.state, connection.peer, connection.others) == ("run", "192.168.0.10", 2)
    assert (connection.to_robot_us, connection.to_master_us) == (10_000, 10_000)


def test_the_trace_has_each_cycle_with_other_areas_the_last_one_and_broken_rules(
    tmp_path: Path,
) -> None:
    """The trace has the cycles with other areas, the last cycle, and broken rules.

    A cycle takes 5 ms. SI(06) and SI(01) change 50 ms apart, which breaks the rule of 100 ms.

    Source: manual chapter 5, 3, caution; chapter 5, 4.
    """
    file = tmp_path / "serve.jsonl"
    served = ServedHost(trace=Trace({"by": "rcx serve"}, file))
    served.run(100)
    served.network.send(image(_SI00))
    served.run(50)
    served.network.send(image(_SI00 | _SI06))
    served.run(50)
    served.network.send(image(_SI00 | _SI06 | _SI01))
    served.run(100)
    served.station.finish()
    header, records = read_trace(file)
    assert header == {"format": "rcx-trace/1", "by": "rcx serve"}
    every = list(records)
    cycles = [one for one in every if isinstance(one, Cycle)]
    assert {(one.t_us, one.cycle) for one in cycles} >= {
        (0, 0),
        (105_000, 21),
        (155_000, 31),
        (205_000, 41),
        (300_000, 60),
    }
    assert len(cycles) < 15
    assert all(one.t_us == 5_000 * one.cycle for one in cycles)
    assert [one.rcx_si for one in cycles if one.t_us in (0, 105_000, 155_000)] == [
        b"",
        image(_SI00),
        image(_SI00 | _SI06),
    ]
    (broken,) = [one for one in every if isinstance(one, Violation)]
    assert (broken.t_us, broken.rule) == (205_000, "interval")
    assert broken.text.startswith("robot, cycle 41: interval: SI(01) Servo ON input ON 50 ms after")
