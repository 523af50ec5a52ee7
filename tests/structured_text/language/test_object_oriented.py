"""The portable subset refuses object-oriented constructs."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.errors import InputError
from structured_text.language import portability
from structured_text.language.parser import parse_portable


@pytest.mark.parametrize(
    ("source", "construct"),
    [
        ("FUNCTION_BLOCK F METHOD M ; END_METHOD END_FUNCTION_BLOCK", "a METHOD"),
        (
            "FUNCTION_BLOCK F PROPERTY P : INT GET P := 1; END_GET END_PROPERTY END_FUNCTION_BLOCK",
            "a PROPERTY",
        ),
        ("INTERFACE I END_INTERFACE", "an INTERFACE"),
        ("FUNCTION_BLOCK F EXTENDS G END_FUNCTION_BLOCK", "EXTENDS"),
        ("TYPE S EXTENDS R : STRUCT A : INT; END_STRUCT; END_TYPE", "EXTENDS"),
        ("FUNCTION_BLOCK F IMPLEMENTS I END_FUNCTION_BLOCK", "IMPLEMENTS"),
        ("FUNCTION_BLOCK ABSTRACT F END_FUNCTION_BLOCK", "an access specifier"),
        ("FUNCTION_BLOCK F THIS^.X := 1; END_FUNCTION_BLOCK", "THIS or SUPER"),
        ("FUNCTION_BLOCK F SUPER^(); END_FUNCTION_BLOCK", "THIS or SUPER"),
        ("FUNCTION_BLOCK F VAR P : POINTER TO INT; END_VAR END_FUNCTION_BLOCK", "POINTER TO"),
        ("FUNCTION_BLOCK F VAR P : REF_TO INT; END_VAR END_FUNCTION_BLOCK", "POINTER TO"),
        ("FUNCTION_BLOCK F P^ := 1; END_FUNCTION_BLOCK", "POINTER TO"),
        ("FUNCTION_BLOCK F VAR P : REFERENCE TO INT; END_VAR END_FUNCTION_BLOCK", "REFERENCE TO"),
        ("FUNCTION_BLOCK F R REF= X; END_FUNCTION_BLOCK", "REFERENCE TO"),
        ("NAMESPACE N END_NAMESPACE", "a NAMESPACE"),
        ("USING N;", "a NAMESPACE"),
    ],
)
def test_the_portable_subset_refuses_object_oriented_constructs_by_name(
    source: str, construct: str, tmp_path: Path
) -> None:
    """Each object-oriented construct is refused by its name, also by the rules of the library."""
    with pytest.raises(InputError) as caught:
        parse_portable(source, Path("program.st"))
    named = str(caught.value).split("does not take ")[1].split("; ")
    assert construct in ", ".join(named[:2])
    file = tmp_path / "program.st"
    file.write_text(source, encoding="utf-8")
    assert any(construct in finding.text for finding in portability.lint([file], binding=True))


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("USING N;", "a NAMESPACE;"),
        ("FUNCTION_BLOCK F EXTENDS G R REF= X; END_FUNCTION_BLOCK", "EXTENDS; also REFERENCE TO;"),
    ],
)
def test_a_refusal_names_every_construct(source: str, told: str) -> None:
    with pytest.raises(InputError, match=f"does not take {told}"):
        parse_portable(source, Path("program.st"))
