"""`rcx export TARGET --prefix` adds the prefix to all names of the library, for every target."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from example_runs import EXAMPLES
from exported import example_sources, recorded, shapes, trace_of
from mistakes import check
from plc_bench import ROOT
from rcx_harness.cell.exports import export, sources_of
from rcx_harness.cli.app import main
from structured_text.engines.load import build
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.export import TARGETS
from structured_text.export.output import write
from structured_text.export.parts import Sources

LIB = sorted((ROOT / "plc/lib").rglob("*.st"))
Captured = pytest.CaptureFixture[str]

_TEXT = re.compile(r"'(?:\$.|[^$'\n])*'|&apos;.*?&apos;")
_MARK = re.compile(r"\{?[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}\}?")
_DATE = re.compile(r"\d{4}-\d\d-\d\dT[\d:.]+Z?")
_PATH = re.compile(r"(?:tests|docs|spec|plc)/[\w/.]+")
_WORD = re.compile(r"[A-Za-z_]\w*")

_OWN = """
TYPE
  MINE : (HAND_RIGHT, MINE_OTHER);
END_TYPE
TYPE
  RECORDS : STRUCT UNIT_MM : INT; FB_RcxJob : BOOL; END_STRUCT;
END_TYPE
FUNCTION_BLOCK FB_Status (* FB_Status is mine, FB_ServoOn and fb_servoon are theirs *)
  VAR_INPUT
    FC_RcxWord : INT;
  END_VAR
  VAR_OUTPUT
    Sum : INT;
  END_VAR
  Sum := FC_RcxWord + 1; (* docs/reference/blocks/FB_ServoOn.md *)
END_FUNCTION_BLOCK
PROGRAM Main
  VAR
    Status   : FB_Status;
    Servo    : fb_servoon;
    Robot    : RCX_REF;
    Area     : RCX_IMAGE;
    Kind     : MINE := HAND_RIGHT;
    Hand     : RCX_HAND_SYSTEM := RCX_HAND_SYSTEM#HAND_LEFT;
    Own      : RECORDS := (UNIT_MM := 3);
    Unit     : RCX_UNIT;
    Text     : STRING := 'FB_ServoOn';
    Read     : FB_ReadPoint;
    Code     : INT;
  END_VAR
  Status(FC_RcxWord := Own.UNIT_MM);
  Own.FB_RcxJob := Status.Sum > 3;
  Servo(Robot := Robot, Execute := Own.FB_RcxJob);
  Read(Robot := Robot);
  Unit := UNIT_MM;
  CASE Unit OF
    UNIT_PULSES: Kind := MINE_OTHER;
    UNIT_MM: Kind := MINE#HAND_RIGHT;
  END_CASE;
  Code := WORD_TO_INT(FC_RcxCharCode(Text := Text, Position := 1));
END_PROGRAM
"""


@cache
def _names() -> set[str]:
    """Return the names of all types, blocks, functions and enumeration values of the library."""
    found = {file.stem for file in LIB}
    for file in LIB:
        code = re.sub(r"\(\*.*?\*\)", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
        members = re.search(r"TYPE\s+\w+ : \(([^)]*)\);", code)
        found |= set(_WORD.findall(members[1])) if members else set()
    return found


@cache
def _renamed(prefix: str) -> Sources:
    """Return the first example and its parts of the library with the prefix."""
    return sources_of(program=[EXAMPLES[0].folder], only_needed=True, prefix=prefix)


def _new(word: str, prefix: str) -> str:
    """Return the name with the prefix if it is a name of the library.

    The test has its own implementation of the rules.
    """
    if word.startswith("Zero_"):  # in Logix, a tag of zeros, which COP copies
        return f"Zero_{_new(word[5:], prefix)}"
    if word not in _names() or word.startswith(prefix):
        return word
    return f"{prefix}{prefix}{word}" if f"{prefix}{word}" in _names() else f"{prefix}{word}"


def _words(files: dict[str, str], prefix: str = "") -> Counter[str]:
    """Count the words in all files and file names, without texts, paths, identifiers and dates.

    Two kinds of names are shortened. An instance that the export creates ends with a number. In
    Logix, a hidden member of a structure contains a part of the structure's name.
    """
    every = [*files]
    for text in files.values():
        for pattern in (_TEXT, _MARK, _DATE, _PATH):
            text = pattern.sub("", text)
        every.append(text)
    found = (word for text in every for word in _WORD.findall(text))
    words = (re.sub(r"_\d+$|(?<=^ZZZZZZZZZZ).*", "", word) for word in found)
    return Counter(_new(word, prefix) if prefix else word for word in words)


@pytest.mark.exhaustive(but=["plcopen-Yam_", "twincat-Yam_", "l5x-Yam_"])
@pytest.mark.parametrize("prefix", ["RCX_", "Yam_"])
@pytest.mark.parametrize("target", TARGETS)
def test_only_names_of_the_library_get_the_prefix(target: str, prefix: str) -> None:
    """The prefix is added in the library, the user's program, file names, tables and steps."""
    plain = TARGETS[target].write(example_sources(EXAMPLES[0].name))
    renamed = TARGETS[target].write(_renamed(prefix))
    before, after = _words(dict(plain.files), prefix), _words(dict(renamed.files))
    assert after - before == Counter()
    assert before - after == Counter()
    assert f"{prefix}FB_ServoOn" in after
    assert len(renamed.missing) == len(plain.missing)


