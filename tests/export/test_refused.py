"""`rcx check --for TOOL` lists the constructs of a program that this tool will refuse."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from matiec_habits import HABITS, iec2c_takes
from rcx_harness.cli.app import main
from rcx_harness.cli.refused_text import grouped
from structured_text.engines.matiec.build import find_matiec
from structured_text.errors import NO_COLUMN
from structured_text.export.refused import CONSTRUCTS_FILE, Refusal, tools
from structured_text.export.targets import TARGETS
from structured_text.language.constructs import CONSTRUCTS, Use
from structured_text.language.source import Line, NetworkLine
from structured_text.language.syntax import Position
from structured_text.output.toml_files import load_toml

Captured = pytest.CaptureFixture[str]
_TOOLS = (
    *("codesys", "twincat", "siemens", "rockwell", "omron", "mitsubishi", "keyence", "matiec"),
)

#: A program with a // comment in lines 3 and 8, a pointer in line 4, a conversion in line 9, and a
#: bit without `;` in line 10.
_HABITS = """\
PROGRAM P1
VAR
  I : INT; // counter
  P : POINTER TO INT;
  D : DINT;
  C : CTU;
END_VAR
/* block */
D := I;
IF I.3 THEN I := 1; END_IF
C(CU := TRUE, PV := 3);
END_PROGRAM
"""
_PLAIN = "PROGRAM P1\nVAR\n  I : INT;\nEND_VAR\nI := I + 1;\nEND_PROGRAM\n"


def _check(tool: str, file: Path) -> int:
    return main(["check", str(file), "--for", tool])


def _found(tool: str, file: Path, capsys: Captured) -> list[tuple[int, bool, str]]:
    """Return each place: line, whether the refusal is certain, and text."""
    capsys.readouterr()
    main(["check", str(file), "--for", tool, "--json"])
    found = json.loads(capsys.readouterr().out)["findings"]
    assert {one["file"] for one in found} <= {str(file)}
    return [(one["line"], one["rule"] == "refused", one["text"]) for one in found]


@pytest.fixture
def habits(tmp_path: Path) -> Path:
    file = tmp_path / "habits.st"
    file.write_text(_HABITS)
    return file


@pytest.mark.parametrize(
    ("tool", "expected"),
    [
        ("codesys", [(8, False, "(/* */)")]),
        ("twincat", [(6, False, "CTU is not on the list"), (8, False, "(/* */)")]),
        ("rockwell", [(4, True, "POINTER TO"), (6, False, "CTU is not on the list"),
                      (9, False, "an implicit conversion"), (10, False, "a bit by its number"),
                      (11, False, "no ; after END")]),
        ("siemens", [(4, False, "POINTER TO"), (8, False, "(/* */)"),
                     (9, False, "an implicit conversion"), (10, False, "a bit by its number"),
                     (11, False, "no ; after END")]),
        ("matiec", [(3, True, "a comment with //"), (4, True, "POINTER TO"), (8, True, "(/* */)"),
                    (9, True, "an implicit conversion"), (10, True, "a bit by its number"),
                    (11, True, "no ; after END")]),
    ],
)  # fmt: skip
def test_every_finding_has_its_line_and_a_remedy(
    habits: Path, capsys: Captured, tool: str, expected: list[tuple[int, bool, str]]
) -> None:
    assert _check(tool, habits) == any(certain for _, certain, _ in expected)
    found = _found(tool, habits, capsys)
    assert [one[:2] for one in found] == [one[:2] for one in expected]
    for (*_, text), (*_, part) in zip(found, expected, strict=True):
        assert part in text
        assert "; " in text, "the message does not name a replacement"


@pytest.mark.parametrize("tool", _TOOLS)
def test_every_tool_takes_a_portable_program(tmp_path: Path, capsys: Captured, tool: str) -> None:
    file = tmp_path / "plain.st"
    file.write_text(_PLAIN)
    assert _check(tool, file) == 0
    assert "nothing refused, nothing that may be refused" in capsys.readouterr().out


def test_a_part_that_is_not_carried_is_refused(
    repository: Path, tmp_path: Path, capsys: Captured
) -> None:
    """BYTE is refused by GX Works3, and a CONFIGURATION by TwinCAT."""
    program = repository / "plc/examples/01_power_up"
    assert _check("mitsubishi", program) == 1
    out = capsys.readouterr().out
    assert "refused in 1 place: PROGRAM: has an array of BYTE" in out
    assert "PowerUp.st:3:1: PowerUp\n" in out
    assert "note: declarations are label tables there" in out
    assert _check("twincat", program) == 1
    assert "refused in 1 place: CONFIGURATION: TASK Cyclic (line 4)" in capsys.readouterr().out
    assert _check("codesys", program) == 0


def test_a_reserved_word_may_be_refused_but_not_by_matiec(tmp_path: Path, capsys: Captured) -> None:
    file = tmp_path / "word.st"
    file.write_text("PROGRAM P1\nVAR\n  Overlap : INT;\nEND_VAR\nOverlap := 1;\nEND_PROGRAM\n")
    assert _check("omron", file) == 0
    assert _found("omron", file, capsys)[0][:2] == (3, False)
    assert _check("matiec", file) == 0


@pytest.mark.parametrize(
    ("file", "tool", "other"), [("cell.L5X", "rockwell", "omron"), ("cell.scl", "siemens", "omron")]
)
def test_a_tool_takes_its_own_files(
    repository: Path, capsys: Captured, file: str, tool: str, other: str
) -> None:
    path = repository / "tests" / "engine" / "projects" / "data" / file
    assert _check(tool, path) == 0
    assert "nothing refused, nothing that may be refused" in capsys.readouterr().out
    assert _check(other, path) == 0
    assert "may be refused in " in capsys.readouterr().out


def test_labels_of_enumerations_are_accepted_by_codesys(tmp_path: Path, capsys: Captured) -> None:
    """CODESYS accepts STATE.IDLE and constants as labels of CASE.

    Other tools accept only the enumeration value without its type, or a number.

    Source: CODESYS help, CASE (_cds_st_instruction_case.html); design, section 4
    """
    file = tmp_path / "labels.st"
    file.write_text(
        "TYPE STATE : (IDLE, RUN); END_TYPE\nPROGRAM P1\nVAR S : STATE; N : INT; END_VAR\n"
        "VAR CONSTANT C : INT := 3; END_VAR\nCASE S OF STATE.IDLE:\nN := 1; END_CASE;\n"
        "CASE N OF C:\nN := 1; RUN:\nN := 2; END_CASE;\nEND_PROGRAM\n"
    )
    assert _check("codesys", file) == 0
    ((line, _, text),) = _found("codesys", file, capsys)
    assert (line, text.partition("; ")[2]) == (
        8,
        "declare the other operand, or the target, as that enumeration",
    )
    assert _check("matiec", file) == 1
    found = _found("matiec", file, capsys)
    said = {line: text.partition("; ")[2] for line, _, text in found}
    assert (said[5], said[7]) == ("write the member alone", "write the number")


def test_places_are_grouped_by_kind_and_certain_kinds_come_first(
    tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A line has six places; a detail has its own line.

    Source: docs/how-to/export.md, what a tool refuses
    """
    monkeypatch.chdir(tmp_path)
    Path("a.st").write_text(
        "PROGRAM P1\nVAR\n  I : INT; P : POINTER TO INT; D : DINT; U : UDINT;\nEND_VAR\n"
        + "D := I;\n" * 8
        + "U := P^;\nEND_PROGRAM\n"
    )
    assert main(["check", "a.st", "--for", "rockwell"]) == 1
    assert capsys.readouterr().out.splitlines()[:5] == [
        "refused in 2 places: POINTER TO; use a VAR_IN_OUT",
        "  a.st:3:16, 13:7",
        "may be refused in 9 places: an implicit conversion; call the conversion",
        "  a.st:5:6, 6:6, 7:6, 8:6, 9:6, 10:6 and 2 more: "
        "a INT where a DINT is expected: write INT_TO_DINT",
        "  a.st:13:6: a INT where a UDINT is expected: write INT_TO_UDINT",
    ]


