"""Works that mix, short time-outs and small margins give a warning; every kind has its section."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness.cell import Cell
from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from rcx_harness.watch.source_warnings import PAGE, SourceWarning, source_warnings

_ROOT = Path(__file__).parents[2]
_HEAD = """\
PROGRAM Cell1
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Safe, A, B, C : BOOL;
    Robot, Other : RCX_REF;
    k : INT;
    Moves : RCX_MOVES;
    Read, ReadOther : FB_ReadArea;
    Write, WriteOther : FB_WriteArea;
    Servo : FB_ServoOn;
    Pick : FB_PickPlace;
    Table : FB_MoveTable;
  END_VAR
  Read(Robot := Robot, Image := InputArea, Connected := Connected);
"""
_FIRST = len(_HEAD.splitlines()) + 1
_WRITE = (
    "Write(Robot := Robot, Image := OutputArea, EmergencyStopOk := Safe, StopOk := Safe, {});\n"
    "END_PROGRAM\n"
)
_PICK = "Pick(Robot := Robot, Execute := {}, SourcePoint := 1, TargetPoint := 2);"
_TABLE = "Table(Robot := Robot, Moves := Moves, Execute := {});"

Found = Callable[..., list[tuple[int, str]]]


def _block(name: str, pins: str, more: str = "") -> str:
    return (
        f"FUNCTION_BLOCK {name}\n  VAR_IN_OUT Robot : RCX_REF; {more} END_VAR\n"
        f"  VAR_INPUT {pins} END_VAR\n  VAR_OUTPUT Done, Busy : BOOL; END_VAR\n"
        "  Done := Robot.Connected;\nEND_FUNCTION_BLOCK\n"
    )


_STUBS = (
    "TYPE RCX_IMAGE : ARRAY [0..47] OF BYTE; END_TYPE\n"
    "TYPE RCX_MOVES : ARRAY [0..1] OF INT; END_TYPE\n"
    "TYPE RCX_REF : STRUCT Connected : BOOL; END_STRUCT; END_TYPE\n"
    + _block("FB_ReadArea", "Connected : BOOL;", "Image : RCX_IMAGE;")
    + _block(
        "FB_WriteArea",
        "Margin : TIME := T#150ms; EmergencyStopOk, StopOk : BOOL;",
        "Image : RCX_IMAGE;",
    )
    + _block("FB_ServoOn", "Execute : BOOL; Timeout : TIME := T#5s;")
    + _block("FB_PickPlace", "Execute : BOOL; RobotNumber, SourcePoint, TargetPoint : INT;")
    + _block("FB_MoveTable", "Execute : BOOL; RobotNumber : INT;", "Moves : RCX_MOVES;")
)


@pytest.fixture
def warned(tmp_path: Path) -> Callable[..., list[SourceWarning]]:
    """Return a function that checks a body of a program with the pins of the library."""
    stubs, program = tmp_path / "stubs.st", tmp_path / "program.st"
    stubs.write_text(_STUBS, encoding="utf-8")

    def found(*body: str, margin: str = "", **times: int) -> list[SourceWarning]:
        write = _WRITE.format(margin).replace(", )", ")")
        program.write_text(_HEAD + "".join(f"{row}\n" for row in body) + write, encoding="utf-8")
        return source_warnings([program], [stubs], **times)

    return found


@pytest.fixture
def found(warned: Callable[..., list[SourceWarning]]) -> Found:
    """Return a function that returns line of the body and kind of each warning."""
    return lambda *body, **given: [
        (one.at.line - _FIRST + 1, one.kind) for one in warned(*body, **given)
    ]


@pytest.mark.parametrize(
    ("pick", "table"),
    [("A", "B"), ("A", "A"), ("A AND B", "C"), ("A AND NOT B", "NOT C"), ("NOT A", "B AND NOT A")],
)
def test_two_works_that_buttons_start_can_mix(found: Found, pick: str, table: str) -> None:
    """No variable excludes that both start (scan-model.md, two blocks on one robot)."""
    body = _PICK.format(pick), _TABLE.format(table)
    assert found(*body) == [(2, "two-works-at-once")]


@pytest.mark.parametrize(
    ("pick", "table"),
    [
        ("A", "NOT A"),
        ("A AND B", "C AND NOT B"),
        ("A", "Pick.Done"),
        ("A AND NOT Table.Busy", "B AND NOT Pick.Busy"),
    ],
)
def test_works_that_exclude_each_other_do_not_mix(found: Found, pick: str, table: str) -> None:
    """A start that depends on an output of a block is not decided by the source."""
    assert found(_PICK.format(pick), _TABLE.format(table)) == []


def test_a_start_that_the_program_computes_is_not_judged(found: Found) -> None:
    """The program may exclude the two starts itself."""
    assert found("A := B AND Connected;", _PICK.format("A"), _TABLE.format("B")) == []


def test_works_of_two_robots_do_not_mix(found: Found) -> None:
    """One controller can have several robots; two controllers have two areas."""
    two = _TABLE.format("B, RobotNumber := 2")
    assert found(_PICK.format("A"), two) == []
    assert found(_PICK.format("A, RobotNumber := 1"), _TABLE.format("B")) != []
    assert found("k := k + 1;", _PICK.format("A, RobotNumber := k"), two) == []
    other = _TABLE.format("B").replace(":= Robot", ":= Other")
    areas = (
        "ReadOther(Robot := Other, Image := InputArea, Connected := Connected);",
        "WriteOther(Robot := Other, Image := OutputArea, EmergencyStopOk := A, StopOk := A);",
    )
    assert found(areas[0], _PICK.format("A"), other, areas[1]) == []


@pytest.mark.parametrize(
    ("time", "rpi_us", "warns"),
    [
        *(("T#9ms", 10_000, True), ("T#10ms", 10_000, False), ("T#0s", 10_000, False)),
        *(("T#99ms", 100_000, True), ("T#9ms", 1_000, False), ("TIME#-1s", 10_000, False)),
    ],
)
def test_a_timeout_below_one_interval_is_too_short(
    found: Found, time: str, rpi_us: int, warns: bool
) -> None:
    """Zero and negative times mean no limit (scan-model.md)."""
    call = f"Servo(Robot := Robot, Execute := A, Timeout := {time});"
    assert found(call, rpi_us=rpi_us) == ([(1, "short-timeout")] if warns else [])


@pytest.mark.parametrize(
    ("margin", "rpi_us", "jitter_us", "warns"),
    [
        ("T#15ms", 10_000, 0, False),
        ("T#14ms", 10_000, 0, True),
        ("T#15ms", 10_000, 1, True),
        ("T#0s", 1_000, 0, True),
        # The default is 150 ms.
        ("", 100_000, 45_000, False),
        ("", 100_000, 45_001, True),
    ],
)
def test_a_margin_covers_interval_jitter_and_a_cycle(
    found: Found, margin: str, rpi_us: int, jitter_us: int, warns: bool
) -> None:
    """Source: scan-model.md: Margin >= RPI + jitter + 5 ms, and the default T#150ms."""
    given = f"Margin := {margin}" if margin else ""
    findings = found(margin=given, rpi_us=rpi_us, jitter_us=jitter_us)
    assert findings == ([(1, "small-margin")] if warns else [])


