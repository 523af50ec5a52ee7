"""`rcx serve` prints each event once, in a line with the time of the event."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import asdict

import pytest

from rcx_harness.enip.cyclic.connections import ConnectionKind, OwnerState
from rcx_harness.enip.cyclic.journal import ConnectionEvent
from rcx_harness.enip.cyclic.shared import Drop
from rcx_harness.serve.lines import Lines
from served import ServedHost, image

READER = "192.168.0.11"


def _told(lines: Sequence[str]) -> list[tuple[float, str]]:
    """Return the time [s] and the text of each line."""
    parts = [line.split(" s  ", 1) for line in lines]
    return [(float(head.split()[1]), text) for head, text in parts]


def _texts(lines: Lines) -> list[str]:
    """Return the texts of the new lines."""
    return [text for _, text in _told(lines.new())]


def watched(served: ServedHost | None = None, after_ms: int = 0) -> tuple[ServedHost, Lines]:
    """Return a controller and its lines. The first lines have been read already."""
    if served is None:
        served = ServedHost()
        if after_ms:
            served.run(after_ms)
    lines = Lines([served])
    lines.new()
    return served, lines


def test_each_change_is_shown_once_with_its_own_time(served: ServedHost) -> None:
    """Each change is shown once, with its own time, whenever the lines are read.

    The controller uses a packet in its next cycle of 5 ms.
    """
    lines = Lines([served])
    assert lines.new() == [
        "127.0.0.1      0.000 s  no master has connected yet",
        "127.0.0.1      0.000 s  Module Status green, flashing, Network Status green, flashing",
        "127.0.0.1      0.000 s  connected: 192.168.0.10, every 10 ms",
        "127.0.0.1      0.005 s  Module Status green, Network Status green",
    ]
    served.run(100)
    assert lines.new() == []
    served.network.become(OwnerState.TIMED_OUT)
    served.run(100)
    assert lines.new() == [
        "127.0.0.1      0.400 s  the master fell silent: the connection has timed out: "
        "192.168.0.10",
        "127.0.0.1      0.405 s  Module Status green, flashing, Network Status red, flashing",
        "127.0.0.1      0.405 s  alarm 12.552 EtherNet/IP overtime error",
        "127.0.0.1      0.405 s  alarm 12.600 Emergency stop on",
    ]


def test_five_openings_and_closings_within_60_ms_give_ten_lines() -> None:
    """Five openings and closings within 60 ms give ten lines. They are read once, at the end."""
    served, lines = watched()
    for _ in range(5):
        served.network.become(OwnerState.WAITING)
        served.run(30)
        served.network.become(OwnerState.CLOSED)
        served.run(30)
    told = [one for one in _told(lines.new()) if "master" in one[1]]
    opened = "a master has opened the connection: 192.168.0.10, every 10 ms"
    closed = "the master has closed the connection: 192.168.0.10"
    assert told == [
        (round(0.03 * number, 3), closed if number % 2 else opened) for number in range(10)
    ]


def test_changes_within_one_cycle_of_the_controller_have_their_own_times() -> None:
    served, lines = watched()
    for at_us, state in ((1_000, "waiting"), (2_000, "run"), (4_000, "closed")):
        served.network.now_us = at_us
        served.network.tell(ConnectionKind.EXCLUSIVE_OWNER, state)
    served.run(5)
    assert [at_s for at_s, _ in _told(lines.new())] == [0.001, 0.002, 0.004]


def test_the_clock_of_the_adapter_is_converted_to_the_time_of_the_controller() -> None:
    """The time of the adapter is converted to the time of the controller.

    Events before the first cycle have the time 0, later events the time of the present cycle.
    """
    served = ServedHost()
    served.station.begin_us = 7_000_000
    _, lines = watched(served)
    for at_us in (6_999_000, 7_003_000, 7_009_000):
        served.network.now_us = at_us
        served.network.tell(ConnectionKind.EXCLUSIVE_OWNER, "waiting")
    served.run(5)
    assert [at_s for at_s, _ in _told(lines.new())] == [0.0, 0.003, 0.005]


def test_a_reader_has_its_own_lines_and_does_not_repeat_lines_of_the_master(
    served: ServedHost,
) -> None:
    """A reader has its own lines, and a time-out of the master is shown only once.

    Readers may connect and disconnect afterwards.
    """
    served.network.become(OwnerState.TIMED_OUT)
    served.run(5)
    lines = Lines([served])
    assert sum("timed out" in line for line in lines.new()) == 1
    for _ in range(3):
        for state, readers in (("waiting", 1), ("closed", 0)):
            served.network.listeners = readers
            served.network.tell(ConnectionKind.INPUT_ONLY, state, READER)
            served.run(50)
    texts = _texts(lines)
    assert (
        texts
        == [
            f"{READER} reads along (input only), every 10 ms; 1 reader",
            f"{READER} no longer reads along: it has closed its connection; 0 readers",
        ]
        * 3
    )


@pytest.mark.parametrize(
    ("state", "how"),
    [
        ("timed out", "its connection has timed out"),
        ("no owner", "the last connection to which it listened has ended"),
    ],
)
def test_the_end_of_a_reader_says_why(state: str, how: str) -> None:
    served, lines = watched()
    served.network.listeners = 2
    served.network.tell(ConnectionKind.LISTEN_ONLY, state, READER)
    served.run(5)
    assert _texts(lines) == [f"{READER} no longer reads along: {how}; 2 readers"]


def test_three_commands_between_two_looks_have_three_times(served: ServedHost) -> None:
    _, lines = watched(served)
    for _ in range(3):
        served.network.send(image(0x41, 0x0505))
        served.run(40)
        served.network.send(image(0x41))
        served.run(40)
    times = [at_s for at_s, text in _told(lines.new()) if text.startswith("command: ")]
    assert len(times) == 3
    assert [round(later - sooner, 3) for sooner, later in itertools.pairwise(times)] == [0.08, 0.08]


def test_a_refused_connection_is_shown_once_and_then_counted() -> None:
    """A refused connection is shown once, then counted. Another master is shown at once.

    A refused master requests the connection again every second.
    """
    served, lines = watched()
    said = []
    for second in range(12):
        served.network.refuse("192.168.0.10 asked for 256 bytes: refused")
        if second == 2:
            served.network.refuse("192.168.0.11 asked for 64 bytes: refused")
        served.run(1000)
        said += [text for _, text in _told(lines.new()) if "refused" in text]
    assert said == [
        "192.168.0.10 asked for 256 bytes: refused",
        "192.168.0.11 asked for 64 bytes: refused",
        "192.168.0.10 asked for 256 bytes: refused (repeated 4 times)",
        "192.168.0.10 asked for 256 bytes: refused (repeated 5 times)",
    ]


def test_dropped_packets_are_shown_at_once_and_then_every_five_seconds() -> None:
    served, lines = watched()
    network = served.network
    network.lengths = (300, 54)
    told = []
    for _ in range(60):
        network.drops[Drop.LENGTH] += 10
        network.drops[Drop.JUMP] += 1
        served.run(100)
        told += [one for one in _told(lines.new()) if "dropped" in one[1]]
    assert told == [
        (
            0.1,
            "packets dropped: 10 of a wrong length (300 bytes instead of 54), 1 whose sequence "
            "number is too far ahead",
        ),
        (
            5.1,
            "packets dropped: 500 of a wrong length (300 bytes instead of 54), 50 whose sequence "
            "number is too far ahead",
        ),
    ]


def test_power_and_cable_are_shown(served: ServedHost) -> None:
    _, lines = watched(served)
    texts = []
    for event in ("link_down", "link_up", "power_off"):
        served.station.happen(event)
        served.run(5)
        texts += _texts(lines)
    cable = ["the network cable is unplugged", "the network cable is plugged in again"]
    assert texts[:3] == [*cable, "the controller is off"]


def test_too_many_changes_are_counted() -> None:
    """If there are too many changes, they are counted: of 200 changes, 73 are not shown.

    Only 127 changes fit between two cycles of the controller.
    """
    served, lines = watched()
    for _ in range(100):
        served.network.become(OwnerState.RUN)
        served.network.become(OwnerState.IDLE)
    served.run(5)
    texts = _texts(lines)
    assert "73 changes of connections are not shown: there were too many at once" in texts
    assert len(texts) < 40


def test_the_longest_event_fits_into_its_slot() -> None:
    """The longest possible event fits into its slot of the shared memory.

    It has the longest address, state and intervals of a connection.
    """
    served = ServedHost()
    longest = ConnectionEvent(
        2**63 - 1, ConnectionKind.EXCLUSIVE_OWNER, "timed out", "255.255.255.255", 2**32, 2**32, 99
    )
    served.network.events.write(asdict(longest))
    assert served.network.events.read().records == [asdict(longest)]


def test_plain_lines_tell_commands_at_their_end_and_broken_rules(served: ServedHost) -> None:
    _, lines = watched(served)
    served.network.send(image(0x41, 0x0505))
    served.run(5)
    assert lines.new() == [], "the controller still runs"
    served.run(50)
    served.network.send(image(0x41, 0x0FFF))
    served.run(10)
    texts = _texts(lines)
    assert texts == [
        "command: ReadPositionPulses (16#R505): Current position reference, pulse units: "
        "normal end",
        "rule broken: command 16#0FFF is set while the status is 16#0200; a command may be set "
        "only in status 16#0000; not executed",
    ]


def test_plain_lines_tell_alarms_that_go_skipped_cycles_and_an_end() -> None:
    served, lines = watched(after_ms=200)
    served.network.send(image(0x01))
    served.now_us += 15_000
    served.station.step(served.now_us, skipped=2)
    served.run(5)
    served.ended.set()
    texts = _texts(lines)
    assert texts == [
        "connected: 192.168.0.10, every 10 ms",
        "Module Status green, Network Status green",
        "no longer: alarm 12.551 EtherNet/IP link error",
        "2 cycles of 5 ms skipped: this computer was busy",
        "the controller's process has ended",
    ]
    assert lines.new() == []


def test_a_single_skipped_cycle_is_written_in_the_singular() -> None:
    served, lines = watched(after_ms=200)
    served.now_us += 10_000
    served.station.step(served.now_us, skipped=1)
    served.run(5)
    texts = _texts(lines)
    assert texts == ["1 cycle of 5 ms skipped: this computer was busy"]
