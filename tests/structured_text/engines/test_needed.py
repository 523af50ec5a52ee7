"""Only those library files are compiled that a program needs."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.projects.needed import needed


def _files(folder: Path, **texts: str) -> dict[str, Path]:
    files = {}
    for name, text in texts.items():
        files[name] = folder / f"{name}.st"
        files[name].write_text(text, encoding="utf-8")
    return files


_ONE = "FUNCTION_BLOCK FB_One END_FUNCTION_BLOCK"
#: Cases: the program, the library files, and the library files that the program needs.
_CASES = {
    "a used file, with the files that it needs": (
        "PROGRAM Main VAR a : fb_one; END_VAR END_PROGRAM",
        {
            "FB_Two": "FUNCTION_BLOCK FB_Two VAR x : RCX_T; END_VAR END_FUNCTION_BLOCK",
            "FB_One": "FUNCTION_BLOCK FB_One VAR x : FB_Two; END_VAR END_FUNCTION_BLOCK",
            "RCX_T": "TYPE RCX_T : (A, B); END_TYPE",
            "FB_Idle": "(* FB_One *) FUNCTION_BLOCK FB_Idle VAR x : FB_One; END_VAR "
            "END_FUNCTION_BLOCK",
        },
        "FB_Two FB_One RCX_T",
    ),
    "a name in a comment": ("PROGRAM Main (* FB_One *) END_PROGRAM", {"FB_One": _ONE}, ""),
    "a name in a string, and a name beside the string": (
        "PROGRAM Main s := 'it$'s FB_One (*'; a : FB_Two; (* isn't FB_One *) END_PROGRAM",
        {"FB_One": _ONE, "FB_Two": "FUNCTION_BLOCK FB_Two END_FUNCTION_BLOCK"},
        "FB_Two",
    ),
    "a file with another name": (
        "PROGRAM Main VAR a : INNER; END_VAR END_PROGRAM",
        {"many": "TYPE OUTER : INT; INNER : STRUCT x : INT; END_STRUCT; END_TYPE"},
        "many",
    ),
    "a button called as a field of a structure": (
        "PROGRAM Main VAR Start : BOOL; p : OUTER; END_VAR END_PROGRAM",
        {
            "panel": "TYPE PANEL : STRUCT Start : BOOL; Kind : INT; END_STRUCT; END_TYPE",
            "both": "TYPE BITS : UNION Start : BOOL; END_UNION; OUTER : INT; END_TYPE",
        },
        "both",
    ),
    "a configuration and a file without names are always needed": (
        "PROGRAM Main END_PROGRAM",
        {
            "globals": "CONFIGURATION c VAR_GLOBAL g : FB_One; END_VAR END_CONFIGURATION",
            "FB_One": _ONE,
            "odd": "only unknown names",
        },
        "globals FB_One odd",
    ),
    "words of the language in lower case": (
        "program Main var a : fb_one; b : rcx_t; end_var end_program",
        {
            "one": "function_block FB_One end_function_block "
            "function_block FB_Two end_function_block",
            "types": "type RCX_T : (A, B); end_type",
            "idle": "function_block FB_Idle end_function_block",
            "globals": "configuration c end_configuration",
        },
        "one types globals",
    ),
}


@pytest.mark.parametrize("name", _CASES)
def test_a_program_needs_the_library_files_whose_names_it_uses(name: str, tmp_path: Path) -> None:
    """A program needs the library files that declare names in its code, in upper or lower case.

    Source: IEC 61131-3 (2003), 2.1.3.
    """
    main, texts, expected = _CASES[name]
    program, library = _files(tmp_path, main=main)["main"], _files(tmp_path, **texts)
    assert needed([program], list(library.values())) == [library[one] for one in expected.split()]


def test_a_changed_file_is_read_anew_and_a_missing_one_mentions_nothing(tmp_path: Path) -> None:
    program = _files(tmp_path, main="PROGRAM Main END_PROGRAM")["main"]
    library = list(_files(tmp_path, FB_One="FUNCTION_BLOCK FB_One END_FUNCTION_BLOCK").values())
    assert needed([program, tmp_path / "gone.st"], library) == []
    program.write_text("PROGRAM Main VAR a : FB_One; END_VAR END_PROGRAM", encoding="utf-8")
    assert needed([program], library) == library
