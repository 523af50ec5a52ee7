"""The positions of syntax nodes in the text of their file."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from structured_text.language import syntax as s
from structured_text.language.lexer import tokens

__all__ = ["Edit", "SourceText", "Span", "edited", "whole_lines"]

#: The first words of statements that end with END_ and the same word.
_OPENING = ("IF", "CASE", "WHILE", "FOR", "REPEAT")


@dataclass(frozen=True)
class Span:
    """The characters from `start` up to, but not including, `end`."""

    start: int
    end: int


@dataclass(frozen=True)
class Edit:
    """A replacement of a span by a text; an insertion if the span is empty."""

    span: Span
    text: str


def edited(text: str, edits: tuple[Edit, ...]) -> str:
    """Return the text with the edits applied; their spans must not overlap."""
    for edit in sorted(edits, key=lambda edit: edit.span.start, reverse=True):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return text


def whole_lines(text: str, span: Span) -> Span:
    """Return the span of all lines that a span touches."""
    start = text.rfind("\n", 0, span.start) + 1
    end = text.find("\n", span.end)
    return Span(start, len(text) if end < 0 else end + 1)


class SourceText:
    """The text of a file with its tokens; `span` finds a node in it.

    The syntax tree records only where a node begins. The end is found by counting tokens, and
    parentheses around a node are found by matching them.
    """

    def __init__(self, text: str, file: Path) -> None:
        self.text = text
        self._tokens = list(tokens(text, file))
        self._starts = [token.start_pos or 0 for token in self._tokens]
        self._places = {
            (token.line, token.column): index for index, token in enumerate(self._tokens)
        }
        self._closing: dict[int, int] = {}
        self._opening: dict[int, int] = {}
        open_ones: list[int] = []
        for index, token in enumerate(self._tokens):
            if token.type in ("LPAR", "LSQB"):
                open_ones.append(index)
            elif token.type in ("RPAR", "RSQB"):
                self._closing[open_ones[-1]] = index
                self._opening[index] = open_ones.pop()

    # --- nodes ---

    def span(self, node: Any) -> Span:
        """Return the span of a node, without parentheses around it."""
        first, last = self._range(node)
        return self._span(first, last)

    def of(self, node: Any) -> str:
        """Return the text of a node."""
        span = self.span(node)
        return self.text[span.start : span.end]

    def operator(self, node: s.Binary | s.Unary) -> Span:
        """Return the span of an expression's operator."""
        index = self._at(node.at)
        return self._span(index, index)

    def operands(self, node: s.Binary) -> tuple[Span, Span]:
        """Return the spans of both operands, with the parentheses around each operand."""
        operator = self._at(node.at)
        first, last = self._range(node)
        return self._span(first, operator - 1), self._span(operator + 1, last)

    def operand(self, node: s.Unary) -> Span:
        """Return the span of a unary operator's operand, with parentheses around the operand."""
        first, last = self._range(node)
        return self._span(first + 1, last)

    def token_after(self, span: Span, kind: str) -> Span:
        """Return the span of the next token of a kind after a span."""
        index = bisect_right(self._starts, span.end - 1)
        while self._tokens[index].type != kind:
            index += 1
        return self._span(index, index)

    # --- tokens ---

    def _at(self, at: s.Position) -> int:
        return self._places[at.line, at.column]

    def _span(self, first: int, last: int) -> Span:
        end = self._tokens[last]
        return Span(self._starts[first], self._starts[last] + len(end))

    def _range(self, node: Any) -> tuple[int, int]:
        """Return the first and last token of a node, without parentheses around it."""
        if isinstance(node, (s.Name, s.Literal)):
            index = self._at(node.at)
            return index, index
        if isinstance(node, s.Field):
            return self._range(node.base)[0], self._at(node.name.at)
        if isinstance(node, (s.Part, s.Dereference)):
            first, last = self._range(node.base)
            return first, last + (2 if isinstance(node, s.Part) else 1)
        if isinstance(node, s.Call):
            first = self._at(node.at)
            return first, self._closing[first + 1]
        if isinstance(node, (s.Index, s.Invoke)):
            first, last = self._range(node.base if isinstance(node, s.Index) else node.callee)
            return first, self._closing[last + 1]
        if isinstance(node, s.This):
            first = self._at(node.at)
            return first, first if node.pointer else first + 1
        if isinstance(node, s.Argument):
            value = self._range(node.value)
            first = self._at(node.at)
            if node.name is None:
                return value
            return first, self._wrapped(first + 2, value)
        if isinstance(node, s.Unary):
            first = self._at(node.at)
            return first, self._wrapped(first + 1, self._range(node.operand))
        if isinstance(node, s.Binary):
            operator = self._at(node.at)
            first, last = self._range(node.left)
            while last < operator - 1:
                first, last = first - 1, last + 1
            return first, self._wrapped(operator + 1, self._range(node.right))
        return self._statement(node)

    @staticmethod
    def _wrapped(start: int, inner: tuple[int, int]) -> int:
        """Return the last token of an operand that begins at `start` with its parentheses.

        As many parentheses close after the operand as open before it.
        """
        return inner[1] + inner[0] - start

    def _statement(self, node: Any) -> tuple[int, int]:
        """Return the first and last token of a statement."""
        first = self._at(node.at)
        index, depth = first, 0
        while True:
            kind = self._tokens[index].type
            if kind in _OPENING:
                depth += 1
            elif kind.removeprefix("END_") in _OPENING:
                depth -= 1
                if depth == 0 and self._kind(index + 1) != "SEMICOLON":
                    # Many tools accept a missing semicolon behind END_IF and similar words.
                    return first, index
            elif kind == "SEMICOLON" and depth == 0:
                return first, index
            index += 1

    def _kind(self, index: int) -> str:
        return self._tokens[index].type if index < len(self._tokens) else ""
