# ruff: noqa: RUF001 - these characters draw the chart
from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from rcx_harness.spec import command_name
from rcx_harness.trace import Cycle, Scan, Trace, Violation
from rcx_harness.trace.chart import Timeline, text_chart, time_labels
from rcx_harness.trace.chart_svg import svg_chart
from structured_text.language.types import ElementaryType

SVG = "{http://www.w3.org/2000/svg}"


def area(code: int = 0, byte32: int = 0, byte33: int = 0) -> bytes:
    return code.to_bytes(2, "little") + bytes(30) + bytes([byte32, byte33]) + bytes(14)


def servo_on() -> Timeline:
    """Return a timeline: SI(01) ON from 100 to 250 ms, SO(02) ON at 150 ms, then a command."""
    timeline = Timeline()
    steps = [
        (0, area(), area()),
        (100, area(), area(byte32=0x02)),
        (150, area(byte32=0x04), area(byte32=0x02)),
        (250, area(byte32=0x04), area()),
        (300, area(byte32=0x04), area(code=0x0001)),
        (320, area(code=0x0100, byte32=0x04), area(code=0x0001)),
        (900, area(code=0x0200, byte32=0x04), area()),
    ]
    for number, (ms, so, si) in enumerate(steps):
        timeline.take(Scan(ms * 1000, number, so, si))
    return timeline


def test_the_chart_shows_what_changed_and_when() -> None:
    """The chart shows inputs, outputs, code and status, with each change under its time."""
    assert text_chart(servo_on(), 80) == (
        "time [ms]                       100   150   250   300   320   900\n"
        "SI(01) Servo ON input         ▁▁╱▔▔▔▔▔▔▔▔▔▔▔╲▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁\n"
        "SO(02) Servo ON status output ▁▁▁▁▁▁▁▁╱▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔\n"
        "Remote command code           ────────────────────╳MovePtp────╳─────\n"
        "Remote status                 ──────────────────────────╳0100─╳0200─\n"
    )


def test_the_chart_has_an_ascii_form() -> None:
    chart = text_chart(servo_on(), 80, ascii_only=True)
    assert chart.isascii()
    assert 'SI(01) Servo ON input         __/"""""""""""\\____' in chart


def test_a_chart_of_many_changes_goes_on_in_bands_that_fit() -> None:
    timeline = Timeline()
    for number in range(60):
        timeline.take(Scan(number * 100_000, number, area(), area(byte32=number % 2)))
    for width in (80, 100, 120):
        lines = text_chart(timeline, width).splitlines()
        assert max(map(len, lines)) <= width
        times = [float(word) for line in lines for word in re.findall(r"(?<= )\d+(?= |$)", line)]
        assert times == [number * 100 for number in range(1, 60)]


def test_a_broken_rule_is_marked_at_its_time() -> None:
    timeline = servo_on()
    timeline.take(Violation(250_000, "interval", "interval: in words"))
    last = text_chart(timeline, 80).splitlines()[-1]
    assert last.startswith("Rule broken")
    assert last.index("▲") == text_chart(timeline, 80).splitlines()[0].index("250")


def test_a_run_without_any_change_says_so() -> None:
    timeline = Timeline()
    timeline.take(Scan(0, 0, area(), area()))
    assert text_chart(timeline, 80) == "no dedicated signal and no remote command changed\n"
    assert "no dedicated signal" in svg_chart(timeline)


def test_times_have_as_many_decimals_as_they_need() -> None:
    assert time_labels([10_000, 20_000]) == ["10", "20"]
    assert time_labels([10_000, 20_500]) == ["10.0", "20.5"]
    assert time_labels([10_001]) == ["10.001"]


def test_the_svg_names_every_signal_and_time_and_is_the_same_every_time() -> None:
    picture = svg_chart(servo_on(), "a < b")
    assert picture == svg_chart(servo_on(), "a < b")
    texts = [node.text for node in ElementTree.fromstring(picture).iter(f"{SVG}text")]
    names = ("SI(01) Servo ON input", "SO(02) Servo ON status output")
    for expected in ("a < b", *names, "250", "MovePtp"):
        assert expected in texts
    assert [text for text in texts if text and text.startswith("0x")] == ["0x0100", "0x0200"]
    assert "+50" in texts


