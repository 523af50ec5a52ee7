"""A program is compiled with those files of the library that it needs."""

from __future__ import annotations

from pathlib import Path

from structured_text.projects.needed import needed


def _files(folder: Path, **texts: str) -> dict[str, Path]:
    files = {}
    for name, text in texts.items():
        files[name] = folder / f"{name}.st"
        files[name].write_text(text, encoding="utf-8")
    return files


def test_what_is_mentioned_comes_with_what_it_needs_itself(tmp_path: Path) -> None:
    program = _files(tmp_path, main="PROGRAM Main VAR a : fb_one; END_VAR END_PROGRAM")["main"]
    files = _files(
        tmp_path,
        FB_Two="FUNCTION_BLOCK FB_Two VAR x : RCX_T; END_VAR END_FUNCTION_BLOCK",
        FB_One="FUNCTION_BLOCK FB_One VAR x : FB_Two; END_VAR END_FUNCTION_BLOCK",
        RCX_T="TYPE RCX_T : (A, B); END_TYPE",
        FB_Idle="(* FB_One *) FUNCTION_BLOCK FB_Idle VAR x : FB_One; END_VAR END_FUNCTION_BLOCK",
    )
    library = list(files.values())
    assert needed([program], library) == [files["FB_Two"], files["FB_One"], files["RCX_T"]]


def test_a_name_in_a_comment_is_not_mentioned(tmp_path: Path) -> None:
    program = _files(tmp_path, main="PROGRAM Main (* FB_One *) END_PROGRAM")["main"]
    library = _files(tmp_path, FB_One="FUNCTION_BLOCK FB_One END_FUNCTION_BLOCK")
    assert needed([program], list(library.values())) == []


def test_a_name_in_a_text_is_not_mentioned_but_what_stands_beside_it_is(tmp_path: Path) -> None:
    text = "PROGRAM Main s := 'it$'s FB_One (*'; a : FB_Two; (* isn't FB_One *) END_PROGRAM"
    program = _files(tmp_path, main=text)["main"]
    library = _files(
        tmp_path,
        FB_One="FUNCTION_BLOCK FB_One END_FUNCTION_BLOCK",
        FB_Two="FUNCTION_BLOCK FB_Two END_FUNCTION_BLOCK",
    )
    assert needed([program], list(library.values())) == [library["FB_Two"]]


def test_a_file_is_known_by_what_it_declares_not_by_its_name(tmp_path: Path) -> None:
    program = _files(tmp_path, main="PROGRAM Main VAR a : INNER; END_VAR END_PROGRAM")["main"]
    library = _files(
        tmp_path, many="TYPE OUTER : INT; INNER : STRUCT x : INT; END_STRUCT; END_TYPE"
    )
    assert needed([program], list(library.values())) == [library["many"]]


def test_a_field_of_a_structure_is_no_name(tmp_path: Path) -> None:
    """A button called Start does not bring every structure that has such a field."""
    main = "PROGRAM Main VAR Start : BOOL; p : OUTER; END_VAR END_PROGRAM"
    program = _files(tmp_path, main=main)["main"]
    library = _files(
        tmp_path,
        panel="TYPE PANEL : STRUCT Start : BOOL; Kind : INT; END_STRUCT; END_TYPE",
        both="TYPE BITS : UNION Start : BOOL; END_UNION; OUTER : INT; END_TYPE",
    )
    assert needed([program], list(library.values())) == [library["both"]]


def test_a_configuration_and_a_file_without_names_are_always_needed(tmp_path: Path) -> None:
    program = _files(tmp_path, main="PROGRAM Main END_PROGRAM")["main"]
    library = _files(
        tmp_path,
        globals="CONFIGURATION c VAR_GLOBAL g : FB_One; END_VAR END_CONFIGURATION",
        FB_One="FUNCTION_BLOCK FB_One END_FUNCTION_BLOCK",
        odd="nothing that is known",
    )
    assert needed([program], list(library.values())) == list(library.values())


def test_a_changed_file_is_read_anew_and_a_missing_one_mentions_nothing(tmp_path: Path) -> None:
    program = _files(tmp_path, main="PROGRAM Main END_PROGRAM")["main"]
    library = list(_files(tmp_path, FB_One="FUNCTION_BLOCK FB_One END_FUNCTION_BLOCK").values())
    assert needed([program, tmp_path / "gone.st"], library) == []
    program.write_text("PROGRAM Main VAR a : FB_One; END_VAR END_PROGRAM", encoding="utf-8")
    assert needed([program], library) == library


def test_words_of_the_language_are_known_in_lower_case_too(tmp_path: Path) -> None:
    """Source: IEC 61131-3 (2003), 2.1.3: keywords are not told apart by case."""
    program = _files(tmp_path, main="program Main var a : fb_one; b : rcx_t; end_var end_program")
    library = _files(
        tmp_path,
        one="function_block FB_One end_function_block function_block FB_Two end_function_block",
        types="type RCX_T : (A, B); end_type",
        idle="function_block FB_Idle end_function_block",
        globals="configuration c end_configuration",
    )
    found = needed([program["main"]], list(library.values()))
    assert found == [library[name] for name in ("one", "types", "globals")]
