"""The pictures of the processes are equal on every engine, readable, and show only real changes."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rcx_harness.trace.chart import Lane
from rcx_tools.docs import pages as docs
from rcx_tools.docs.processes import FOLDER, Step, process_chart, processes, run_process
from rcx_tools.docs.processes_svg import process_svg
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.portability import lint

_SVG = "{http://www.w3.org/2000/svg}"
_each = pytest.mark.parametrize("name", processes())

#: Width of a character and alignment of the text, by class; 13 px without a class.
_WIDTHS = {"h": 8.8, "s": 6.2, "d": 6.0, "p": 6.6, "n": 6.4, "q": 7.2, "v": 7.3, "t": 7.4}


def _boxes(picture: str) -> list[tuple[str, float, float, float, float]]:
    """Return every text of a picture with its estimated left, right, top and bottom."""
    found = []
    for node in ElementTree.fromstring(picture).iter(f"{_SVG}text"):
        kinds = node.get("class", "").split()
        width = len(node.text or "") * (_WIDTHS[kinds[0]] if kinds and kinds[0] != "e" else 7.3)
        x, y = float(node.get("x", "")), float(node.get("y", ""))
        if "e" in kinds:
            x -= width
        elif kinds and kinds[0] in "tdpn":
            x -= width / 2
        found.append((node.text or "", x, x + width, y - 9, y + 2))
    return found


@_each
def test_no_two_texts_of_a_chart_overlap_and_none_leaves_it(name: str) -> None:
    picture = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    match = re.match(r'<svg [^>]*width="(\d+)" height="(\d+)"', picture)
    assert match
    boxes = _boxes(picture)
    for k, (text, left, right, top, bottom) in enumerate(boxes):
        assert left >= 0, text
        assert right <= int(match[1]), text
        assert bottom <= int(match[2]), text
        for other, left2, right2, top2, bottom2 in boxes[k + 1 :]:
            apart = right <= left2 or right2 <= left or bottom <= top2 or bottom2 <= top
            assert apart, f"{text!r} and {other!r}"


@_each
def test_every_step_is_at_its_edges_and_in_the_legend(name: str) -> None:
    texts = [text for text, *_ in _boxes((FOLDER / f"{name}.svg").read_text(encoding="utf-8"))]
    for number, step in enumerate(processes()[name].steps, 1):
        assert texts.count(str(number)) >= len(step.edges) + 1
        assert step.text.split()[0] in " ".join(texts)


@_each
def test_the_chart_is_the_same_on_matiec(name: str) -> None:
    if find_matiec() is None or find_c_compiler() is None:
        pytest.skip("matiec not found: set RCX_MATIEC or PATH")
    chart = run_process(processes()[name], engine="matiec")
    assert process_svg(chart) == (FOLDER / f"{name}.svg").read_text(encoding="utf-8")


@_each
def test_the_program_of_a_chart_is_portable(name: str) -> None:
    library = sorted((docs.ROOT / "plc/lib").rglob("*.st"))
    assert not lint([processes()[name].program], (), library, binding=True)


def test_every_file_of_the_folder_belongs_to_a_process() -> None:
    names = {file.stem for file in FOLDER.iterdir() if file.name != "processes.toml"}
    assert names == set(processes())
    for name in names:
        assert {file.suffix for file in FOLDER.glob(f"{name}.*")} == {".st", ".toml", ".svg"}


def test_the_times_in_a_picture_are_those_of_the_run() -> None:
    """The times in the picture are those of the run, here calculated by hand.

    The answer comes 50 ms after the edge, delayed by two packets and two scans. SI(01) is written
    at 700 ms, sent at 710 ms, and taken by the cycle at 715 ms. SO(02) is set at
    765 ms, and sent and read at 770 ms. SI(01) turns OFF 100 ms + 20 ms after its own change.
    """
    chart = process_chart("servo_on")
    assert [step.t_us for step in chart.steps] == [700_000, 770_000, 820_000]
    assert [step.at for step in chart.steps] == ["0", "70", "120"]
    assert [step.since_last for step in chart.steps] == ["", "+70", "+50"]
    assert [step.change for step in chart.steps] == ["SI(01) ON", "SO(02) ON", "SI(01) OFF"]


def test_a_step_whose_edges_come_apart_shows_both_times() -> None:
    process = processes()["servo_on"]
    both = Step((("SO02", 1), ("SI01", 0)), "both")
    chart = run_process(replace(process, steps=(process.steps[0], both)), engine="builtin")
    assert chart.steps[1].at == "70 to 120"
    assert chart.steps[1].since_last == "+120"


def test_a_step_that_does_not_happen_is_refused() -> None:
    process = processes()["servo_on"]
    wrong = replace(process, steps=(*process.steps, Step((("SO02", 0),), "servos off")))
    with pytest.raises(InputError, match="step 4: no change of SO02 to 0"):
        run_process(wrong, engine="builtin")


def test_steps_in_another_order_are_refused() -> None:
    process = processes()["servo_on"]
    with pytest.raises(InputError, match="step 2: no change of SO02 to 1"):
        run_process(replace(process, steps=process.steps[::-1]), engine="builtin")


def test_a_dedicated_input_that_the_chart_hides_is_refused() -> None:
    process = processes()["servo_on"]
    lanes = tuple(lane for lane in process.lanes if lane[0] != "SI06")
    with pytest.raises(InputError, match="SI06 changes at 540000 us and is not shown"):
        run_process(replace(process, lanes=lanes), engine="builtin")


def test_a_run_with_a_violation_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rcx_tools.docs.processes.FOLDER", tmp_path)
    process = processes()["servo_on"]
    source = (docs.ROOT / "docs/explanation/charts/servo_on.st").read_text(encoding="utf-8")
    reserved = "  OutputArea[46] := BYTE#16#01;\nEND_PROGRAM"
    (tmp_path / "servo_on.st").write_text(source.replace("END_PROGRAM", reserved), encoding="utf-8")
    stimulus = (docs.ROOT / "docs/explanation/charts/servo_on.toml").read_text(encoding="utf-8")
    (tmp_path / "servo_on.toml").write_text(stimulus, encoding="utf-8")
    with pytest.raises(InputError, match="reserved"):
        run_process(process, engine="builtin")


def test_a_lane_that_is_no_signal_is_refused() -> None:
    process = replace(processes()["servo_on"], lanes=(("SI99", None),))
    with pytest.raises(InputError, match="no signal is called 'SI99'"):
        run_process(process, engine="builtin")


def test_a_lane_knows_its_value_at_any_time() -> None:
    lane = Lane("x", "event", [(-1, 1), (10, 0)])
    assert [lane.value_at(t) for t in (0, 9, 10)] == [1, 1, 0]