def test_a_kind_in_many_files_has_six_lines() -> None:
    """Places of different rungs have their own lines, because they have no column in common.

    Source: docs/how-to/export.md, what a tool refuses
    """
    at = Position(2, 3)
    files = [Refusal(Path(f"{name}.st"), at, "", certain=False, kind="k") for name in "abcdefgh"]
    again = replace(files[6], at=Position(4, 1))
    assert grouped([*files, again]) == [
        "may be refused in 9 places: k",
        *(f"  {name}.st:2:3" for name in "abcdef"),
        "  ... and 3 more places: --json lists all",
    ]
    rungs = [NetworkLine(7, "Main", Line("", 7, 0, f"rung {number}")) for number in (1, 2)]
    places = [Position(rungs[number], NO_COLUMN + 1 + number) for number in (0, 1, 1)]
    drawn = [replace(files[0], file=Path("a.xml"), at=one) for one in places]
    assert grouped(drawn)[1:] == ["  a.xml:7: Main, rung 1", "  a.xml:7: Main, rung 2 and 1 more"]


def test_errors_of_the_sources_come_first(tmp_path: Path, capsys: Captured) -> None:
    file = tmp_path / "wrong.st"
    file.write_text("PROGRAM P1\nVAR\n  I : INT;\nEND_VAR\nI := TRUE;\nEND_PROGRAM\n")
    assert _check("codesys", file) == 2
    assert f"error: {file}:5:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--for", "codesis"], "--for codesis: no such tool; use codesys, twincat, siemens"),
        (["--for", "codesys", "--lint"], "--for and --lint exclude each other"),
    ],
)
def test_wrong_options_are_reported_in_one_message(
    habits: Path, capsys: Captured, arguments: list[str], message: str
) -> None:
    assert main(["check", str(habits), *arguments]) == 2
    assert capsys.readouterr().err.startswith(f"rcx: {message}")


