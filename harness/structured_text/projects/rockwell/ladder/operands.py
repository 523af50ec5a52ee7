"""The operands of ladder instructions: tags, values and expressions.

Logical instructions fill a SINT or INT with zeros to a DINT, all others extend its sign. Source:
1756-RM003, data conversions.
"""

from __future__ import annotations

import re
from dataclasses import replace

from structured_text.language.source import Line
from structured_text.projects.rockwell.data import INTEGERS, NUMBERS, STORED, Data
from structured_text.projects.rockwell.expression_reader import (
    ExpressionReader,
    Routine,
    Token,
    Value,
    bare,
    tokens_of,
)

__all__ = ["BIT_STRINGS", "OperandReader", "Tag"]

#: Functions of CPT and CMP that have another name in Structured Text.
_FUNCTIONS = {"SQR": "SQRT", "ASN": "ASIN", "ACS": "ACOS", "ATN": "ATAN", "TRN": "TRUNC"}
#: Operators of expressions that are words in Structured Text.
_WORDS = {"&&": "AND", "||": "OR"}
#: The bit string with as many bits as an integer has.
BIT_STRINGS = {"SINT": "BYTE", "INT": "WORD", "DINT": "DWORD", "LINT": "LWORD"}
BIT_STRINGS.update({"USINT": "BYTE", "UINT": "WORD", "UDINT": "DWORD", "ULINT": "LWORD"})
_WIDENED = re.compile(r"(SINT|INT)_TO_DINT\((.*)\)", re.DOTALL)
_FROM_BITS = re.compile(r"(BYTE|WORD)_TO_(?:SINT|INT)\((.*)\)", re.DOTALL)
_LITERAL = re.compile(r"\(?(-?)(\d+)\)?")
_BITWISE = ("AND", "OR", "XOR", "&")

Tag = tuple[str, Data]
"""The text of a variable, and its type."""