def test_a_pin_that_is_assigned_elsewhere_is_not_judged(found: Found) -> None:
    """The source does not decide its value."""
    assert found("Write.Margin := T#1ms;", margin="", rpi_us=200_000) == []


def test_the_message_names_the_least_margin(
    warned: Callable[..., list[SourceWarning]],
) -> None:
    """20 ms + 2.5 ms + 5 ms are 27.5 ms."""
    (one,) = warned(margin="Margin := T#20ms", rpi_us=20_000, jitter_us=2_500)
    assert "needs at least 27.5 ms" in one.text
    assert "write Margin := T#28ms or more" in one.text
    assert one.page == f"{PAGE}#small-margin"


def test_each_kind_has_its_section() -> None:
    """The kinds in the code are the headings of the page."""
    kinds: set[str] = set()
    for name in ("calls_source", "first_mistakes", "image_source", "time_pins"):
        code = (_ROOT / f"harness/rcx_harness/watch/{name}.py").read_text(encoding="utf-8")
        kinds |= set(re.findall(r'"([a-z]+(?:-[a-z]+)+)"', code))
    page = (_ROOT / PAGE).read_text(encoding="utf-8")
    headings = re.findall(r"^## (.*)$", page, re.MULTILINE)
    assert {heading.lower().replace(" ", "-") for heading in headings} == kinds


def test_run_prints_the_warnings_once_on_stderr(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The warnings use the interval of the run, and name the section."""
    program = tmp_path / "main.st"
    body = "IF A THEN\n  Servo(Robot := Robot, Execute := B);\nEND_IF;\n"
    program.write_text(_HEAD + body + _WRITE.format("Margin := T#20ms"), encoding="utf-8")
    assert main(["run", str(program), "--for", "20ms", "--rpi", "50ms"]) == 0
    said = capsys.readouterr()
    lines = [line for line in said.err.splitlines() if "warning:" in line]
    assert [re.findall(r"#([a-z-]+)\)$", line) for line in lines] == [
        ["call-under-a-condition"],
        ["small-margin"],
    ]
    assert "warning:" not in said.out


@pytest.mark.exhaustive
def test_examples_and_pages_have_no_first_mistakes() -> None:
    """Neither the examples nor the programs of the pages give a warning."""
    examples = [folder for folder in (_ROOT / "plc/examples").iterdir() if folder.is_dir()]
    found = []
    for program in (*examples, *(_ROOT / "docs").rglob("*.st")):
        found += source_warnings(*source_files(program, None).users)
    assert [str(one) for one in found] == []


@pytest.mark.exhaustive
def test_a_cell_has_the_warnings_for_its_interval(tmp_path: Path) -> None:
    """Pytest reports `mistakes` of a cell in its summary."""
    program = tmp_path / "main.st"
    program.write_text(_HEAD + _WRITE.format("Margin := T#20ms"), encoding="utf-8")
    with Cell.build(program) as cell:
        assert cell.mistakes == ()
    with Cell.build(program, rpi="16ms") as cell:
        (text,) = cell.mistakes
    assert text.startswith(f"{program}:{_FIRST}:1: warning: Margin of Write is 20 ms, but a packet")
    assert text.endswith("(docs/how-to/first-mistakes.md#small-margin)")
