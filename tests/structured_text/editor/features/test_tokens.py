"""Semantic tokens say what each name means."""

from __future__ import annotations

from cursor import FOLDER, index_of, marked
from structured_text.editor.features.tokens import LEGEND, tokens

_TEXT = """TYPE Mode : (OFF); END_TYPE
PROGRAM Main
VAR CONSTANT Most : INT := 16#F; END_VAR
VAR T1 : TON; (* 😀
two *) m : Mode; END_VAR
T1(IN := TRUE, PT := T#1s); // x
m := Mode#OFF; IF ABS(Most) > 1 THEN m := OFF; END_IF
END_PROGRAM
"""


def _tokens(text: str, newer: str | None = None) -> list[tuple[int, str, str, str]]:
    """Return line, text, type and modifiers of each token."""
    index = index_of(Main=text)
    shown = text if newer is None else newer
    data = tokens(index, FOLDER / "Main.st", shown).data
    lines = [line.encode("utf-16-le") for line in shown.split("\n")]
    found = []
    line = column = 0
    for place in range(0, len(data), 5):
        down, right, size, kind, bits = data[place : place + 5]
        line, column = line + down, right + (0 if down else column)
        word = lines[line][2 * column : 2 * (column + size)].decode("utf-16-le")
        names = [one for k, one in enumerate(LEGEND.token_modifiers) if bits >> k & 1]
        found.append((line, word, LEGEND.token_types[kind], " ".join(names)))
    return found


def test_each_name_has_a_type_and_modifiers() -> None:
    """The names of the standard are marked; a comment of two lines is two tokens."""
    found = [one[1:] for one in _tokens(_TEXT) if one[2] != "keyword"]
    assert found == [
        ("Mode", "enum", "declaration"),
        ("OFF", "enumMember", "declaration readonly"),
        ("Main", "namespace", "declaration"),
        ("Most", "variable", "declaration readonly"),
        ("INT", "type", "defaultLibrary"),
        ("16#F", "number", ""),
        ("T1", "variable", "declaration"),
        ("TON", "class", "defaultLibrary"),
        ("(* 😀", "comment", ""),
        ("two *)", "comment", ""),
        ("m", "variable", "declaration"),
        ("Mode", "enum", ""),
        ("T1", "variable", ""),
        ("T#1s", "number", ""),
        ("// x", "comment", ""),
        ("m", "variable", "modification"),
        ("Mode", "enum", ""),
        ("OFF", "enumMember", "readonly"),
        ("ABS", "function", "defaultLibrary"),
        ("Most", "variable", "readonly"),
        ("1", "number", ""),
        ("m", "variable", "modification"),
        ("OFF", "enumMember", "readonly"),
    ]


def test_keywords_are_tokens() -> None:
    """The words of line 7 in their order."""
    found = [one[1] for one in _tokens(_TEXT) if one[0] == 6 and one[2] == "keyword"]
    assert found == ["IF", "THEN", "END_IF"]


def test_names_move_with_their_lines_while_somebody_is_typing() -> None:
    """A line is inserted above, and a line is changed: only its names have no colour yet."""
    text = "PROGRAM Main VAR a : INT; END_VAR\na := 1;\na := 2;\nEND_PROGRAM\n"
    newer, _ = marked("PROGRAM Main VAR a : INT; END_VAR\n\na := 1 +|;\na := 2;\nEND_PROGRAM\n")
    found = [(line, kind) for line, word, kind, _ in _tokens(text, newer) if word == "a"]
    assert found == [(0, "variable"), (3, "variable")]


def test_names_in_a_new_comment_have_its_colour() -> None:
    """A comment is opened above lines that have not changed, and is not closed yet."""
    text = "PROGRAM Main VAR a : INT; END_VAR\n\na := 1;\nEND_PROGRAM\n"
    newer = text.replace("\n\n", "\n(*\n")
    assert [one[1:3] for one in _tokens(text, newer)][-3:] == [
        ("(*", "comment"),
        ("a := 1;", "comment"),
        ("END_PROGRAM", "comment"),
    ]
