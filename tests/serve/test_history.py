"""The last seconds of a controller are shown as lanes in a chart."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from rcx_harness.serve.history import History, live_chart
from rcx_harness.serve.status import Change
from rcx_harness.trace.chart import Lane


def _change(
    t_us: int, si: str = "00000000", so: str = "00000000", connected: bool = True
) -> Change:
    return Change(t_us, connected, si, so)


def _lane(history: History, name: str) -> list[tuple[int, int]]:
    return next(lane.changes for lane in history.lanes() if lane.name.startswith(name))


def test_every_dedicated_signal_has_its_lane_between_connection_and_words() -> None:
    names = [lane.name for lane in History().lanes()]
    assert names[:2] == ["Connection with the master", "SI(00) Emergency stop input"]
    assert names[-3:] == ["SO(15) Warning output", "Remote command code", "Remote status"]
    assert len(names) == 1 + 9 + 11 + 2


def test_a_lane_holds_the_changes_of_its_own_bit_or_word() -> None:
    history = History()
    history.add([_change(5000), _change(10_000, si="01104100", so="00020480")], 10_000)
    history.add([_change(20_000, si="01104000", so="00020480", connected=False)], 25_000)
    assert _lane(history, "Connection") == [(5000, 1), (20_000, 0)]
    assert _lane(history, "SI(00)") == [(10_000, 1), (20_000, 0)]
    assert _lane(history, "SI(06)") == [(10_000, 1)]
    assert _lane(history, "SO(02)") == [(10_000, 1)]
    assert _lane(history, "SO(00)") == []
    assert _lane(history, "Remote command code") == [(10_000, 0x1001)]
    assert _lane(history, "Remote status") == [(10_000, 0x0200)]


def test_the_chart_names_the_command() -> None:
    history = History()
    history.add([_change(10_000, si="01200000", so="00010000")], 10_000)
    drawn = live_chart(history.lanes(), 1_000_000, 1.0)
    assert ">MovePtp R2<" in drawn
    assert ">0x0100<" in drawn


@pytest.mark.parametrize(("width", "least"), [(344, 0.95), (1266, 0.7)])
def test_the_waves_have_most_of_the_width(width: int, least: float) -> None:
    """The waves use most of the width of the chart. In a narrow chart the names are above them."""
    drawn = live_chart(History().lanes(), 1_000_000, 1.0, width)
    box = re.search(r'viewBox="0 0 (\d+) (\d+)".* data-left="(\d+)" data-plot="(\d+)"', drawn)
    assert box is not None
    all_width, height, left, plot = map(int, box.groups())
    assert (all_width, left + plot <= width) == (width, True)
    assert plot >= least * width
    rows = [float(y) for y in re.findall(r'<text x="20" y="([\d.]+)"', drawn)]
    assert len(rows) == 23
    assert max(rows) < height


def test_old_changes_are_removed_except_for_the_state_they_left() -> None:
    history = History(kept_us=1_000_000)
    history.add([_change(0, si="00004000"), _change(500_000, si="00004100")], 500_000)
    history.add([_change(1_200_000, si="00000100")], 1_600_000)
    assert _lane(history, "SI(06)") == [(500_000, 1), (1_200_000, 0)]
    history.add([], 9_000_000)
    assert _lane(history, "SI(00)") == [(1_200_000, 1)]


def test_memory_stays_bounded_however_much_changes() -> None:
    history = History(most=10)
    for number in range(1000):
        history.add([_change(number, si=f"0000{number % 2:02}00")], number)
    assert len(_lane(history, "SI(00)")) <= 10


def _chart(lanes: list[Lane], now_us: int, seconds: float) -> ElementTree.Element:
    return ElementTree.fromstring(live_chart(lanes, now_us, seconds))


def _paths(root: ElementTree.Element) -> list[str]:
    return [path.attrib["d"] for path in root.iter("{http://www.w3.org/2000/svg}path")]


def test_a_bit_rises_and_falls_where_its_time_lies_on_the_axis() -> None:
    lane = Lane("SI(00) Emergency stop input", "input", [(4_500_000, 1), (4_750_000, 0)])
    (path,) = _paths(_chart([lane], 5_000_000, 1))
    # In the picture, a second is 900 wide and begins at x = 352. OFF is at y = 46, ON at y = 33.
    assert path == "M352 46H802V33H1027V46H1252"


def test_a_bit_that_was_on_before_begins_on() -> None:
    lane = Lane("x", "input", [(1000, 1)])
    assert _paths(_chart([lane], 5_000_000, 1)) == ["M352 33H1252"]


def test_nothing_is_drawn_before_time_began() -> None:
    assert _paths(_chart([Lane("x", "input")], 500_000, 1)) == ["M802 46H1252"]


def test_a_word_is_a_box_with_its_digits_or_with_a_tip_where_there_is_no_room() -> None:
    lane = Lane("code", "word", [(100_000, 1), (200_000, 0), (300_000, 0x1002), (301_000, 0)])
    text = live_chart([lane], 1_000_000, 1)
    assert re.findall(r"<title>(0x\w+)</title>", text) == ["0x0001", "0x1002"]
    assert re.findall(r">(0x\w+)</text>", text) == ["0x0001"]


def test_the_axis_has_round_times() -> None:
    text = live_chart([Lane("x", "input")], 12_345_000, 10)
    assert re.findall(r">(\S+) s</text>", text) == [str(number) for number in range(3, 13)]
    assert 'data-start="2345000" data-span="10000000"' in text


def test_a_lamp_is_filled_while_the_signal_is_on() -> None:
    lanes = [Lane("on", "output", [(10, 1)]), Lane("off", "output", [(10, 1), (20, 0)])]
    text = live_chart(lanes, 1_000_000, 1)
    assert re.findall(r'r="4.5" (\w+=\S+)/>', text) == ['fill="#1b7a3d"', 'class="o"']


def test_names_are_text_and_never_markup() -> None:
    assert "&lt;b&gt;" in live_chart([Lane("<b>", "input")], 1_000_000, 1)
