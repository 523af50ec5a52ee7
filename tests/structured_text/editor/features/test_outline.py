"""The outline shows the declarations of a text, also while it is broken."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types as lsp

from cursor import FOLDER, index_of
from structured_text.editor.features.outline import outline

_TEXT = """TYPE
  Mode : (OFF, AUTO := 5);
  Point : STRUCT
    x, y : INT;
  END_STRUCT;
  Speed : INT (0..5);
END_TYPE
FUNCTION_BLOCK Pump
VAR_INPUT
  Level AT %IW0 : INT := 3;
END_VAR
VAR CONSTANT
  Most : INT := 9;
END_VAR
METHOD PUBLIC Start : BOOL
VAR_INPUT Fast : BOOL; END_VAR
END_METHOD
IF Level > 1 THEN RETURN; END_IF
END_FUNCTION_BLOCK
"""


def _shown(symbols: Sequence[lsp.DocumentSymbol] | None) -> list[object]:
    return [
        (one.name, one.kind.name, *([_shown(one.children)] if one.children else []))
        for one in symbols or []
    ]


def _outline(text: str, name: str = "Main.st") -> list[lsp.DocumentSymbol]:
    return outline(index_of(), FOLDER / name, text)


def test_the_outline_has_types_blocks_methods_and_variables() -> None:
    """The nesting is that of the text above."""
    assert _shown(_outline(_TEXT)) == [
        ("Mode", "Enum", [("OFF", "EnumMember"), ("AUTO", "EnumMember")]),
        ("Point", "Struct", [("x", "Field"), ("y", "Field")]),
        ("Speed", "Struct"),
        (
            "Pump",
            "Class",
            [
                ("Level", "Variable"),
                ("Most", "Constant"),
                ("Start", "Method", [("Fast", "Variable")]),
            ],
        ),
    ]


def test_a_symbol_has_its_range_its_name_and_its_type() -> None:
    """The block is lines 8 to 19, its name at character 15; the pin has type and initial value."""
    pump = _outline(_TEXT)[3]
    assert (pump.range.start.line, pump.range.end.line) == (7, 18)
    assert pump.selection_range.start == lsp.Position(7, 15)
    assert pump.children is not None
    assert pump.children[0].detail == "INT := 3"
    assert pump.detail == "FUNCTION_BLOCK"


def test_an_unfinished_text_has_an_outline() -> None:
    """The END words are missing, because somebody is typing."""
    text = "FUNCTION_BLOCK A\nVAR a : INT; END_VAR\nIF a\nFUNCTION_BLOCK B\nVAR b :"
    assert _shown(_outline(text)) == [
        ("A", "Class", [("a", "Variable")]),
        ("B", "Class", [("b", "Variable")]),
    ]


def test_the_outline_of_a_twincat_file_is_that_of_its_texts() -> None:
    """An action has its name in the XML only; the block has no END."""
    text = """<TcPlcObject><POU Name="Main">
<Declaration><![CDATA[PROGRAM Main
VAR a : INT; END_VAR]]></Declaration>
<Implementation><ST><![CDATA[a := 1;]]></ST></Implementation>
<Action Name="Go"><Implementation><ST><![CDATA[a := 2;]]></ST></Implementation></Action>
<Method Name="Run"><Declaration><![CDATA[METHOD Run : BOOL]]></Declaration></Method>
</POU></TcPlcObject>"""
    assert _shown(_outline(text, "Main.TcPOU")) == [
        ("Main", "Module", [("a", "Variable"), ("Go", "Method"), ("Run", "Method")])
    ]
