"""Programs that are larger than any computer are refused before they take memory."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.errors import InputError
from structured_text.language import extent, load, parser, recovery

Errors = Callable[[str], list[InputError]]


def _chain(kind: str, levels: int) -> str:
    """Return declarations of types or blocks. Each contains four instances of the previous one."""
    made = {
        "struct": "TYPE T{}: STRUCT {} END_STRUCT; END_TYPE\n",
        "block": "FUNCTION_BLOCK T{} VAR {} END_VAR END_FUNCTION_BLOCK\n",
    }[kind]
    parts = [made.format(0, "x: INT;")]
    parts += [made.format(k, f"a, b, c, d: T{k - 1};") for k in range(1, levels + 1)]
    return "".join(parts) + f"PROGRAM Own VAR v: T{levels}; END_VAR END_PROGRAM\n"


def test_structures_of_structures_are_counted_without_being_made(mistakes_of: Errors) -> None:
    """Elements are counted without creating them: T10 has 2,446,677 and T11 has 9,786,709.

    Source: docs/reference/limits.md, programs.
    """
    assert mistakes_of(_chain("struct", 7)) == []
    (error,) = mistakes_of(_chain("struct", 60))
    assert error.message == "T11 has 9,786,709 elements, and a program has at most 4,000,000"
    assert (error.line, error.hint) == (12, "make arrays smaller, or declare fewer of them")


def test_blocks_in_blocks_are_counted_without_being_made(mistakes_of: Errors) -> None:
    """T8 has (4^9 - 1) / 3 = 87,381 instances, and T9 has 349,525.

    Source: docs/reference/limits.md, programs.
    """
    assert mistakes_of(_chain("block", 5)) == []
    (error,) = mistakes_of(_chain("block", 60))
    assert error.message == (
        "T9 has 349,525 instances of function blocks, and a program has at most 200,000"
    )
    assert error.line == 10


def test_arrays_of_arrays_are_counted_from_the_inside(mistakes_of: Errors) -> None:
    """Nested arrays are refused by their number of elements or by their depth.

    Source: limits.md, programs: 2^22 - 1 elements and arrays at the 21st level.
    """
    nested = "ARRAY[0..1] OF " * 40
    (error,) = mistakes_of(f"PROGRAM Own VAR a: {nested}INT; END_VAR END_PROGRAM")
    assert error.message.startswith("this array has 4,194,303 elements, and a program has at most")
    flat = "ARRAY[0..0] OF " * 130
    (error,) = mistakes_of(f"PROGRAM Own VAR a: {flat}INT; END_VAR END_PROGRAM")
    assert error.message == "this array has more than 120 nested arrays, structures and blocks"


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limit a program to 1,000 elements."""
    monkeypatch.setattr(extent, "MOST_ELEMENTS", 1_000)


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "PROGRAM Own VAR\n" + "".join(f"a{k}: ARRAY[1..400] OF INT;\n" for k in range(9))
            + "END_VAR END_PROGRAM",
            "the arrays up to here have more than 1,000 elements",
        ),
        (
            "TYPE A: ARRAY[1..400] OF INT; END_TYPE\n"
            "PROGRAM Own VAR a: A := [1]; b: A := [1]; c: A := [1]; END_VAR END_PROGRAM",
            "the arrays up to here have more than 1,000 elements",
        ),
        (
            "TYPE A: ARRAY[1..400] OF INT; END_TYPE\n"
            "PROGRAM Own VAR a, b, c: A; END_VAR END_PROGRAM",
            "Own has 1,204 elements",
        ),
        (
            "TYPE A: ARRAY[1..400] OF INT; END_TYPE\nVAR_GLOBAL a, b: A; END_VAR\n"
            "FUNCTION F: INT VAR_INPUT x: INT; END_VAR VAR a: A; END_VAR F := x; END_FUNCTION\n"
            "PROGRAM Own VAR x: INT; END_VAR x := F(1); END_PROGRAM",
            "the program has 1,207 elements",
        ),
        ("PROGRAM Own VAR a: ARRAY[1..99] OF STRING[80]; END_VAR END_PROGRAM", "1,090 elements"),
        (
            "PROGRAM Own VAR a: ARRAY[1..9] OF INT := [9(9(9(9(9(0)))))]; END_VAR END_PROGRAM",
            "81 values are more than the array holds",
        ),
    ],
)  # fmt: skip
def test_all_variables_together_have_one_limit(mistakes_of: Errors, text: str, told: str) -> None:
    """Types, initial values, instances, globals and variables of functions are added up.

    Source: docs/reference/limits.md, programs.
    """
    (error,) = mistakes_of(text)
    assert told in error.message


