"""Operators have the precedence of IEC 61131-3."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.language import syntax as s
from structured_text.language.parser import parse_text


def _shown(node: s.Expression) -> str:
    """Return the expression as a text with brackets around every operation."""
    if isinstance(node, s.Binary):
        return f"({_shown(node.left)} {node.op} {_shown(node.right)})"
    if isinstance(node, s.Unary):
        return f"({node.op} {_shown(node.operand)})"
    assert isinstance(node, s.Name)
    return node.text


def _parsed(text: str) -> s.Expression:
    (program,) = parse_text(f"PROGRAM p\nx := {text};\nEND_PROGRAM", Path("p.st")).declarations
    assert isinstance(program, s.Pou)
    (statement,) = program.body
    assert isinstance(statement, s.Assign)
    return statement.value


_RANKS = ["OR", "XOR", "AND", "=", "<", "+", "*", "**"]


@pytest.mark.parametrize("rank", range(len(_RANKS) - 1))
def test_an_operator_binds_more_strongly_than_operators_of_lower_precedence(rank: int) -> None:
    """The expression is bracketed according to the precedence of its operators.

    Source: IEC 61131-3 (2003), annex B.3.1: expressions.
    """
    weak, strong = _RANKS[rank], _RANKS[rank + 1]
    assert _shown(_parsed(f"a {weak} b {strong} c")) == f"(a {weak} (b {strong} c))"
    assert _shown(_parsed(f"a {strong} b {weak} c")) == f"((a {strong} b) {weak} c)"


@pytest.mark.parametrize(
    ("one", "other"),
    [("<", ">="), (">", "<="), ("=", "<>"), ("+", "-"), ("*", "/"), ("/", "MOD"), ("AND", "&")],
)
def test_operators_of_equal_precedence_are_evaluated_from_left_to_right(
    one: str, other: str
) -> None:
    """Operations of equal precedence are bracketed from left to right.

    Source: IEC 61131-3 (2003), 3.3.1: of equal precedence, from left to right.
    """
    first, second = (name.replace("&", "AND") for name in (one, other))
    assert _shown(_parsed(f"a {one} b {other} c")) == f"((a {first} b) {second} c)"
    assert _shown(_parsed(f"a {other} b {one} c")) == f"((a {second} b) {first} c)"


def test_a_weaker_operator_takes_the_whole_expression_before_it_as_its_operand() -> None:
    """A long expression with all operators is bracketed by their precedence.

    Source: IEC 61131-3 (2003), annex B.3.1: expressions.
    """
    found = _shown(_parsed("a OR b AND c = d + e * f ** g - h > i XOR NOT j"))
    assert found == "(a OR ((b AND (c = (((d + (e * (f ** g))) - h) > i))) XOR (NOT j)))"


def test_sign_and_not_bind_most_and_brackets_count() -> None:
    """A sign and NOT bind more than all other operators; brackets are respected.

    Source: IEC 61131-3 (2003), annex B.3.1: expressions.
    """
    assert _shown(_parsed("-a ** b * (c + d)")) == "(((- a) ** b) * (c + d))"
    assert _shown(_parsed("NOT a AND b")) == "((NOT a) AND b)"


def test_the_position_of_an_operation_is_that_of_its_operator() -> None:
    """The position of an operation is that of its operator.

    Source: language/syntax.py: positions are where a construct is named.
    """
    found = _parsed("a + b * c")
    assert isinstance(found, s.Binary)
    assert isinstance(found.right, s.Binary)
    assert (found.at, found.right.at) == (s.Position(2, 8), s.Position(2, 12))