def test_a_long_run_says_what_the_chart_leaves_out() -> None:
    timeline = Timeline()
    for number in range(500):
        timeline.take(Scan(number * 100_000, number, area(), area(byte32=number % 2)))
    assert "99 further instants are left out" in text_chart(timeline, 100)
    assert "99 further instants are left out" in svg_chart(timeline)


def test_a_column_is_wide_enough_for_its_text() -> None:
    """A column is as wide as its text: ReadPositionPulses fits into one.

    A very long text is cut.
    """
    timeline = Timeline(Trace({}, watched={"Main.Text": ElementaryType("STRING")}))
    for ms, code, text in ((0, 0, ""), (100, 0x0505, "a"), (110, 0, "x" * 30), (120, 0, "b")):
        timeline.take(Scan(ms * 1000, 0, area(), area(code), {"Main.Text": text}))
    lines = {line[:19].strip(): line[20:] for line in text_chart(timeline, 100).splitlines()}
    assert "\u2573ReadPositionPulses\u2500\u2573" in lines["Remote command code"]
    assert f"\u2573'{'x' * 23}\u2026" in lines["Main.Text"], "24 characters and a sign for the rest"
    assert "\u2573'b'" in lines["Main.Text"]
    texts = [n.text or "" for n in ElementTree.fromstring(svg_chart(timeline)).iter(f"{SVG}text")]
    assert "ReadPositionPulses" in texts
    assert [len(one) for one in texts if one.startswith("'xx")] == [24]
    tips = [node.text for node in ElementTree.fromstring(svg_chart(timeline)).iter(f"{SVG}title")]
    assert f"'{'x' * 30}'" in tips, "the whole text"


def test_texts_of_a_chart_in_ascii_are_in_ascii_and_pictures_are_of_whole_characters() -> None:
    timeline = Timeline(Trace({}, watched={"Main.Text": ElementaryType("WSTRING")}))
    for ms, text in ((0, ""), (10, "\xe9\x1b<\ud83d")):
        timeline.take(Scan(ms * 1000, 0, area(), area(), {"Main.Text": text}))
    chart = text_chart(timeline, 80, ascii_only=True)
    assert "X'?$1B<?'" in chart
    assert chart.isascii()
    texts = [node.text for node in ElementTree.fromstring(svg_chart(timeline)).iter(f"{SVG}text")]
    assert "'\xe9$1B<\ufffd'" in texts
    svg_chart(timeline).encode()


@pytest.mark.parametrize(
    ("code", "name"),
    [(0x0001, "MovePtp"), (0x2001, "MovePtp R2"), (0x0FFF, "0x0FFF"), (0x1100, "0x1100")],
)
def test_a_code_is_shown_by_the_name_of_its_command_or_as_a_number(code: int, name: str) -> None:
    """A code is shown by the name of its command, an unknown code as a number.

    0x0100, WritePoint, has no robot designation. With a robot number it is not a command.
    """
    assert command_name(code) == name


def test_variables_that_rest_are_left_out_where_there_are_many() -> None:
    def lanes(many: int) -> list[str]:
        paths = [f"Main.V{k}" for k in range(many)]
        timeline = Timeline(Trace({}, watched=dict.fromkeys(paths, ElementaryType("BOOL"))))
        for ms in (0, 10):
            values = {path: path == "Main.V3" and ms > 0 for path in paths}
            timeline.take(Scan(ms * 1000, 0, area(), area(), values))
        return [lane.name for lane in timeline.lanes() if lane.name.startswith("Main.")]

    assert len(lanes(16)) == 16
    assert lanes(17) == ["Main.V3"]


def test_positions_make_no_columns() -> None:
    timeline = Timeline(Trace({}, axes=[["X [mm]"]]))
    for ms in range(0, 1000, 5):
        timeline.take(Cycle(ms * 1000, 0, b"", area(), 1, (ms / 10,)))
        timeline.take(Scan(ms * 1000, 0, area(), area(byte32=0x02 if ms >= 500 else 0)))
    lines = text_chart(timeline, 80).splitlines()
    assert lines[0].split()[2:] == ["500"]
    assert next(line for line in lines if line.startswith("X [mm]")).endswith(
        "\u257350\u2500\u2500\u2500"
    )
