# ruff: noqa: RUF001 - these characters draw the chart
"""Charts to scale have a time axis on which each character is the same time."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from rcx_harness.trace import Cycle, Scan, Trace, Violation
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.scale import scaled_svg, scaled_text
from structured_text.language.types import ElementaryType, EnumType, Type

SVG = "{http://www.w3.org/2000/svg}"
#: Length of the longest name. WIDTH adds two spaces, and 80 characters for the lanes.
NAMES = len("Remote command code")
WIDTH = NAMES + 2 + 80
STATE = EnumType("STATE", ("IDLE", "RUN"))


def area(code: int = 0, byte32: int = 0) -> bytes:
    return code.to_bytes(2, "little") + bytes(30) + bytes([byte32]) + bytes(15)


def run(end_ms: int = 599) -> Timeline:
    """Return a trace with a scan every ms.

    SI(06) is ON from 100 ms to 250 ms, and MOVE PTP begins at 300 ms.
    """
    timeline = Timeline()
    for ms in range(end_ms + 1):
        si = area(code=0x0001 if ms >= 300 else 0, byte32=0x40 if 100 <= ms < 250 else 0)
        timeline.take(Scan(ms * 1000, ms, area(), si))
    return timeline


def moving(end_ms: int = 100) -> Timeline:
    """Return a trace in which X goes from 0 to 100 mm at 1 mm per ms, and Y does not move."""
    timeline = Timeline(Trace({}, axes=[["X [mm]", "Y [mm]"]]))
    for ms in range(end_ms + 1):
        timeline.take(Cycle(ms * 1000, ms, b"", area(), 1, (float(ms), 0.0)))
    timeline.take(Scan(end_ms * 1000, 0, area(byte32=1), area()))
    return timeline


def test_each_line_shows_the_same_time() -> None:
    """Each line of the chart shows the same time, and each character its share of it.

    80 characters for 800 ms are 10 ms each. The last line is shorter if less time remains.
    """
    lines = scaled_text(run(), WIDTH, line_us=800_000).splitlines()
    assert lines == [
        f"{'time [ms]':<{NAMES}} 0         100       200       300       400       500",
        f"{'SI(06) Stop input':<{NAMES}} {'▁' * 10}╱{'▔' * 14}╲{'▁' * 34}",
        f"{'Remote command code':<{NAMES}} {'─' * 30}╳MovePtp{'─' * 22}",
        f"{'Remote status':<{NAMES}} {'─' * 60}",
    ]


def test_a_further_line_repeats_the_command() -> None:
    lines = scaled_text(run(), WIDTH, line_us=400_000).splitlines()
    assert [line.split()[2] for line in lines if line.startswith("time")] == ["0", "400"]
    second = lines[lines.index("") + 1 :]
    assert [line[:NAMES].rstrip() for line in second] == [
        "time [ms]",
        "Remote command code",
        "Remote status",
    ]
    assert second[1].split()[-1].startswith("─MovePtp─")
    assert len(second[1].split()[-1]) == 40, "half a line, for 200 ms of 400"


def test_without_a_length_there_are_at_most_six_lines() -> None:
    for end_ms, begins in ((600, range(0, 501, 100)), (601, range(0, 601, 200))):
        lines = scaled_text(run(end_ms), 100).splitlines()
        heads = [line.split()[2] for line in lines if line.startswith("time")]
        assert heads == [str(begin) for begin in begins]


def test_several_changes_in_one_character_are_a_cross() -> None:
    timeline = Timeline()
    for ms in range(800):
        timeline.take(Scan(ms * 1000, ms, area(), area(byte32=0x40 if ms in (402, 799) else 0)))
    line = scaled_text(timeline, WIDTH, line_us=800_000).splitlines()[1]
    assert line == f"{'SI(06) Stop input':<{NAMES}} {'▁' * 40}╳{'▁' * 38}╱"


def test_a_curve_goes_up_in_eight_steps_and_says_from_where_to_where() -> None:
    lines = scaled_text(moving(), 100, line_us=100_000).splitlines()
    x = next(line for line in lines if line.startswith("X [mm] 0 to 100 "))
    wave = x.split()[-1]
    assert sorted(set(wave)) == list("▁▂▃▄▅▆▇█")
    assert list(wave) == sorted(wave)
    counts = [wave.count(level) for level in "▁▂▃▄▅▆▇█"]
    assert max(counts) - min(counts) <= 1, "steps of the same length"
    y = next(line for line in lines if line.startswith("Y [mm] 0 to 0 "))
    assert set(y.split()[-1]) == {"▁"}
    ascii_only = scaled_text(moving(), 100, ascii_only=True, line_us=100_000)
    assert ascii_only.isascii()
    assert "__..::--==++**##" in re.sub(r"(.)\1+", r"\1\1", ascii_only)


def test_a_number_that_changes_all_the_time_is_a_curve_and_others_are_texts() -> None:
    watched: dict[str, Type] = {
        "Main.N": ElementaryType("INT"),
        "Main.S": STATE,
        "Main.T": ElementaryType("REAL"),
    }
    timeline = Timeline(Trace({}, watched=watched))
    for ms in range(200):
        values = {"Main.N": ms, "Main.S": STATE.members[ms >= 100], "Main.T": float("nan")}
        timeline.take(Scan(ms * 1000, ms, area(), area(), values))
    width = len("Remote command code") + 2 + 80
    lines = scaled_text(timeline, width, line_us=200_000).splitlines()
    assert any(line.startswith("Main.N 0 to 199 ") for line in lines)
    state = next(line for line in lines if line.startswith("Main.S "))
    assert state.split()[-1] == f"─IDLE{'─' * 35}╳RUN{'─' * 36}"
    assert "RUN" in scaled_svg(timeline)


def test_a_broken_rule_is_marked_where_it_was() -> None:
    timeline = run()
    timeline.take(Violation(599_000, "interval", "interval: in words"))
    marks = scaled_text(timeline, WIDTH, line_us=800_000).splitlines()[-1]
    assert marks == f"{'Rule broken':<{NAMES}} {' ' * 59}▲"
    assert scaled_svg(timeline).count("12l-6 -13Z") == 1


def test_the_picture_is_true_to_scale() -> None:
    """In the SVG picture, the time axis is to scale: 1000 pixels for 500 ms are 2 pixels per ms."""
    root = ElementTree.fromstring(scaled_svg(run(), "a < b", 500_000))
    texts = {node.text: float(node.get("x") or 0) for node in root.iter(f"{SVG}text")}
    assert "a < b" in texts
    assert "MovePtp" in texts
    left = texts["0"]
    assert [texts[name] - left for name in ("50", "100", "300", "450")] == [100, 200, 600, 900]
    waves = [node.get("d") or "" for node in root.iter(f"{SVG}path")]
    edges = [float(x) - left for x in re.findall(r"H([\d.]+)V", waves[0])]
    assert edges == [200, 500]
    assert float(root.get("width") or 0) < 1500


def test_curves_of_a_picture_have_their_limits_of_the_whole_run_on_every_line() -> None:
    texts = re.findall(r'class="m e"[^>]*>([^<]+)<', scaled_svg(moving(), line_us=50_000))
    assert texts == ["0", "100", "0"] * 2


def test_the_same_run_gives_the_same_picture() -> None:
    assert scaled_svg(run(), "t") == scaled_svg(run(), "t")


@pytest.mark.parametrize("draw", [scaled_svg, scaled_text])
def test_instants_that_are_left_out_are_reported(draw: object) -> None:
    assert callable(draw)
    assert "the part after 500 ms is left out; make a line longer" in draw(run(), line_us=5_000)
    assert "left out" not in draw(run(), line_us=6_000)


def test_a_run_without_any_change_says_so() -> None:
    timeline = Timeline()
    timeline.take(Scan(0, 0, area(), area()))
    assert scaled_text(timeline, 80) == "no dedicated signal and no remote command changed\n"
    assert "no dedicated signal" in scaled_svg(timeline)
