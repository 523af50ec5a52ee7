"""The pages of the blocks are up to date, and their examples end as the pages say."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from rcx_harness import spec
from rcx_tools.docs import blocks as docs_blocks
from rcx_tools.docs import pages as docs
from rcx_tools.docs.blocks import examples, ranges
from rcx_tools.docs.blocks.panel import panel_page
from rcx_tools.docs.blocks.runs import run_of, run_snippet
from rcx_tools.docs.blocks.source import ROOT, pous
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.portability import lint
from structured_text.output.toml_files import load_toml

_BLOCKS = [name for name, pou in pous().items() if not pou.is_function]
_LINK = re.compile(r"\]\(([^)#:]+)[^)]*\)")


def _page(name: str) -> str:
    return (ROOT / f"docs/reference/blocks/{name}.md").read_text(encoding="utf-8")


def _rows(page: str, heading: str) -> list[list[str]]:
    """Return the rows of the table below this heading, without the header row."""
    part = re.split(r"^##+ ", page.partition(f"## {heading}\n")[2], flags=re.MULTILINE)[0]
    lines = [line for line in part.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[1:]]


def _errors(name: str) -> list[str]:
    return [row[0].strip("`") for row in _rows(_page(name), "Errors")]


@pytest.mark.exhaustive(but=["FB_ReadArea", "FB_ServoOn", "FB_MovePtp"])
@pytest.mark.parametrize("name", _BLOCKS)
def test_the_files_of_a_block_are_up_to_date_and_its_example_ends_as_they_say(name: str) -> None:
    """The generated files of a block are up to date.

    Its example is run again. An example that fails or breaks a rule is an error.
    """
    for path, render in docs_blocks.files_of(name).items():
        assert (ROOT / path).read_bytes() == render().encode(), f"{path}: run `make docs`"
    page = _page(name)
    for target in _LINK.findall(page):
        assert (ROOT / "docs/reference/blocks" / target).exists(), target


def test_the_page_of_the_functions_is_current_and_its_links_lead_somewhere() -> None:
    page = docs_blocks.files()["docs/reference/blocks/functions.md"]()
    assert (ROOT / "docs/reference/blocks/functions.md").read_text(encoding="utf-8") == page
    for target in _LINK.findall(page):
        assert (ROOT / "docs/reference/blocks" / target).exists(), target


def test_every_block_that_users_call_has_an_example() -> None:
    """Every block that users call has an example in snippets.toml, or a reason under [without]."""
    called = {name for name in _BLOCKS if not pous()[name].internal}
    assert called - examples.snippets().keys() == examples.without().keys()
    assert not examples.snippets().keys() - called


def test_nothing_generated_is_left_over_from_blocks_that_have_gone(tmp_path: Path) -> None:
    assert docs_blocks.leftovers() == []
    folder = tmp_path / "docs/reference/blocks"
    folder.mkdir(parents=True)
    (folder / "FB_Gone.md").write_text(_page("FB_ServoOn"), encoding="utf-8")
    (folder / "FB_ServoOn.md").write_text(_page("FB_ServoOn"), encoding="utf-8")
    (folder / "notes.md").write_text("# My notes\n", encoding="utf-8")
    assert docs_blocks.leftovers(tmp_path) == ["docs/reference/blocks/FB_Gone.md"]


def test_the_page_of_a_block_that_has_gone_is_reported_and_then_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(docs, "ROOT", tmp_path)
    monkeypatch.setattr(docs, "every_page", dict)
    gone, own = (
        tmp_path / "docs/reference/blocks/FB_Gone.md",
        tmp_path / "docs/reference/blocks/notes.md",
    )
    gone.parent.mkdir(parents=True)
    gone.write_text(_page("FB_ServoOn"), encoding="utf-8")
    own.write_text("# My notes\n", encoding="utf-8")
    assert docs.main(["--check"]) == 1
    assert "not current: docs/reference/blocks/FB_Gone.md" in capsys.readouterr().err
    assert gone.exists()
    assert docs.main([]) == 0
    assert not gone.exists()
    assert own.exists()


def test_every_page_is_two_clicks_from_the_readme_and_an_internal_block_three() -> None:
    reference = ROOT / "docs/reference"
    index = (reference / "blocks.md").read_text(encoding="utf-8")
    assert "(internal-blocks.md)" in index
    index += (reference / "internal-blocks.md").read_text(encoding="utf-8")
    assert "(docs/reference/blocks.md)" in (ROOT / "README.md").read_text(encoding="utf-8")
    for name in _BLOCKS:
        assert f"[{name}](blocks/{name}.md)" in index
        page = _page(name)
        assert f"/{pous()[name].file.relative_to(ROOT).as_posix()})" in page
        assert all(f"({Path('../../..', test).as_posix()})" in page for test in pous()[name].tests)


def test_the_programs_keep_the_portability_rules() -> None:
    programs = [one.path for one in examples.snippets().values()]
    library = sorted((ROOT / "plc/lib").rglob("*.st"))
    assert [str(one) for one in lint(programs, context=library, binding=True)] == []


@pytest.mark.skipif(
    find_matiec() is None or find_c_compiler() is None, reason="matiec or a C compiler is missing"
)
@pytest.mark.parametrize("name", ["FB_ReadPoint", "FB_ServoOnFromEmergencyStop"])
def test_matiec_shows_the_same_chart_and_outputs(name: str) -> None:
    other = run_snippet(examples.snippets()[name], engine="matiec")
    assert (other.lanes, other.outputs) == (run_of(name).lanes, run_of(name).outputs)


def test_the_chart_of_pick_and_place_shows_stage_hand_and_motion() -> None:
    """The chart of FB_PickPlace shows stages, hand and movements.

    The hand closes between the stages to the source and to the target, and opens at the end.
    """
    chart = (ROOT / "docs/reference/blocks/charts/FB_PickPlace.svg").read_text(encoding="utf-8")
    for lane in ("Stage", "DO(20) hand closed", "Axis 1 [pulse]"):
        assert f">{lane}</text>" in chart
    stages = re.findall(r'<text class="b"[^>]*>([^<]+)<', chart)
    assert [one for one in stages if one.startswith("to ")] == ["to source", "to target"]


def test_the_ladder_of_a_block_has_the_statements_that_its_page_shows() -> None:
    """FB_ServoOn has a contact Start at Execute; FB_ReadArea and FB_WriteArea are left out."""
    drawn = (ROOT / "docs/reference/blocks/ladders/FB_ServoOn.svg").read_text(encoding="utf-8")
    assert "![The example as ladder, one network](ladders/FB_ServoOn.svg)" in _page("FB_ServoOn")
    assert sorted(re.findall(r"<text[^>]*>([^<]+)</text>", drawn)) == [
        *("Active", "Busy", "Done", "Error", "ErrorID", "Execute", "FB_ServoOn"),
        *("Robot", "Robot", "ServoOn", "Start", "Timeout"),
    ]
    both = (ROOT / "docs/reference/blocks/ladders/FB_PickPlace.svg").read_text(encoding="utf-8")
    assert re.findall(r"Network \d</text>", both) == ["Network 1</text>", "Network 2</text>"]
    assert "2 networks](ladders/FB_PickPlace.svg)" in _page("FB_PickPlace")


def test_a_movement_has_its_pins_with_unit_range_and_default() -> None:
    """Source: remote command guide 4.2.1, PTP designation."""
    page = _page("FB_MovePtp")
    rows = {row[0].strip("`"): row[2:5] for row in _rows(page, "Inputs")}
    assert rows["Point"] == ["`0`", "", "0 to 29999"]
    assert rows["Speed"][1:] == [
        "%, mm/s",
        "0.01 to 100 with `SPEED_DIRECT`; 1 to 100 with `SPEED_PERCENT`",
    ]
    assert rows["SpeedMode"][2] == "`SPEED_PROGRAM`, `SPEED_DIRECT`, `SPEED_PERCENT`"
    assert rows["Acceleration"] == ["`0`", "%", "0 (not given), 1 to 100"]
    assert rows["Axes"] == ["`16#0000`", "", "bits 0 to 5"]
    assert rows["Timeout"][0] == "`T#60s`"


@pytest.mark.parametrize(
    ("block", "pin", "expected"),
    [
        ("FB_MoveLinear", "Speed", "1 to 1000 with `SPEED_MM_S`"),
        ("FB_WriteIoPort", "PortNumber", "2 to 7, 10 to 17, 20 to 27 with `PORT_DO`"),
        ("FB_SetInchingAmount", "Amount", "1 to 10000"),
        ("FB_PushPoint", "PushForce", "-1000 to 1000"),
        ("FB_ReadVariable", "Variable", "0 to 31, 256 to 287"),
        ("FB_WritePallet", "FirstPoint", "0 to 29995"),
        ("FB_ReadWord", "Number", "2..15, with Size 256 also 24..127"),
        ("FB_ReadArea", "Size", "48, 256"),
    ],
)
def test_a_range_of_a_pin_agrees_with_the_manual(block: str, pin: str, expected: str) -> None:
    """Source: remote command guide 4.2.1, 4.2.8, 4.2.23, 4.3.3, 4.4.1, 4.5.1; chapter 1, 4."""
    found = pous()[block].pin(pin)
    assert found is not None
    assert expected in ranges.range_of(pous()[block], found)


def test_a_page_lists_the_errors_that_its_block_can_give_and_no_others() -> None:
    """Source: what the blocks check, plc/lib; spec/errors.toml."""
    servo = ["16#8001", "16#8002", "16#8003", "16#8004", "16#8005", "16#8010", "16#8012"]
    assert _errors("FB_ServoOn") == [*servo, "16#8013", "16#8016", "16#8017"]
    assert _errors("FB_ReadBit") == ["16#8001", "16#8030", "16#8031", "16#8033"]
    assert _errors("FB_ReadBitInWords") == ["16#8001", "16#8030", "16#8031", "16#8032", "16#8033"]
    assert "16#8035" in _errors("FB_ReadDoubleWord")
    assert "16#8035" not in _errors("FB_ReadWord")
    remote = [
        *("16#8001", "16#8002", "16#8011", "16#8012", "16#8013", "16#8014", "16#8015", "16#8016"),
        *("16#8017", "16#8020"),
    ]
    assert _errors("FB_ReadPoint") == [*remote, "16#8044"]
    assert _errors("FB_EmergencyStop") == [
        *("16#8001", "16#8002", "16#8010", "16#8013", "16#8016", "16#8017"),
    ]
    assert _errors("FB_ReadArea") == ["16#8030", "16#8031", "16#8037"]
    assert all(row[2] and row[3] for row in _rows(_page("FB_ServoOn"), "Errors"))


def test_the_values_that_a_block_reads_are_shown() -> None:
    """Source: remote command guide 4.3.1, 4.3.2 and 4.7.7, examples."""
    point = dict(_rows_of_run("FB_ReadPoint"))
    assert point["PointRead"] == "50"
    assert point["Unit"] == "UNIT_MM"
    assert point["PositionMm"] == "10, -20, 5, -18, 0, 0"
    assert dict(_rows_of_run("FB_ReadPointComment"))["Comment"] == "'WAIT ORG'"
    message = dict(_rows_of_run("FB_ReadMessage"))
    assert (message["MessageGroup"], message["MessageCategory"]) == ("16#0002", "16#014E")


def _rows_of_run(name: str) -> list[tuple[str, str]]:
    page = _page(name).partition("### Result\n")[2]
    return [(a, b) for a, b in re.findall(r"^\| `(\w+)` \| `(.*)` \|$", page, re.MULTILINE)]


def test_the_chart_shows_the_handshake_of_the_example() -> None:
    """The chart shows the handshake of the example.

    Data come first, and the code one scan later. Then the status is 0x0100 and 0x0200. At the end
    all words return to 0.

    Source: remote command guide, chapters 1 and 2; 4.3.1, point data reference
    """
    lanes = {
        lane.name: [value for _, value in lane.changes] for lane in run_of("FB_ReadPoint").lanes
    }
    starts = {lane.name: lane.changes[0][0] for lane in run_of("FB_ReadPoint").lanes}
    assert lanes["n + 0: command code"] == [0x0101, 0]
    assert lanes["n + 4: point"] == [50, 0]
    assert starts["n + 4: point"] == starts["n + 0: command code"] - 10_000 == 0
    assert lanes["m + 0: status"] == [0x0100, 0x0200, 0]
    assert lanes["Execute"] == lanes["Done"] == [1]
    assert lanes["Busy"] == [1, 0]


def test_the_snippet_of_a_page_stands_in_the_program_that_was_run() -> None:
    for name, snippet in examples.snippets().items():
        shown = re.search(r"```iecst\n(.*?)```", _page(name), re.DOTALL)
        assert shown, name
        body = shown[1].partition("END_VAR\n\n")[2] or shown[1]
        program = snippet.path.read_text(encoding="utf-8")
        for line in body.splitlines():
            assert f"  {line}".rstrip() in program.splitlines(), f"{name}: {line}"
        assert f"{name.removeprefix('FB_')}(" in body


def test_an_example_that_ends_in_an_error_is_reported_with_its_error_id() -> None:
    """An example that ends in an error is reported with its ErrorID. The last point is 29999.

    Source: remote command guide 4.3.1.
    """
    snippet = examples.snippets()["FB_ReadPoint"]
    assert snippet.call
    wrong = replace(snippet, call=replace(snippet.call, inputs={"Point": 30000}))
    with pytest.raises(InputError, match=r"FB_ReadPoint: .* ErrorID 16#8044"):
        run_snippet(wrong)


def test_an_example_with_an_input_that_is_not_there_is_told() -> None:
    snippet = examples.snippets()["FB_ReadPoint"]
    assert snippet.call
    wrong = replace(snippet, call=replace(snippet.call, inputs={"Pont": 1}))
    with pytest.raises(InputError, match="FB_ReadPoint has no input Pont"):
        run_snippet(wrong)


def test_an_example_of_a_block_that_is_not_there_is_told(tmp_path: Path) -> None:
    file = tmp_path / "snippets.toml"
    file.write_text('[before]\n[[block]]\nname = "FB_Nothing"\n', encoding="utf-8")
    with pytest.raises(InputError, match="there is no block 'FB_Nothing'"):
        examples.snippets(file)


def test_the_sheet_for_the_panel_has_every_signal_code_error_and_alarm() -> None:
    """Source: manual chapter 5, 2 and 4.4; remote command guide 4.1."""
    sheet = panel_page()
    table = spec.signals()
    for signal in (*table.output, *table.input):
        assert f"<td>{signal.signal}</td><td>({signal.address}).{signal.bit}</td>" in sheet
    codes = re.findall(r"<div><code>([0-9A-FR]{4})</code>", sheet)
    assert len(codes) == len(set(codes)) == len(spec.commands()) == 117
    assert "<code>R034</code><span>FB_Servo: ServoOn</span>" in sheet
    for error in load_toml(spec.folder() / "errors.toml")["error"]:
        assert f"<code>16#{error['id']:04X}</code></td><td>{error['name']}</td>" in sheet
    for number in spec.alarms():
        assert f"<td>{number}</td>" in sheet
    assert "@page { size: A4 portrait;" in sheet


def test_everything_that_is_generated_is_written_by_one_command() -> None:
    every = docs.every_page()
    assert every.keys() >= docs.pages().keys() | docs_blocks.files().keys()
    assert not docs.pages().keys() & docs_blocks.files().keys()


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("FB_WritePort", "FB_WriteIoPort"),
        ("FB_ReturnToOrigin", "FB_ReturnToOriginRobot"),
        ("FB_ServoOn", "FB_Servo"),
        ("FB_ServoOn", "FB_ServoOnFromEmergencyStop"),
    ],
)
def test_blocks_that_are_easily_confused_lead_to_each_other(name: str, other: str) -> None:
    for page, link in ((name, other), (other, name)):
        choice = _page(page).partition("## When to use it")[2].partition("\n## ")[0]
        assert f"[{link}]({link}.md)" in choice


def test_a_page_names_the_document_of_its_section_and_the_command_that_runs_its_tests() -> None:
    """Source: remote command guide 4.2.1."""
    page = _page("FB_MovePtp")
    assert "| Manual | Remote command guide 4.2.1, MOVE, PTP" in page
    assert "| Run them | `.venv/bin/python -m pytest tests/command/" in page