class OperandReader(ExpressionReader):
    """The reader of one operand of an instruction."""

    def __init__(self, text: str, at: int, routine: Routine) -> None:
        for sign, word in _WORDS.items():
            text = text.replace(sign, f" {word} ")
        super().__init__(tokens_of([Line(text, at)]), at, routine)
        self._varying: tuple[str, Data, str] | None = None

    # --- whole operands -------------------------------------------------------------------

    def value(self) -> Value:
        """Return the value of the operand."""
        value = self._value()
        self._end_here()
        return value

    def tag(self, *, written: bool = False, element: bool = True) -> Tag:
        """Return the variable that the operand names; without `element` up to the last index."""
        found = self._variable(written=written, element=element)
        if element:
            self._end_here()
        return found

    def place(self, *, written: bool = False) -> tuple[str, Data, str]:
        """Return an array, its type and the index at which the operand begins, or a tag and 0.

        An element of an array with several dimensions is a tag.
        """
        text, data = self._variable(written=written, element=False)
        index = "0"
        if len(data.sizes) > 1 and self._peek().text == "[":
            text, data = self._indexed(text, data, self._peek())
        elif data.sizes and self._take("["):
            index = bare(self._whole(self._value()))
            self._expect("]")
        self._end_here()
        return text, data, index

    def read(self, text: str, data: Data) -> Value:
        """Return the value of a variable."""
        return self._read(text, data, self._peek())

    def _end_here(self) -> None:
        token = self._peek()
        if token.kind != "end":
            raise self._error(f"{token.text!r} is not expected here", token)

    def _member(self, text: str, data: Data, token: Token) -> Tag:
        """Read a member; `.[index]` is the bit whose number is the value of the index."""
        if self._peek().text != "[":
            return super()._member(text, data, token)
        if data.type not in INTEGERS or data.sizes or data.stored:
            raise self._error(f"{text} is not a whole number, so it has no bits", token)
        self._next()
        index = self._whole(self._value())
        self._expect("]")
        self._varying = text, data, index
        kind = BIT_STRINGS[data.type]
        word = f"{data.type}_TO_{kind}({text})"
        return f"((SHR({word}, {bare(index)}) AND {kind}#1) <> {kind}#0)", Data("BOOL")

    def varying_bit(self) -> tuple[str, Data, str] | None:
        """Return the tag and the index of a bit `tag.[index]` that was read; None for others."""
        return self._varying

    # --- conversions ----------------------------------------------------------------------

    def converted(self, value: Value, kind: str) -> str:
        """Return a value converted to a type, with its sign."""
        return self._converted(value, kind, self._peek())

    def _converted(self, value: Value, kind: str, token: Token) -> str:
        text, given = value
        return super()._converted(value if given == kind else (bare(text), given), kind, token)

    def calculated(self, left: Value, sign: str, right: Value) -> Value:
        """Return the result of an operator."""
        return self._binary(left, Token("sign", sign, self._peek().at), right)

    def assigned(self, target: Tag, value: Value) -> str:
        """Return the assignment of a value to a variable."""
        text, data = target
        types = self._routine.types
        if types.is_string(data) and value[1] == "STRING":
            return f"{text} := {value[0]};"
        if not types.is_simple(data) or value[1] == "STRING":
            raise self._error(f"{text} is not a tag for a single number", self._peek())
        given = self._converted(value, data.type, self._peek())
        if data.stored:
            given = f"{data.type}_TO_{STORED[data.type]}({given})"
        return f"{text} := {bare(given)};"

    def bits(self, value: Value) -> Value:
        """Return an integer as DWORD or LWORD; a SINT or INT is filled with zeros."""
        text, kind = value
        if kind not in INTEGERS:
            raise self._error(f"a whole number is needed here, not {kind}", self._peek())
        if INTEGERS.index(kind) > INTEGERS.index("UDINT"):
            return f"{kind}_TO_LWORD({text})", "LWORD"
        literal = _LITERAL.fullmatch(text)
        if literal:
            number = int(f"{literal[1]}{literal[2]}") % (1 << 32)
            return f"DWORD#16#{number:X}", "DWORD"
        if narrow := _WIDENED.fullmatch(text):
            word = STORED[narrow[1]]
            inner = _FROM_BITS.fullmatch(narrow[2])
            plain = inner[2] if inner else f"{narrow[1]}_TO_{word}({narrow[2]})"
            return f"{word}_TO_DWORD({plain})", "DWORD"
        return f"{kind}_TO_DWORD({text})", "DWORD"

    def of_bits(self, value: Value) -> Value:
        """Return a DWORD or LWORD as an integer."""
        text, kind = value
        whole = {"DWORD": "DINT", "LWORD": "LINT"}[kind]
        return f"{kind}_TO_{whole}({bare(text)})", whole

    # --- expressions ----------------------------------------------------------------------

    def _binary(self, left: Value, token: Token, right: Value) -> Value:
        kinds = {left[1], right[1]}
        if kinds <= set(INTEGERS):
            if token.word in _BITWISE:
                sides = self.alike_bits(left, right)
                op = {"&": "AND"}.get(token.word, token.word)
                return self.of_bits((f"({sides[0][0]} {op} {sides[1][0]})", sides[0][1]))
            if token.word in ("/", "MOD") and not re.search("[1-9]", _number_of(right)):
                # A division by 0 gives the dividend, and the controller runs on.
                divisor, given = right
                zero = f"{bare(divisor)} = 0"
                if token.word == "/":
                    nonzero = f"SEL({zero}, {bare(divisor)}, 1)", given
                    return super()._binary(left, token, nonzero)
                text, kind = super()._binary(left, token, right)
                whole = self._converted(left, kind, token)
                return f"SEL({zero}, {bare(text)}, {bare(whole)})", kind
        elif token.word == "MOD" and kinds <= set(NUMBERS):
            kind = "LREAL" if "LREAL" in kinds else "REAL"
            whole, divisor = (self._converted(value, kind, token) for value in (left, right))
            cut = f"DINT_TO_{kind}(TRUNC({bare(whole)} / {divisor}))"
            return f"({whole} - {cut} * {divisor})", kind
        return super()._binary(left, token, right)

    def alike_bits(self, *values: Value) -> list[Value]:
        """Return integers as bit strings of one length."""
        found = [self.bits(value) for value in values]
        if all(kind == found[0][1] for _, kind in found):
            return found
        return [
            (text if kind == "LWORD" else f"DWORD_TO_LWORD({text})", "LWORD")
            for text, kind in found
        ]

    def _function(self) -> Value:
        token = self._peek()
        plain = _FUNCTIONS.get(token.word)
        if plain is not None:
            self._tokens = list(self._tokens)
            self._tokens[self._place] = replace(token, text=plain)
        return super()._function()


def _number_of(value: Value) -> str:
    text, kind = value
    return text if kind in NUMBERS and re.fullmatch(r"\(?-?\d+\)?", text) else ""
