"""A word of a telegram contains two characters of a text, the first one in the lower byte."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, compiled
from structured_text.engines.base import Program

PROGRAM = ROOT / "tests/data/library/Texts.st"


@pytest.fixture(scope="module", params=ENGINES)
def plc(request: pytest.FixtureRequest) -> Program:
    return compiled(PROGRAM, request.param)


def _words(plc: Program, text: str) -> list[int]:
    words = []
    plc.write("Main.Text", text)
    for number in range(1, 9):
        plc.write("Main.Number", number)
        plc.scan(0)
        words.append(int(plc.read("Main.TwoChars")))
    return words


def test_two_characters_go_into_a_word_the_first_into_the_lower_byte(plc: Program) -> None:
    """The text "12" is 0x3231. Source: remote command guide 1.1."""
    assert _words(plc, "12")[0] == 0x3231


def test_a_text_is_filled_with_spaces_to_sixteen_characters(plc: Program) -> None:
    """A short text is padded with spaces to 16 characters. Source: remote command guide 4.6.1."""
    assert _words(plc, "P1a") == [0x3150, 0x2061] + [0x2020] * 6


def test_every_character_of_a_telegram_has_its_own_code(plc: Program) -> None:
    """Each of the characters 0x20 to 0x7E is sent as its code.

    Source: remote command guide 4.3.2.
    """
    for first in range(0x20, 0x7F, 16):
        codes = range(first, min(first + 16, 0x7F))
        words = _words(plc, "".join(map(chr, codes)))
        sent = [byte for word in words for byte in (word & 0xFF, word >> 8)]
        assert sent == [*codes, *[0x20] * (16 - len(codes))]


@pytest.mark.parametrize(
    ("text", "problem"),
    [("", 0), ("x" * 16, 0), ("x" * 17, 0x8046), ("Tab\t", 0x8046), ("\x7f", 0x8046)],
)
def test_a_text_too_long_or_with_other_characters_is_refused(
    plc: Program, text: str, problem: int
) -> None:
    """A text with more than 16 or other characters is refused.

    Source: guide 4.3.2, 0x20 to 0x7E.
    """
    plc.write("Main.Text", text)
    plc.scan(0)
    assert plc.read("Main.Problem") == problem


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", 0),
        ("A_Z09", 0),
        ("X" * 16, 0),
        ("MAIN   ", 0),  # trailing spaces are allowed
        ("A_Z 09", 0x8046),
        (" MAIN", 0x8046),
        ("A  B", 0x8046),
        ("A" * 14 + " A", 0x8046),
        ("A ~", 0x8046),
        ("X" * 17, 0x8046),
        ("main", 0x8046),
        ("A-B", 0x8046),
        ("aBC", 0x8046),
        ("ABc", 0x8046),
        ("X" * 15 + "x", 0x8046),
        ("A\t", 0x8046),
    ],
)
def test_a_program_name_has_upper_case_letters_digits_and_underscores(
    plc: Program, name: str, problem: int
) -> None:
    """A program name with other characters is refused. Source: remote command guide 4.6.1."""
    plc.write("Main.Text", name)
    plc.scan(0)
    assert plc.read("Main.NameProblem") == problem


def test_of_all_characters_a_program_name_takes_37(plc: Program) -> None:
    """A program name may contain 37 characters. Each of 127 characters is tried between two A.

    Source: remote command guide 4.6.1: letters (uppercase), numbers and underscores.
    """
    taken = []
    for code in range(1, 128):
        plc.write("Main.Text", f"A{chr(code)}A")
        plc.scan(0)
        if plc.read("Main.NameProblem") == 0:
            taken.append(chr(code))
    assert "".join(taken) == "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ_"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((0x4241, 0x0043, 0x4444), "ABC"),  # 0x00 ends the text of an answer
        ((0x4241, 0x2043, 0x2020), "ABC"),  # spaces at the end are removed
        ((0x4120, 0x4220, 0x0000), " A B"),
        ((0x2020, 0x2020, 0x2020), ""),
        ((0x0000, 0x4241, 0x0000), ""),
        ((0x7E7F, 0x1F20, 0x0000), "?~ ?"),
    ],
)
def test_a_response_text_ends_at_zero_and_loses_its_trailing_spaces(
    plc: Program, words: tuple[int, int, int], text: str
) -> None:
    """The text of an answer ends at 0x00, and trailing spaces are removed. Source: guide 4.3.2."""
    for k, word in enumerate(words, 1):
        plc.write(f"Main.W{k}", word)
    plc.scan(0)
    assert plc.read("Main.Read") == text


def test_every_character_comes_back(plc: Program) -> None:
    """Each character of an answer is read correctly. Source: guide 4.3.2: 0x20 to 0x7E."""
    for code in range(0x21, 0x7F):
        plc.write("Main.W1", code)
        plc.scan(0)
        assert plc.read("Main.Read") == chr(code)