def test_the_table_names_known_constructs_tools_and_sources() -> None:
    """Each construct in the table has a source, and none is both accepted and refused."""
    assert tuple(tools()) == _TOOLS
    content = load_toml(CONSTRUCTS_FILE)
    used = set()
    for name in _TOOLS:
        table = content[name]
        for lists in (table.get("takes", {}), table.get("refuses", {})):
            used |= lists.keys()
            for listed in lists.values():
                assert {one.split(" (")[0] for one in listed if one not in CONSTRUCTS} <= set(
                    CONSTRUCTS
                )
        tool = tools()[name]
        assert not tool.takes.keys() & tool.refuses.keys(), name
        assert tool.export in TARGETS
    assert used == content["sources"].keys()


def test_a_construct_without_a_source_is_assumed() -> None:
    """Without a source, the verdict is `None`, which is reported as "may be refused"."""
    at = Position(1, 1)
    keyence = tools()["keyence"]
    assert all(keyence.verdict(Use(name, Path("x.st"), at)) is None for name in CONSTRUCTS)
    verdict = tools()["codesys"].verdict
    comment = "a comment with // or /* */"
    assert verdict(Use(comment, Path("x.st"), at)) is True
    assert verdict(Use(comment, Path("x.st"), at, "/* */")) is None
    assert tools()["rockwell"].verdict(Use(comment, Path("x.st"), at, "/* */")) is True


@pytest.mark.skipif(find_matiec() is None, reason="needs matiec (RCX_MATIEC or PATH)")
def test_matiec_agrees_with_the_table(tmp_path: Path) -> None:
    """The table agrees with matiec itself, which compiles one program for each construct.

    Further constructs are tested in `test_constructs`.
    """
    said = {name: name in tools()["matiec"].takes for name in HABITS}
    assert {name: iec2c_takes(*HABITS[name], tmp_path) for name in HABITS} == said
