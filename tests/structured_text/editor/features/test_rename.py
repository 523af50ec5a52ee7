"""Rename changes all places of a name, and refuses names that would change the program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from lsprotocol import types as lsp

from cursor import FOLDER, at_cursor, edited, index_of
from structured_text.editor.features.rename import prepare, rename
from structured_text.editor.index import Index, build
from structured_text.editor.names import Definition
from structured_text.editor.positions import to_editor
from structured_text.errors import InputError
from structured_text.language.load import read_file
from structured_text.language.parser import read_text
from structured_text.language.source import in_dialect

_FILES = {
    "Types": """TYPE
  Mode : (OFF, AUTO);
  Colour : (RED, BLACK);
  Point : STRUCT x : INT; m : Mode; END_STRUCT;
END_TYPE
""",
    "GVL": "VAR_GLOBAL Level : INT; Bound : INT := 3; END_VAR\n",
    "Pump": """INTERFACE Runs
METHOD Run : BOOL VAR_INPUT Fast : BOOL; END_VAR END_METHOD END_INTERFACE
FUNCTION_BLOCK Base IMPLEMENTS Runs
VAR_INPUT Speed : INT := 3; END_VAR
VAR_OUTPUT Busy : BOOL; END_VAR
VAR Inner : INT; END_VAR
METHOD Run : BOOL
VAR_INPUT Fast : BOOL; END_VAR
VAR count : INT; END_VAR
count := Speed + Level;
Run := Fast AND Busy;
END_METHOD
Busy := Inner > Twice(n := Speed);
END_FUNCTION_BLOCK
FUNCTION_BLOCK Pump EXTENDS Base
VAR own : INT; END_VAR
own := Speed + Bound;
SUPER^();
END_FUNCTION_BLOCK
FUNCTION Twice : INT
VAR_INPUT n : INT; END_VAR
Twice := n * 2;
END_FUNCTION
""",
    "Main": """PROGRAM Main
VAR
  P : Pump := (Speed := 4); (* a pump; 😀 *)
  M : Mode := AUTO; c : Colour := BLACK;
  q : ARRAY [1..2] OF Point;
  i : INT;
