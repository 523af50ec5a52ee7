"""Events can stop the PLC, switch its power, delay its scans, and disturb packets."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from feeder import feeder
from rcx_harness.cell import Cell
from rcx_harness.cell.link import PacketNetwork
from rcx_harness.cell.stimulus import Entry, Stimulus, stimulus_text
from structured_text.errors import InputError


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[Cell]:
    """Return a cell in which the program has fed and counted at least one part."""
    with Cell.build(feeder(tmp_path), engine="builtin") as made:
        made.run("200ms")
        made["Main.Closed"] = True
        made["Main.Reset"] = True
        made.run("50ms")
        made["Main.Reset"] = False
        made["Main.Go"] = True
        made.run("50ms")
        made["Main.Go"] = False
        made.run("1s")
        assert made["Main.Fed"] == made["Main.Total"] > 0
        yield made


@pytest.mark.parametrize(("start", "fed", "total"), [("warm", False, True), ("cold", False, False)])
def test_a_warm_start_keeps_retained_data(cell: Cell, start: str, fed: bool, total: bool) -> None:
    """A warm start keeps retained data; a cold start does not. Source: IEC 61131-3, 2.4.2."""
    cell.inject("plc_stop")
    scans = cell.scans
    cell.run("500ms")
    assert cell.scans == scans
    cell.inject("plc_run", start=start)
    cell.run("20ms")
    assert (bool(cell["Main.Fed"]), bool(cell["Main.Total"])) == (fed, total)
    assert not cell["Main.Running"]


def test_a_plc_that_continues_must_connect_again(cell: Cell) -> None:
    fed = cell["Main.Fed"]
    cell.inject("plc_stop")
    cell.run("20ms")
    cell.inject("plc_run", start="continue")
    cell.run("10ms")
    assert cell["Main.Fed"] == fed
    assert cell["Main.Broken"]
    cell.run("1s")
    assert cell["Main.Connected"]
    assert not cell.violations


def test_after_a_start_inputs_keep_their_values_and_other_variables_do_not(cell: Cell) -> None:
    cell.inject("plc_power_off")
    cell.run("200ms")
    cell.inject("plc_power_on")
    cell.run("20ms")
    assert cell["Main.Closed"]
    assert not cell["Main.Running"]


def test_a_plc_without_power_does_not_continue(cell: Cell) -> None:
    cell.inject("plc_power_off")
    with pytest.raises(InputError, match="start = continue is not possible"):
        cell.inject("plc_power_on", start="continue")
    with pytest.raises(InputError, match="is not in RUN, so no scan can run"):
        cell.scan()


def test_a_late_scan_delays_all_later_scans(cell: Cell) -> None:
    cell.scan()
    last = cell.now_us
    cell.inject("plc_overrun", by="35ms")
    times = []
    for _ in range(3):
        cell.scan()
        times.append(cell.now_us - last)
    assert times == [45_000, 55_000, 65_000]


def test_packets_are_lost_until_the_share_is_0(cell: Cell) -> None:
    cell.inject("packets_lost", to="plc")
    cell.run("200ms")
    assert not cell["Main.Connected"]
    network = cell.network_of(1)
    assert isinstance(network, PacketNetwork)
    lost = network.disturbed["lost"]
    assert lost > 5
    cell.inject("packets_lost", share=0)
    cell.run("500ms")
    assert cell["Main.Connected"]
    assert network.disturbed["lost"] == lost


def test_a_snapshot_has_plc_and_disturbances(cell: Cell) -> None:
    before = cell.snapshot()
    cell.inject("plc_stop")
    cell.inject("packets_lost")
    cell.inject("packet_interval", rpi="30ms")
    cell.run("100ms")
    cell.restore(before)
    fed = cell["Main.Fed"]
    cell.run("500ms")
    assert cell["Main.Fed"] > fed
    assert cell.timing.rpi_us == 10_000


@pytest.mark.parametrize(
    ("event", "args", "message"),
    [
        ("packets_lost", {"share": 2}, "share = 2 is not a share of the packets"),
        ("packets_late", {"to": "nobody"}, "to = 'nobody' is not a direction"),
        ("plc_run", {"start": "hot"}, "start = 'hot' is not a kind of start"),
        ("plc_overrun", {"by": 5}, "by is not a text"),
        ("packet_interval", {}, "needs rpi"),
        ("link_down", {"share": 1}, "takes no arguments"),
        ("plc_stop", {"by": "1ms"}, "has no argument 'by'"),
    ],
)
def test_a_wrong_argument_of_an_event_is_refused(
    cell: Cell, event: str, args: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        cell.inject(event, **args)


# --- events in a stimulus file ------------------------------------------------------------------


def _load(tmp_path: Path, text: str) -> Stimulus:
    file = tmp_path / "s.toml"
    file.write_text(text)
    return Stimulus.load(file)


def test_an_event_with_a_duration_ends_after_this_time(cell: Cell, tmp_path: Path) -> None:
    _load(
        tmp_path,
        'at = [\n  { time = "1400ms", set = { "Main.Go" = true }, for = "100ms" },\n'
        '  { time = "1400ms", plc = { event = "stop", start = "cold" }, for = "200ms" },\n]\n',
    ).schedule(cell)
    cell.run(1_450_000 - cell.now_us)
    assert cell["Main.Go"]
    assert not cell.plc.runs
    cell.run("200ms")
    assert not cell["Main.Go"]
    assert cell.plc.runs
    assert cell["Main.Total"] == 0


def test_an_expectation_that_fails_is_a_violation(cell: Cell, tmp_path: Path) -> None:
    _load(
        tmp_path,
        'at = [\n  { time = "1400ms", expect = ["Main.Running", "Main.Fed > 1000"] },\n]\n',
    ).schedule(cell)
    cell.run("200ms")
    assert [one.text.partition("expect: ")[2] for one in cell.violations] == [
        "Main.Fed > 1000 does not hold"
    ]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('set = { "Main.Speed" = 3 }, for = "1s"', "true and false only, not with Main.Speed"),
        ('robot = "alarm", for = "1s"', "'alarm' cannot have a duration"),
        ('for = "1s"', "'for' needs"),
        ('set = { "Main.Go" = true }, for = "0s"', "longer than 0"),
        ('robot = "plc_stop"', 'write plc = "stop"'),
        ('plc = "stopp"', "unknown event 'stopp'; did you mean stop"),
        ('expect = "Main.Fedd > 1"', "did you mean Fed"),
    ],
)
def test_a_wrong_entry_is_refused_with_its_line(
    cell: Cell, tmp_path: Path, entry: str, message: str
) -> None:
    with pytest.raises(InputError, match=message) as raised:
        _load(tmp_path, f'at = [\n  {{ time = "2s", {entry} }},\n]\n').schedule(cell)
    assert raised.value.line == 2


def test_entries_are_written_as_they_are_read(tmp_path: Path) -> None:
    entries = [
        Entry(1_500, values={"Main.Go": True}, held_us=100_000),
        Entry(2_000, events=(("alarm", {"group": 12, "category": 600}),), controller=2),
        Entry(3_000, events=(("plc_stop", {"start": "cold"}), ("link_down", {})), held_us=5_000),
        Entry(4_000, hold=("SO03",), release=("SO02", "SO01"), area=b"\x01\x02", connected=False),
        Entry(5_000, expect=("Main.Fed > 3",)),
    ]
    back = _load(tmp_path, stimulus_text(entries, "two\nlines")).entries
    assert [one.__dict__ | {"line": 0} for one in back] == [
        one.__dict__ | {"events": tuple(sorted(one.events, key=lambda e: e[0][:4] == "plc_"))}
        for one in entries
    ]


def test_zeros_at_the_end_of_an_area_are_not_written() -> None:
    text = stimulus_text([Entry(0, area=b"\1\2\3" + bytes(45)), Entry(1_000, area=bytes(48))])
    assert text == (
        'at = [\n  { time = "0ms", area = "0102 0300" },\n  { time = "1ms", area = "0000" },\n]\n'
    )