@pytest.mark.exhaustive(but=["st-RCX_"])
@pytest.mark.parametrize("prefix", ["RCX_", "Yam_"])
@pytest.mark.parametrize("target", ["st", "plcopen", "l5x"])
def test_a_renamed_example_has_the_same_trace(target: str, prefix: str, tmp_path: Path) -> None:
    """An example whose library has a prefix is exported, read back, and gives the same trace."""
    example = EXAMPLES[0]
    name = {"st": "one.st", "plcopen": "one.xml", "l5x": "one.L5X"}[target]
    files = write(TARGETS[target].write(_renamed(prefix)), tmp_path / name)
    assert f"{prefix}FB_ServoOn" in files[0].read_text(encoding="utf-8")
    task = [example.folder / "Config.st"] if target == "l5x" else []
    assert trace_of(example, [*files, *task], tmp_path) == recorded(example)


@pytest.mark.exhaustive
def test_the_whole_library_has_no_errors_with_a_prefix(tmp_path: Path) -> None:
    (file,) = write(export("st", prefix="Yam_"), tmp_path / "one.st")
    assert check([file]) == []
    assert len(shapes([file])) == len(LIB)
    assert all(name.startswith("Yam_") for name in shapes([file]))


def test_matiec_compiles_the_library_with_a_prefix(tmp_path: Path) -> None:
    if find_matiec() is None or find_c_compiler() is None:
        pytest.skip("matiec not found: set RCX_MATIEC or PATH")
    program = [EXAMPLES[0].folder]
    (file,) = write(export("st", program=program, prefix="RCX_"), tmp_path / "one.st")
    build([file], "matiec").program.close()


def test_names_that_the_user_declares_get_no_prefix(tmp_path: Path) -> None:
    """Names that the user declares get no prefix, even if the library has the same names."""
    source = tmp_path / "Mine.st"
    source.write_text(_OWN)
    output = export("st", program=[source], only_needed=True, prefix="Yam_")
    (file,) = write(output, tmp_path / "one.st")
    text = file.read_text()
    mine = text[text.index("FUNCTION_BLOCK FB_Status") : text.index("END_PROGRAM")]
    assert "(* FB_Status is mine, Yam_FB_ServoOn and fb_servoon are theirs *)" in mine
    assert "docs/reference/blocks/FB_ServoOn.md" in mine
    assert "Servo    : Yam_fb_servoon;" in mine
    assert "Kind     : MINE := HAND_RIGHT;" in mine
    assert "Hand     : Yam_RCX_HAND_SYSTEM := Yam_RCX_HAND_SYSTEM#Yam_HAND_LEFT;" in mine
    assert "Own      : RECORDS := (UNIT_MM := 3);" in mine
    assert "Text     : STRING := 'FB_ServoOn';" in mine
    assert "Status(FC_RcxWord := Own.UNIT_MM);" in mine
    assert "Unit := Yam_UNIT_MM;" in mine
    assert "Yam_UNIT_MM: Kind := MINE#HAND_RIGHT;" in mine
    assert "Yam_FC_RcxCharCode(Text := Text, Position := 1)" in mine
    program = build([file], "builtin").program
    program.scan(0)
    assert program.read("Main.Status.Sum") == 4
    assert program.read("Main.Own.FB_RcxJob") is True


def test_a_literal_of_a_type_with_the_prefix_is_renamed_right(tmp_path: Path) -> None:
    """With the prefix RCX_, RCX_UNIT#UNIT_MM becomes RCX_UNIT#RCX_UNIT_MM."""
    source = tmp_path / "Mine.st"
    source.write_text(
        "PROGRAM Main\n  VAR\n    Unit : RCX_UNIT;\n  END_VAR\n"
        "  Unit := RCX_UNIT#UNIT_MM;\nEND_PROGRAM\n"
    )
    output = export("st", program=[source], only_needed=True, prefix="RCX_")
    assert "Unit := RCX_UNIT#RCX_UNIT_MM;" in output.files[""]
    assert "RCX_RCX_" not in output.files[""]


@pytest.mark.exhaustive(but=["", "A__", "_A", "A.B"])
@pytest.mark.parametrize("prefix", ["", "1A_", "A__", "A B", "_A", "Ä_", "A-", "A.B"])
def test_a_wrong_prefix_is_refused(prefix: str, tmp_path: Path, capsys: Captured) -> None:
    assert main(["export", "st", "--prefix", prefix, "-o", str(tmp_path / "x.st")]) == 2
    assert capsys.readouterr().err == (
        f"rcx: --prefix {prefix!r} cannot begin a name; "
        "use a letter, then letters, digits and single underscores, such as RCX_\n"
    )
    assert not (tmp_path / "x.st").exists()


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (3, "PROGRAM Main\n  VAR\n    rcx_fb_servoon : INT;\n  END_VAR\n  rcx_fb_servoon := 1;\n"),
        (2, "PROGRAM Main\n  VAR X : RCX_FB_SERVOON; END_VAR\n  X();\n"),
    ],
)
def test_a_new_name_that_exists_is_reported_with_its_place(
    line: int, code: str, tmp_path: Path, capsys: Captured
) -> None:
    source = tmp_path / "Mine.st"
    source.write_text(f"{code}END_PROGRAM\n")
    arguments = ["--prefix", "RCX_", "--program", str(source), "-o", str(tmp_path / "x.st")]
    assert main(["export", "st", *arguments]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"rcx: {source}:{line}: ")
    assert (
        "already exists, and --prefix RCX_ makes the same name from FB_ServoOn of the library"
        in told
    )
    assert told.endswith("; use another prefix\n")
    assert told.count("\n") == 1