END_VAR
\t(* 😀 *) P(Speed := Level, Busy => q[i].x.0);
FOR i := 1 TO 2 DO q[i].m := Mode#OFF; END_FOR
CASE M OF OFF: M := AUTO; AUTO: i := Twice(n := GVL.Bound); END_CASE
IF P.Run(Fast := TRUE) THEN Level := P.Speed; END_IF
IF c = RED THEN Bound := 1; END_IF
END_PROGRAM
""",
}


_MIXED = "is already declared there, or would be mixed up with the"


def _renamed(index: Index, found: Definition, name: str) -> dict[str, str]:
    """Return the texts after a rename at the declaration of a name."""
    text = index.text(found.file)
    edit = rename(index, found.path, text.text, to_editor(text.lines, found.at), name)
    return {Path(file).stem: edited(index, edit, file) for file in index.files}


def _meanings(index: Index) -> list[tuple[str, str, str, int]]:
    """Return file, role and definition of each name, in the order of the text, without names."""
    order = {one: number for number, one in enumerate(index.names.all())}
    return [
        (file, one.role, one.definition.kind, order[one.definition])
        for file in index.files
        for one in index.occurrences(file)
    ]


def _rename(text: str, name: str, **others: str) -> str:
    place = at_cursor(text, **others)
    return edited(place.index, rename(*place.args, name), str(place.path))


def test_a_pin_is_renamed_in_block_and_calls() -> None:
    """The pin Speed has six places in two files besides its declaration."""
    index = index_of(**_FILES)
    assert index.errors == []
    found = index.names.get("BASE.SPEED")
    assert found is not None
    texts = _renamed(index, found, "Pace")
    assert texts == {name: text.replace("Speed", "Pace") for name, text in _FILES.items()}


_INDEX = index_of(**_FILES)
_ALL = [one for one in _INDEX.names.all() if one.kind != "list"]
_NAMES = st.one_of(
    st.from_regex(r"[a-z][a-z0-9]{0,5}", fullmatch=True),
    st.sampled_from(sorted({one.name for one in _ALL})),
)


def _check_round_trip(found: Definition, name: str) -> None:
    before = found.name
    try:
        texts = _renamed(_INDEX, found, name)
    except InputError:
        return
    after = index_of(**texts)
    assert after.errors == []
    assert _meanings(after) == _meanings(_INDEX)
    again = after.names.get(f"{found.owner}.{name.upper()}".lstrip("."))
    assert again is not None
    assert _renamed(after, again, before) == _FILES


@pytest.mark.exhaustive
@settings(max_examples=12, deadline=None)
@example(_INDEX.names.get("BASE.RUN"), "Go")
@example(_INDEX.names.get("RUNS.RUN.FAST"), "quick")
@example(_INDEX.names.get("@GVL.LEVEL"), "own")
@example(_INDEX.names.get("MODE.AUTO"), "i")
@example(_INDEX.names.get("BASE.INNER"), "count")
@given(st.sampled_from(_ALL), _NAMES)
def test_a_rename_and_back_gives_the_same_text(found: Definition, name: str) -> None:
    """After a rename each name has the meaning that it had before; or the name is refused."""
    assume(name.upper() != found.name.upper())
    _check_round_trip(found, name)


@pytest.mark.exhaustive
@pytest.mark.parametrize("found", _ALL, ids=lambda one: one.key)
def test_each_name_can_get_each_other_name_or_is_refused(found: Definition) -> None:
    """All pairs of names of the project above."""
    for other in {one.name for one in _ALL if one.name.upper() != found.name.upper()}:
        _check_round_trip(found, other)


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        ("|a := 1;", "1a", "'1a' is not a name"),
        ("|a := 1;", "if", "if is a word of the language or its standard"),
        ("|a := 1;", "ABS", "ABS is a word of the language or its standard"),
        ("|a := 1;", "b", f"b {_MIXED} variable"),
        ("|a := 1;", "Pump", f"Pump {_MIXED} function_block"),
        ("|a := 1;", "AUTO", f"AUTO {_MIXED} member"),
        ("|Level := 1;", "a", f"a {_MIXED} variable"),
        ("|x := 1;", "y", "x is not declared in these sources"),
        ("a := A|BS(1);", "y", "ABS is not declared in these sources"),
        (" | ;", "y", "there is no name here"),
        ("G|VL.Level := 1;", "y", "the list of global variables GVL is named after its file"),
    ],
)
def test_a_new_name_that_does_not_fit_is_refused(text: str, name: str, message: str) -> None:
    """The message says what is in the way."""
    main = f"PROGRAM Main\nVAR a : INT; b : INT; END_VAR\n{text}\nEND_PROGRAM\n"
    others = {name: _FILES[name] for name in ("Types", "GVL")}
    pump = "FUNCTION_BLOCK Pump END_FUNCTION_BLOCK\n"
    with pytest.raises(InputError) as caught:
        _rename(main, name, Pump=pump, **others)
    assert caught.value.message == message


def test_only_the_case_of_a_name_can_change() -> None:
    """The language ignores the case, so that all places get the new spelling."""
    text = "PROGRAM Main VAR alpha : INT; END_VAR\n|Alpha := ALPHA;\nEND_PROGRAM\n"
    assert _rename(text, "ALpha").count("ALpha") == 3


def test_names_of_the_library_are_not_renamed() -> None:
    """The block is declared in a file of the library."""
    pump = "FUNCTION_BLOCK Pump END_FUNCTION_BLOCK\n"
    place = at_cursor("PROGRAM Main VAR P : Pu|mp; END_VAR END_PROGRAM\n", Pump=pump)
    with pytest.raises(InputError, match="Pump is declared in the library"):
        rename(*place.args, "Other", library=[FOLDER / "Pump.st"])


@pytest.mark.parametrize(
    ("name", "refused"), [("Speed", True), ("own", True), ("Size", False), ("Other", False)]
)
def test_a_name_whose_meaning_a_mistake_hides_is_not_renamed(name: str, refused: bool) -> None:
    """The type of Job is missing, so that Job.Speed may be Pump's Speed; line 5 has a mistake."""
    text = """FUNCTION_BLOCK Pump
VAR_INPUT Speed : INT; END_VAR
VAR Job : Missing; own : INT; Size : INT; Other : INT; END_VAR
Speed := Job.Speed + Job.Size; Other := Size;
own := (own;
END_FUNCTION_BLOCK
"""
    index = index_of(Main=text)
    found = index.names.get(f"PUMP.{name.upper()}")
    assert found is not None
    if refused:
        with pytest.raises(InputError, match="because of mistakes in the sources"):
            _renamed(index, found, "Fresh")
    else:
        assert "Fresh" in _renamed(index, found, "Fresh")["Main"]


def test_one_of_several_functions_of_a_name_is_not_renamed() -> None:
    """In the dialect of SIMATIC AX, functions with different inputs may have one name."""
    text = """FUNCTION Half : INT VAR_INPUT n : INT; END_VAR Half := n / 2; END_FUNCTION
FUNCTION Half : REAL VAR_INPUT r : REAL; END_VAR Half := r / 2.0; END_FUNCTION
"""
    path = in_dialect(FOLDER / "Main.st", "ax")
    index = build([path], lambda path: read_text(text, path), lambda _: text)
    with pytest.raises(InputError, match="several functions are called HALF"):
        rename(index, path, text, lsp.Position(0, 10), "Third")


def test_files_that_cannot_be_written_are_not_changed(
    tmp_path: Path, files_of: Callable[..., list[Path]]
) -> None:
    """The file has no right to write."""
    text = "PROGRAM Main VAR a : INT; END_VAR\na := 1;\nEND_PROGRAM\n"
    (path,) = files_of(text)
    path.chmod(0o444)
    index = build([path], read_file)
    with pytest.raises(InputError, match="a is used in a file that cannot be written"):
        rename(index, path, text, lsp.Position(1, 0), "b")


def test_the_range_of_a_name_is_known_before_it_is_renamed() -> None:
    """The name a is one character; a keyword cannot be renamed."""
    text = "PROGRAM Main VAR a : INT; END_VAR\n|a := 1;\nEND_PROGRAM\n"
    assert prepare(*at_cursor(text).args) == lsp.Range(lsp.Position(1, 0), lsp.Position(1, 1))
    assert prepare(*at_cursor("PRO|GRAM Main\nEND_PROGRAM\n").args) is None
