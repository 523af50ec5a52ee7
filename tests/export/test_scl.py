"""`rcx export scl` writes the library in SCL, with # before the names of variables."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from exported import imported, left_out, shape, written
from rcx_harness.cell.exports import export
from structured_text.export.body import Scope
from structured_text.export.parts import Sources
from structured_text.export.scl import Names, scl_body
from structured_text.language import syntax as s
from structured_text.language.parser import parse


@pytest.fixture(scope="module")
def text(whole: bool) -> str:
    """Return the text of the exported SCL file."""
    return written("scl", whole=whole).files[""]


def _block(text: str, name: str) -> str:
    found = re.search(
        rf'^(FUNCTION|FUNCTION_BLOCK|TYPE) "{name}".*?^END_\1$', text, re.DOTALL | re.MULTILINE
    )
    assert found, name
    return found[0]


def _bodies(files: Iterable[Path]) -> dict[str, Any]:
    """Return the statements of each POU. Arguments of calls are in the order of the parameters."""
    pous = [node for file in files for node in parse(file).declarations if isinstance(node, s.Pou)]
    return {node.name.text: _unnamed(shape(node.body)) for node in pous}


def _unnamed(node: Any) -> Any:
    if isinstance(node, list):
        return [_unnamed(one) for one in node]
    if isinstance(node, tuple) and node and node[0] == "Call":
        return ("Call", node[1], [_unnamed(one[2]) for one in node[2]])
    return tuple(map(_unnamed, node)) if isinstance(node, tuple) else node


def _differing(sources: Sources, text: str, folder: Path) -> list[str]:
    """Import the exported text, and return the POUs whose statements differ from the sources."""
    file = folder / "cell.scl"
    file.write_text(text, encoding="utf-8")
    parts = sources.of("FUNCTION", "FUNCTION_BLOCK", "PROGRAM")
    found = _bodies(imported(file, folder / "back"))
    wanted = _bodies(dict.fromkeys(part.file for part in parts))
    wrong = []
    for part in parts:
        undone, body = found[part.name], wanted[part.name]
        cleared = undone[: len(undone) - len(body)]
        if undone[len(cleared) :] != body or not all(_clears(one) for one in cleared):
            wrong.append(part.name)
    return wrong


def _clears(statement: Any) -> bool:
    return bool(statement[0] == "Assign" and statement[2][0] == "Literal")


def test_statements_come_back_from_scl(sources: Sources, text: str, tmp_path: Path) -> None:
    assert _differing(sources, text, tmp_path) == []


def test_every_variable_of_the_statements_is_marked(sources: Sources, text: str) -> None:
    """Each variable in a statement has a #, because a name without # would be a tag of the PLC."""
    for part in sources.of("FUNCTION", "FUNCTION_BLOCK"):
        node = part.node
        assert isinstance(node, s.Pou)
        names = [name.text for one in node.sections for v in one.variables for name in v.names]
        body = _block(text, part.name).partition("\nBEGIN\n")[2]
        body = re.sub(r"'(?:\$.|[^$'\n])*'|\(\*.*?\*\)", "", body, flags=re.DOTALL)
        bare = re.findall(rf'(?<![#.\w"])(?:{"|".join(names)})\b(?!\s*(?::=|=>))', body)
        assert not bare, part.name


def test_pins_have_the_types_and_defaults_of_the_sources(text: str) -> None:
    block = _block(text, "FB_MovePtp")
    assert "      Timeout : TIME := T#60s;   // longest wait for the end; T#0s = no limit" in block
    assert "      SpeedMode : INT := 0;" in block, "an enumeration"
    assert "      Pulses : Array[1..6] of DINT;" in block, "a named array"
    assert '      Robot : "RCX_REF";' in block
    assert "      SPEED_PERCENT : INT := 2;" in block
    assert "SPEED_DIRECT" not in _block(text, "FB_ServoOn")
    assert '      SO : "RCX_SO";' in _block(text, "RCX_REF")


def test_temporary_variables_begin_at_each_call_with_their_values(text: str) -> None:
    """Statements initialise the variables of a function at each call.

    Source: IEC 61131-3, 2.5.1.1.
    """
    block = _block(text, "FC_RcxByteWithBit")
    begin = block.partition("BEGIN\n")[2].splitlines()[:3]
    assert begin == ["  #FC_RcxByteWithBit := 0;", "  #Mask := 0;", "  #Rest := 0;"]


def test_enumerations_are_listed_with_their_numbers(text: str) -> None:
    assert "//   RCX_SPEED_MODE: 0 SPEED_PROGRAM, 1 SPEED_DIRECT, 2 SPEED_PERCENT" in text


def test_functions_get_the_arguments_that_are_left_out_and_shifts_their_names() -> None:
    names = Names((), {"FC_IT": {"FIRST": "1", "SECOND": "2"}})
    at = s.Position(1, 1)
    kind = s.NamedSpec(s.Name("INT", at), at)
    variables = dict.fromkeys(("A", "B", "CHAR"), kind)
    scope = Scope(variables, lambda spec: spec, {"FC_IT": ("First", "Second")}, {"FC_IT"})
    body = "A := FC_It(First := SHL(B, A + 1)) + LEN(IN := B); (* SHL(a, b) *) Char.Label := 'A';"
    assert scl_body(body, scope, names) == (
        '#A := "FC_It"(First := SHL(IN := #B, N := #A + 1), Second := 2) + LEN(#B);'
        ' (* SHL(a, b) *) #"Char"."Label" := \'A\';'
    )


def test_a_part_that_is_not_carried_is_named(tmp_path: Path) -> None:
    program = tmp_path / "Located.st"
    program.write_text(
        "PROGRAM Located\n  VAR\n    Q AT %QX0.0 : BOOL;\n  END_VAR\n  Q := TRUE;\nEND_PROGRAM\n"
    )
    output = export("scl", program=[program], only_needed=True)
    assert left_out(output)[0].startswith("PROGRAM Located: has global or located variables")
    assert "Located" not in output.files[""]
    assert [line.partition(":")[0] for line in written("scl").notes] == ["PROGRAM PowerUp"]


def test_a_variable_whose_name_is_a_word_of_scl_is_declared_in_quotes(tmp_path: Path) -> None:
    (tmp_path / "mine.st").write_text(
        "FUNCTION FC_Mine : INT\n  VAR_INPUT\n    Text : STRING;\n  END_VAR\n  VAR\n"
        "    Char : STRING;\n  END_VAR\n  Char := Text;\n  FC_Mine := LEN(IN := Char);\n"
        "END_FUNCTION\n",
        encoding="utf-8",
    )
    written = _block(export("scl", program=[tmp_path], only_needed=True).files[""], "FC_Mine")
    assert '      "Char" : STRING;' in written
    assert '#"Char" := #Text;' in written