def test_the_number_of_words_in_a_source_is_limited(
    mistakes_of: Errors, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A source with more words, numbers and signs than the limit is refused.

    Source: docs/reference/limits.md, programs.
    """
    monkeypatch.setattr(parser, "MOST_TOKENS", 13)
    text = "PROGRAM Own VAR x: INT; END_VAR x := 1;{} END_PROGRAM"
    assert mistakes_of(text.format("")) == []
    (error,) = mistakes_of(text.format(" x := 2;"))
    assert error.message == "more than 13 words, numbers and signs up to here"


@pytest.mark.parametrize("mistake", ["q := 1;\n", ") ;\n", "'\n"])
def test_mistakes_are_listed_up_to_the_limit(
    mistakes_of: Errors, mistake: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Errors beyond the limit are not listed; a last message says so.

    Source: docs/reference/limits.md, programs.
    """
    for module in (load, recovery):
        monkeypatch.setattr(module, "MOST_MISTAKES", 20)
    found = mistakes_of(f"PROGRAM Own\n{mistake * 30}END_PROGRAM\n")
    assert len(found) == 21
    assert (
        "more mistakes, which are not shown" in found[-1].message
        or "mistakes in this file" in found[-1].message
    )


def test_constants_that_use_each_other_are_worked_out_once(mistakes_of: Errors) -> None:
    """Each constant of a chain is evaluated once, so a long chain takes little time.

    Source: docs/reference/limits.md, programs: 100 in a row.
    """
    chain = "".join(f"c{k}: INT := c{k + 1} + 1;\n" for k in range(400))
    text = f"VAR_GLOBAL CONSTANT\n{chain}c400: INT := 1;\nEND_VAR\nPROGRAM Own END_PROGRAM"
    found = mistakes_of(text)
    assert "more than 100 constants and types that use each other in a row" in found[0].message


def test_a_very_long_name_is_cut_in_the_message(mistakes_of: Errors) -> None:
    """A long name is cut in the message.

    Source: docs/reference/limits.md, programs.
    """
    (error,) = mistakes_of(f"PROGRAM Own VAR x: INT; END_VAR x := {'y' * 100_000}; END_PROGRAM")
    assert error.message == f"this name has 100,000 characters: {'y' * 40}..."


def test_comments_that_are_never_closed_are_looked_at_once(mistakes_of: Errors) -> None:
    """The reader searches the rest of the file only once.

    A search for each comment would take hours.

    Source: docs/reference/limits.md.
    """
    (error,) = mistakes_of("PROGRAM Own END_PROGRAM\n" + "(*\n" * 200_000)
    assert error.message == "this comment is never closed"


def test_comments_behind_names_in_a_case_are_looked_at_once(mistakes_of: Errors) -> None:
    """Many comments after names in a CASE do not make the parser slow.

    Source: docs/reference/limits.md.
    """
    rows = "y (* *) (* *)\n" * 60
    found = mistakes_of(
        f"PROGRAM Own VAR x, y: INT; END_VAR CASE x OF 1: y := 1;\n{rows}END_CASE; END_PROGRAM"
    )
    assert found
