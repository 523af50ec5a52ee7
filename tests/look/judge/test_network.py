"""Connections in a capture are detected by Forward Opens, and followed by identifiers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from captures import Story, area, pcap
from forward_open_bytes import forward_open
from rcx_harness.look.judge.judge import Judgement, JudgeOptions, judge
from rcx_harness.look.judge.network import Robot
from rcx_harness.trace import Scan, read_trace
from structured_text.errors import InputError

OK = area(dedicated=0x0312)  # CPU_OK, MP RDY, AUTO mode, return-to-origin complete
FREE = area(dedicated=0x0041)  # SI(00), SI(06)
HOST = bytes([192, 168, 0, 10])


class Heard:
    """The judgement of a capture: the printed text, the controllers and the trace."""

    def __init__(self, folder: Path, *stories: Story, **options: object) -> None:
        packets = sorted((one for story in stories for one in story.frames()), key=lambda p: p[0])
        self.lines: list[str] = []
        file = pcap(folder / "told.pcap", packets)
        chosen = JudgeOptions(file, trace=folder / "told.jsonl", **options)  # type: ignore[arg-type]
        self.result: Judgement = judge(chosen, self.lines.append)
        self.trace = folder / "told.jsonl"

    @property
    def robots(self) -> list[Robot]:
        """Return the controllers in the order in which they appear in the capture."""
        assert self.result.network is not None
        return list(self.result.network.robots.values())

    def scans(self) -> list[Scan]:
        """Return the scans of the trace that was written."""
        return [one for one in read_trace(self.trace)[1] if isinstance(one, Scan)]


def _quiet(story: Story, begin_us: int = 0, packets: int = 10) -> Story:
    """Return a capture of a connection whose areas are repeated every 10 ms without a change."""
    story.open(begin_us)
    for k in range(1, packets + 1):
        story.both(begin_us + 10_000 * k, FREE, OK)
    return story


def test_a_connection_is_followed_from_its_forward_open_to_its_close(tmp_path: Path) -> None:
    """A connection is followed from its Forward Open to its Forward Close.

    The owner asks for 54 bytes to the controller, 50 bytes from the controller, and 10 ms.
    """
    story = _quiet(Story())
    story.close(200_000)
    (robot,) = Heard(tmp_path, story).robots
    (one,) = robot.connections
    assert (robot.host, robot.size, one.kind.value) == (HOST, 48, "exclusive owner")
    assert (one.to_robot_us, one.to_master_us) == (10_000, 10_000)
    assert (one.to_robot.packets, one.to_master.packets) == (10, 10)
    assert (one.to_robot.lost, one.to_master.lost) == (0, 0)
    assert one.end == "closed by a Forward Close"
    assert one.end_us == 200_500


@pytest.mark.parametrize(
    "fields",
    [
        {"path": "01 00 2004 2405 2C96 2C64"},
        {"path": "3404 7C02 2B00 0500 01 01 2004 2405 2C96 2C64"},
        {"path": "2004 2C96 2C64"},
        {"path": "2004 2D00 9600 2D00 6400"},
        {"o_to_t": "3248"},
        {"service": "5B", "o_to_t": "36000048", "t_to_o": "32000048"},
    ],
    ids=["route", "electronic key", "no configuration", "16 bit", "no header", "large"],
)
def test_forward_opens_of_many_kinds_are_understood(tmp_path: Path, fields: dict[str, str]) -> None:
    """Forward Opens with different options are read. 0x4832 is 50 bytes without run/idle header.

    Source: CIP volume 1, chapter 3, 5.5.2; appendix C, 1.4.
    """
    story = Story()
    story.open(0, **fields)
    story.to_plc(10_000, OK)
    if fields.get("o_to_t") != "3248":
        story.to_robot(20_000, FREE)
    (robot,) = Heard(tmp_path, story).robots
    assert [one.kind.value for one in robot.connections] == ["exclusive owner"]
    assert robot.connections[0].to_master.wrong == robot.connections[0].to_robot.wrong == 0


def test_a_forward_open_in_an_unconnected_send_is_understood(tmp_path: Path) -> None:
    """Source: CIP volume 1, chapter 3, 5.5.4: ticks, length, message, route."""
    story = Story()
    inner = bytes.fromhex(forward_open(ids="00000000 22000000", triad=story.triad))
    wrapped = bytes.fromhex("52 02 2006 2401 0A0E") + len(inner).to_bytes(2, "little")
    wrapped += inner + bytes(len(inner) % 2) + bytes.fromhex("01 00 01 00")
    story.open(0)
    story.packets.clear()
    story.message(0, wrapped)
    answered = Story()
    answered.open(0)
    story.packets.append((500, answered.packets[1][1]))
    story.to_plc(10_000, OK)
    (robot,) = Heard(tmp_path, story).robots
    assert robot.connections[0].to_master.packets == 1


def test_multicast_packets_belong_to_the_controller_that_sends_them(tmp_path: Path) -> None:
    """Packets to a multicast group belong to the controller that sends them.

    An owner and a reader share these packets. The reader continues after the owner has closed its
    connection.

    Source: CIP volume 1, chapter 3: multicast connections share one connection id.
    """
    owner = _quiet(Story(group="239.192.2.32"))
    owner.close(150_000)
    reader = Story("192.168.0.2", o_to_t=0x33, t_to_o=0x22, group="239.192.2.32")
    reader.open(60_000, o_to_t="0248", path="2004 2405 2CC6 2C64")
    for k in range(20, 30):
        owner.to_plc(10_000 * k, area(dedicated=0x0112))
    (robot,) = Heard(tmp_path, owner, reader).robots
    assert [one.kind.value for one in robot.connections] == ["exclusive owner", "input only"]
    assert robot.connections[0].to_master is robot.connections[1].to_master
    assert robot.connections[0].to_master.packets == 20
    assert robot.so == area(dedicated=0x0112)


def test_packets_to_a_reader_are_not_data_read_by_the_plc(tmp_path: Path) -> None:
    """Packets to a reader are not used as data that the PLC has read.

    They are sent at other times, and may be older than the packets to the owner.
    """
    owner, reader = _quiet(Story()), Story("192.168.0.2", o_to_t=0x33, t_to_o=0x44)
    reader.open(5_000, o_to_t="0248", path="2004 2405 2CC6 2C64")
    owner.to_plc(200_000, area(dedicated=0x0316))
    reader.to_plc(201_000, OK)
    heard = Heard(tmp_path, owner, reader)
    assert heard.robots[0].so == area(dedicated=0x0316)
    assert heard.robots[0].connections[1].to_master.packets == 1
    assert not any("SO(02) OFF" in line for line in heard.lines)


def test_equal_identifiers_of_two_controllers_are_distinct(tmp_path: Path) -> None:
    """If two controllers use the same connection identifier, their packets are not mixed up.

    Each adapter chooses its own identifiers.
    """
    first, second = _quiet(Story()), _quiet(Story(controller="192.168.0.11"), 3_000, 5)
    second.both(100_000, FREE, area(dedicated=0x0112))
    heard = Heard(tmp_path, first, second)
    assert [one.connections[0].to_robot.packets for one in heard.robots] == [10, 6]
    assert [one.number for one in heard.robots] == [1, 2]
    assert any(line.endswith("s  2: SO(11) OFF  Return-to-origin complete status output")
               for line in heard.lines)  # fmt: skip


def test_a_reopened_connection_counts_as_a_new_connection(tmp_path: Path) -> None:
    """After a new Forward Open, packet numbers restart, and old areas are not compared."""
    story = _quiet(Story())
    story.open(1_000_000)
    story.both(1_010_000, area(dedicated=0x8043), OK)
    heard = Heard(tmp_path, story)
    (robot,) = heard.robots
    assert [(one.to_robot.packets, one.to_robot.late) for one in robot.connections] == [
        (10, 0),
        (1, 0),
    ]
    assert robot.connections[0].end == "replaced by a new one"
    assert heard.result.count == 0


def test_a_refused_connection_is_reported_with_its_reason(tmp_path: Path) -> None:
    """A refused Forward Open is reported with its reason, here 0x0106 (ownership conflict).

    Source: CIP volume 1, chapter 3, 5.6.
    """
    story = _quiet(Story())
    other = Story("192.168.0.2", o_to_t=0x99)
    other.refuse(50_000, "0601")
    lines = Heard(tmp_path, story, other).lines
    text = "refuses a connection of 192.168.0.2: another master owns the outputs (16#01, 16#0106)"
    assert [line for line in lines if "refuses" in line] == [f"    0.050500 s  {text}"]


def test_other_devices_are_counted_and_not_judged(tmp_path: Path) -> None:
    """Connections to other devices are counted. Their connection points or sizes differ."""
    story = _quiet(Story())
    drive = Story(controller="192.168.0.20")
    drive.open(0, path="2004 2405 2C65 2C66")
    small = Story(controller="192.168.0.21", o_to_t=0x55)
    small.open(0, o_to_t="2648", t_to_o="2248")
    for k in range(1, 5):
        drive.both(10_000 * k, FREE, OK)
        small.both(10_000 * k, FREE[:32], OK[:32])
    heard = Heard(tmp_path, story, drive, small)
    assert [one.host for one in heard.robots] == [HOST]
    assert heard.result.network is not None
    strangers = [one for one in heard.result.network.strangers.values() if one.packets]
    assert sorted(one.packets for one in strangers) == [4, 4, 4, 4]
    assert {one.text for one in strangers} == {
        "of 192.168.0.20, 50 and 54 bytes",
        "of 192.168.0.21, 34 and 38 bytes",
    }


def _headless(story: Story) -> Story:
    """Return a capture without a Forward Open and its answer, as if recording began later."""
    del story.packets[:2]
    return story


def test_a_capture_that_begins_later_takes_the_address_from_the_options(tmp_path: Path) -> None:
    story = _headless(_quiet(Story()))
    heard = Heard(tmp_path, story, hosts=[HOST])
    (robot,) = heard.robots
    (one,) = robot.connections
    assert (one.kind.value, one.opened, robot.size) == ("exclusive owner", False, 48)
    assert (one.to_robot.packets, one.to_master.packets) == (10, 10)
    assert (one.peer, heard.result.count) == (bytes([192, 168, 0, 1]), 0)
    assert heard.scans()[-1].si == FREE
    assert heard.scans()[-1].so == OK


def test_without_the_option_it_says_which_one_to_give(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"20 of class 1; perhaps --controller 192\.168\.0\.10$"):
        Heard(tmp_path, _headless(_quiet(Story())))


_OF_64 = (
    r"the areas of 192\.168\.0\.10 have 64 bytes, those of a controller 48 or 256: set one of "
    r"these in controller and PLC, unless it is another device$"
)


@pytest.mark.parametrize(
    ("options", "advice"),
    [
        ({}, _OF_64),
        ({"hosts": [HOST]}, _OF_64),
        (
            {"hosts": [bytes([192, 168, 0, 1])]},
            r"192\.168\.0\.1 is the master: perhaps --controller 192\.168\.0\.10$",
        ),
        (
            {"hosts": [bytes([192, 168, 0, 99])]},
            r"the capture has no class 1 packet to or from 192\.168\.0\.99, only packets of "
            r"192\.168\.0\.1, 192\.168\.0\.10$",
        ),
    ],
)
@pytest.mark.parametrize("begins_later", [True, False])
def test_areas_of_64_bytes_are_named_whatever_the_options_say(
    tmp_path: Path, options: dict[str, Any], advice: str, *, begins_later: bool
) -> None:
    """Source: manual chapter 1, 4.2 (48 bytes, or 256)."""
    story = Story()
    story.open(0, o_to_t="4648", t_to_o="4248")
    for k in range(1, 11):
        story.both(10_000 * k, FREE + bytes(16), OK + bytes(16))
    with pytest.raises(InputError, match=advice):
        Heard(tmp_path, _headless(story) if begins_later else story, **options)


def test_a_size_other_than_the_option_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"192\.168\.0\.10 have 48 bytes: --size 48$"):
        Heard(tmp_path, _headless(_quiet(Story())), hosts=[HOST], sizes=(256,))


@pytest.mark.parametrize(("size", "found"), [((48,), True), ((256,), False)])
def test_the_size_of_the_options_is_the_only_one(
    tmp_path: Path, size: tuple[int, ...], found: bool
) -> None:
    story = _headless(_quiet(Story()))
    if found:
        assert Heard(tmp_path, story, hosts=[HOST], sizes=size).robots
    else:
        with pytest.raises(InputError, match="contains no connection of a controller"):
            Heard(tmp_path, story, hosts=[HOST], sizes=size)


def test_a_named_controller_is_the_only_one_and_may_have_other_instances(tmp_path: Path) -> None:
    """With `--controller`, only the named device is judged, at any connection points.

    Another adapter has the same sizes, at points 0x70 and 0x71.
    """
    other = Story(controller="192.168.0.20")
    other.open(0, path="2004 2405 2C70 2C71")
    other.both(10_000, FREE, OK)
    heard = Heard(tmp_path, _quiet(Story()), other, hosts=[bytes([192, 168, 0, 20])])
    assert [one.host[3] for one in heard.robots] == [20]


def test_an_idle_header_and_a_time_out_are_reported(tmp_path: Path) -> None:
    """An idle header and a time-out of the connection are reported.

    The time-out of this Forward Open is 16 intervals of 10 ms (multiplier 2).
    """
    story = _quiet(Story())
    story.to_robot(110_000, FREE, run=False)
    story.to_plc(110_500, OK)
    story.to_robot(271_000, FREE)
    lines = Heard(tmp_path, story).lines
    told = [
        line[14:].strip() for line in lines if "program of the PLC" in line or "no packets" in line
    ]
    assert told == [
        "the program of the PLC runs",
        "the program of the PLC is stopped (idle header)",
        "no packets to the controller for 161 ms; time-out 160 ms",
        "the program of the PLC runs",
    ]


def test_the_trace_has_every_change_and_nothing_twice(tmp_path: Path) -> None:
    story = Story()
    story.open(0)
    for k, si in enumerate([FREE, FREE, area({2: 5}, 0x41), area({2: 5}, 0x41)]):
        story.both(10_000 * (k + 1), si, OK)
    scans = Heard(tmp_path, story).scans()
    assert [(one.t_us, one.scan, one.so == OK, one.si) for one in scans] == [
        (10_500, 4, True, FREE),
        (30_000, 7, True, area({2: 5}, 0x41)),
    ]
