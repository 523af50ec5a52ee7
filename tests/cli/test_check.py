"""`rcx check` reports errors in structured text and violations of each portability rule."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from structured_text.engines.matiec.faults import places
from structured_text.errors import InputError
from structured_text.language.checked import analysed
from structured_text.language.portability import lint

Captured = pytest.CaptureFixture[str]


def write(folder: Path, name: str, text: str) -> Path:
    file = folder / f"{name}.st"
    file.write_text(text)
    return file


def block(declarations: str = "    a : INT;\n", body: str = "  a := 1;\n") -> str:
    return f"FUNCTION_BLOCK FB_It\n  VAR\n{declarations}  END_VAR\n{body}END_FUNCTION_BLOCK\n"


@pytest.mark.exhaustive
def test_the_library_keeps_its_own_rules(repository: Path, capsys: Captured) -> None:
    assert main(["check", str(repository / "plc" / "lib")]) == 0
    assert "no errors, no broken rules, no warnings" in capsys.readouterr().out


def test_every_error_is_listed_and_the_exit_code_is_2(tmp_path: Path, capsys: Captured) -> None:
    body = "  a := TRUE;\n  b := 1;\n"
    file = write(tmp_path, "FB_It", block(body=body))
    assert main(["check", str(file)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.startswith(f"error: {file}:{5 + k}:") for k, line in enumerate(lines)] == [
        True,
        True,
    ]


def test_a_users_file_is_warned_and_the_exit_code_is_0(tmp_path: Path, capsys: Captured) -> None:
    text = block("    a : INT;\n    b : INT;\n", "  FOR a := 0 TO 3 DO\n    b := a;\n  END_FOR;\n")
    file = write(tmp_path, "FB_It", text)
    assert main(["check", str(file)]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"{file}:6:3: warning: FOR: ")
    assert "no broken rules, 1 warning" in out


def test_a_broken_rule_of_the_library_exits_with_1(tmp_path: Path, capsys: Captured) -> None:
    file = write(tmp_path, "FB_Other", block())
    assert main(["check", str(file), "--lib", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert f"{file}:1:16: rule: FB_It is not in a file of this name but in FB_Other\n" in out


def test_lint_checks_all_programs_of_a_folder(
    repository: Path, tmp_path: Path, capsys: Captured
) -> None:
    assert main(["check", "--lint", str(repository / "plc" / "examples")]) == 0
    assert "checked for portability: no broken rules" in capsys.readouterr().out
    text = "PROGRAM One\n  VAR\n    a : TIME := T#1s5ms;\n  END_VAR\n  a := T#0s;\nEND_PROGRAM\n"
    first = write(tmp_path, "One", text)
    write(tmp_path, "Two", text)
    assert main(["check", "--lint", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert out.startswith(f"{first}:3:17: rule: T#1s5ms: write a TIME")
    assert out.endswith("2 files checked for portability: 2 broken rules\n")


def test_a_missing_file_is_exit_code_2(capsys: Captured) -> None:
    assert main(["check", "/nowhere/x.st"]) == 2
    assert capsys.readouterr().err == "rcx: /nowhere/x.st: no such file\n"


@pytest.mark.parametrize(
    ("text", "line", "finding"),
    [
        (block("    a : ARRAY [0..3] OF INT;\n", "  a[0] := 1;\n"), 3, "an array without a name"),
        (block("    a : ARRAY [0..3] OF FB_X;\n"), 3, "an array of blocks"),
        (block("    a : INT;\n    t : STRING[8];\n"), 4, "STRING with a length"),
        (block("    a : RCX_A := [1, 2];\n"), 3, "an initial value for a whole array"),
        (block("    a AT %MW0 : INT;\n"), 3, "a located variable in a block"),
        (block("    a, b, c : FB_Y;\n"), 3, "three blocks in one declaration"),
        (block("    a, b, c : TON;\n"), 3, "three blocks in one declaration"),
        (block(body="  if a = 1 THEN\n    a := 2;\n  END_IF;\n"), 5, "if: write keywords in upper"),
        (block(body="\ta := 1;\n"), 5, "a tab"),
        (block(body="  a := 1;" + " " * 90 + "(* *)\n"), 5, "longer than 100 characters"),
        (block(body=f"  t := '{'x' * 90}'; a := 1;\n"), 5, "longer than 100 characters"),
        (block(body="  CASE a OF\n    16#01: a := 2;\n  END_CASE;\n"), 6, "the label 16#01"),
        (block(body="  CASE a OF\n    Limit1: a := 2;\n  END_CASE;\n"), 6, "the label Limit1"),
        (block("    t : TIME := T#1s500ms;\n"), 3, "T#1s500ms: write a TIME with one whole"),
        (block("    t : TIME := T#1.5s;\n"), 3, "T#1.5s: write a TIME with one whole"),
        (block(body="  a := DINT#-5;\n"), 5, "DINT#-5: a sign after #"),
        (block(body="  a := TIME_TO_INT(T#1s);\n"), 5, "TIME_TO_INT: conversions of TIME differ"),
        (block(body="  IF SHL(a, 1) = a THEN\n    a := 1;\n  END_IF;\n"), 5, "a comparison of NOT"),
        (block(body="  IF (NOT a) = a THEN\n    a := 1;\n  END_IF;\n"), 5, "a comparison of NOT"),
        (block(body="  b := NOT (a = a);\n"), 5, "NOT of a comparison"),
        (block(body="  b := NOT (b AND (a < a));\n"), 5, "NOT of a comparison"),
        (block(body="  t := MID(IN := 'abc', L := 1, P := 2);\n"), 5, "MID of a literal"),
        ("FUNCTION_BLOCK FB_It\n  VAR_EXTERNAL\n    a : INT;\n  END_VAR\n  a := 1;\n"
         "END_FUNCTION_BLOCK\n", 2, "VAR_EXTERNAL in a block"),
        ("FUNCTION_BLOCK FB_It\n  VAR RETAIN\n    a : INT;\n  END_VAR\n  a := 1;\n"
         "END_FUNCTION_BLOCK\n", 2, "RETAIN in a block"),
        ("FUNCTION FC_It : INT\n  VAR_INPUT\n    a : RCX_A;\n  END_VAR\n  FC_It := 1;\n"
         "END_FUNCTION\n", 3, "an input of a function that is not elementary"),
        ("FUNCTION FC_It : INT\n  VAR\n    a : INT;\n  END_VAR\n  FC_It := a;\nEND_FUNCTION\n", 1,
         "a function without an input"),
        ("FUNCTION FC_It : INT\n  VAR_INPUT\n    a : INT;\n  END_VAR\n"
         "  VAR_OUTPUT\n    b : INT;\n  END_VAR\n  FC_It := a;\nEND_FUNCTION\n", 5,
         "VAR_OUTPUT in a function"),
        ("TYPE\n  RCX_A : STRUCT\n    a : FB_X;\n  END_STRUCT;\nEND_TYPE\n", 3,
         "a block in a structure"),
        ("TYPE\n  RCX_A : ARRAY [0..Top] OF INT;\nEND_TYPE\n", 2,
         "array bounds must be literals"),
        ("TYPE\n  RCX_A : (A_ONE := 1, A_TWO);\nEND_TYPE\n", 2, "an enumeration with values"),
        ("TYPE\n  RCX_A : INT (0..5);\nEND_TYPE\n", 2, "a subrange"),
    ],
)  # fmt: skip
def test_each_portability_rule_is_found(tmp_path: Path, text: str, line: int, finding: str) -> None:
    file = write(tmp_path, "It", text)
    found = lint([file], binding=True)
    assert [one.at.line for one in found if finding in one.text] == [line], found
    assert all(one.strict for one in found)


def test_a_line_with_one_long_text_may_be_longer(tmp_path: Path) -> None:
    body = f"  t := '{'$E3$81$82' * 20}';\n  t := '{'x' * 110}';\n"
    assert not lint([write(tmp_path, "It", block("    t : STRING;\n", body))])


#: Words that are reserved in edition 3 of IEC 61131-3, but not in edition 2. The list has no
#: keywords of the built-in engine, because they are errors before the portability rules are
#: checked.
_NEW_WORDS = ["Abstract", "CHAR", "Char", "End_Class", "END_INTERFACE", "End_Method",
              "END_NAMESPACE", "Final", "Internal", "LDATE", "Ldate_And_Time", "Ldt", "Ltime",
              "LTIME_OF_DAY", "Ltod", "Null", "Overlap", "Override", "Private", "Protected",
              "Public", "Super", "This", "Using", "Ustring", "Wchar"]  # fmt: skip


@pytest.mark.parametrize("word", _NEW_WORDS)
def test_reserved_words_of_edition_3_are_not_allowed_as_names(tmp_path: Path, word: str) -> None:
    """A name that is a type or keyword on newer PLCs does not compile there, so it is reported.

    Source: IEC 61131-3:2013, 6.1.2 and table 10.
    """
    variable = block(f"    {word} : INT;\n", f"  {word} := 1;\n")
    field = f"TYPE\n  RCX_A : STRUCT\n    {word} : INT;\n  END_STRUCT;\nEND_TYPE\n"
    member = f"TYPE\n  RCX_A : (A_ONE, {word});\nEND_TYPE\n"
    kind = f"TYPE\n  {word} : INT;\nEND_TYPE\n"
    called = block().replace("FB_It", word)
    for text in (variable, field, member, kind, called):
        # as enumeration values, Super and This are errors before the check of the rules
        if text is member and word in ("Super", "This"):
            with pytest.raises(InputError, match=f"It.st:2:19: {word} is a reserved word"):
                lint([write(tmp_path, "It", text)])
            continue
        found = [one.text for one in lint([write(tmp_path, "It", text)])]
        assert found == [f"{word} is a reserved word of the newer standard: rename it"], text


@pytest.mark.parametrize("word", ["Letter", "Character", "CharCode", "NextChar", "Reference1"])
def test_a_name_may_contain_a_reserved_word(tmp_path: Path, word: str) -> None:
    assert not lint([write(tmp_path, "It", block(f"    {word} : INT;\n", f"  {word} := 1;\n"))])


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("'It$'s'", [11]),
        ("'$'$\"'", [9, 11]),
        ("'$$$''", [11]),
        ("'$$'", []),
        ("'$27$22$N$$27'", []),
        ("'say \"hello\"'", []),
    ],
)
def test_escaped_quotes_need_their_code(tmp_path: Path, text: str, columns: list[int]) -> None:
    """`$'` in a text is reported, because some compilers take its quote as the end of the text.

    Source: IEC 61131-3:2003, 2.2.2: $' and $27 are the same character.
    """
    found = lint([write(tmp_path, "It", block("    t : STRING;\n", f"  t := {text};\n"))])
    assert [one.at.column for one in found] == columns
    assert all("ends the text on some PLCs: write $2" in one.text for one in found)


@pytest.mark.parametrize(
    ("text", "finding"),
    [
        ("TYPE\n  WORDS : ARRAY [0..1] OF WORD;\nEND_TYPE\n", "does not begin with RCX_"),
        (block() + block().replace("FB_It", "FB_Two"), "a second declaration"),
    ],
)
def test_the_library_has_rules_of_its_own(tmp_path: Path, text: str, finding: str) -> None:
    file = write(tmp_path, "WORDS", text)
    assert any(finding in one.text for one in lint([file], library=[file], prefix="RCX_"))
    assert not any(finding in one.text for one in lint([file]))


def test_a_fault_of_matiec_is_a_warning_with_all_its_lines(
    tmp_path: Path, capsys: Captured
) -> None:
    """One warning names all lines, even if matiec is not installed.

    Source: docs/reference/engines.md.
    """
    text = "PROGRAM Main\nVAR V : STRING; END_VAR\n  V := 'a$Nb';\n  V := 'c$0Ad';\nEND_PROGRAM\n"
    file = write(tmp_path, "Main", text)
    assert main(["check", str(file)]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith(f"{file}:3:10: warning: $ escape before 0 to 9 or A to F in a text ")
    assert "($Nb; also line 4): matiec joins the escape and the next characters into" in first


def test_a_program_that_matiec_cannot_compile_is_only_warned(
    tmp_path: Path, capsys: Captured
) -> None:
    """The exit code is 0, because the built-in engine runs the program.

    Source: docs/reference/engines.md.
    """
    text = "PROGRAM Main\nVAR V : STRING; END_VAR\n  V := 'a$Lb';\nEND_PROGRAM\n"
    file = write(tmp_path, "Main", text)
    assert main(["check", str(file)]) == 0
    out = capsys.readouterr().out
    assert "$L in a text: matiec makes C code that does not compile; write $N" in out
    assert out.endswith("; matiec cannot compile it: it runs on the built-in engine only\n")


@pytest.mark.parametrize("wrong", ["A : FB_MovPtp;", "A : FB_MOVE_PTP;"])
def test_a_block_of_the_library_is_proposed_for_an_unknown_block(
    wrong: str, tmp_path: Path, capsys: Captured
) -> None:
    """The message for an unknown block proposes a similar block of plc/lib. Source: plc/lib."""
    file = write(tmp_path, "Main", f"PROGRAM Main\nVAR {wrong} END_VAR\nEND_PROGRAM\n")
    assert main(["check", str(file)]) == 2
    assert "did you mean FB_MovePtp" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_no_fault_of_matiec_concerns_the_examples(repository: Path) -> None:
    """No statement of the examples is affected by a fault of matiec, as their equal traces show."""
    folders = [file.parent for file in (repository / "plc" / "examples").rglob("*.st")]
    assert len(folders) > 15
    for folder in dict.fromkeys(folders):
        project, _ = analysed(source_files([folder]).all)
        assert project is not None
        assert [str(place) for place in places(project)] == []
