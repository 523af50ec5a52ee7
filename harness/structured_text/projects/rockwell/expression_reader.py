"""Translation of Logix values, tags and conversions to the standard's language.

Logix converts implicitly between its types. The translation writes each conversion, as the Logix
manual describes it: integers are calculated as DINT or longer, a REAL is rounded to an integer, and
AND, OR, XOR and NOT of integers are bitwise.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from structured_text.errors import VARIABLES, InputError
from structured_text.language.lexer import KEYWORDS
from structured_text.language.source import Line
from structured_text.projects.rockwell.data import (
    INTEGERS,
    NUMBERS,
    STORED,
    Data,
    First,
    Subroutine,
    Types,
)

__all__ = [
    "COUNTER",
    "FIRST_SCAN",
    "ExpressionReader",
    "Routine",
    "Token",
    "Value",
    "bare",
    "plain_tag",
    "tokens_of",
]

#: Names of helper variables that the translated statements may need.
COUNTER, FIRST_SCAN = f"{VARIABLES}Index", f"{VARIABLES}FirstScan"

_TOKEN = re.compile(
    r"""(?P<skip>\s+|//[^\n]*|\(\*.*?(?:\*\)|\Z)|/\*.*?(?:\*/|\Z)|\#(?:end)?region[^\n]*)
      | (?P<number>(?:2|8|16)\#[0-9A-F_]+|\d[\d_]*(?:\.\d+)?(?:E[-+]?\d+)?
          | (?<![\w\]).])\.\d+(?:E[-+]?\d+)?)
      | (?P<text>'(?:\$.|[^$'\n])*')
      | (?P<name>\\?[^\W\d]\w*(?::\w+)*)
      | (?P<sign>\[:=\]|:=|<=|>=|<>|\*\*|\.\.|[-+*/&=<>()\[\],;:.?])
      | (?P<unknown>.)
    """,
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)
#: Greatest length of a number; a LWORD in binary and any real are shorter.
_LONGEST_NUMBER = 80
_REALS = ("SQRT", "LN", "LOG", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "EXP")
_SCALED = {"DEG": "57.2957795", "RAD": "0.0174532925"}
_RANKS: tuple[tuple[str, ...], ...] = (
    ("OR",),
    ("XOR",),
    ("AND", "&"),
    ("=", "<>"),
    ("<", ">", "<=", ">="),
    ("+", "-"),
    ("*", "/", "MOD"),
)
_BITS = {"DINT": "DWORD", "UDINT": "DWORD", "LINT": "LWORD", "ULINT": "LWORD"}


@dataclass(frozen=True)
class Token:
    """A word, number, text or sign of a routine, and its line in the file."""

    kind: str
    text: str
    at: int

    @property
    def word(self) -> str:
        """Return the text in upper case; empty for a number or a text."""
        return self.text.upper() if self.kind in ("name", "sign") else ""


@dataclass
class Routine:
    """The scope of a routine: the meaning of its names.

    Attributes:
        file: The file, for messages.
        types: The types of the project.
        tags: Tags of the routine's program or instruction and of the controller, in upper case.
        aliases: Alias tags, each with its target.
        routines: Routines that JSR can call, in upper case, with their names.
        needs: Additional declarations: COUNTER, FIRST_SCAN, and the names of helper blocks.
        subroutines: The parameters of the routines that JSR can call.
        own: The parameters of the routine itself.
        added: Variables that the translation adds to the program or instruction, with their types.
        notes: What a user may miss in Structured Text, each with its line.
        first: The prescan of each routine, by the routine's name in upper case.
        cleared: Statements for tags left of `[:=]` in the routine that is read; the prescan clears
            them.
    """

    file: Path
    types: Types
    tags: Mapping[str, Data]
    aliases: Mapping[str, str]
    routines: Mapping[str, str]
    needs: set[str] = field(default_factory=set)
    subroutines: Mapping[str, Subroutine] = field(default_factory=dict)
    own: Subroutine | None = None
    added: dict[str, str] = field(default_factory=dict)
    first: dict[str, Sequence[First]] = field(default_factory=dict)
    notes: list[tuple[int, str]] = field(default_factory=list)
    cleared: list[str] = field(default_factory=list)

    def take_cleared(self) -> list[str]:
        """Return the statements in `cleared`, and remove them."""
        found = list(dict.fromkeys(self.cleared))
        self.cleared.clear()
        return found


def plain_tag(name: str) -> str:
    """Return the name of a tag in the standard: Local_1_I for `Local:1:I`, TASK_1 for `TASK`."""
    plain = name.replace(":", "_").lstrip("\\")
    return f"{plain}_1" if plain.upper() in KEYWORDS else plain


Value = tuple[str, str]
"""The text of a translated expression, and its type. Integers have the type DINT or a longer type.
"""


class ExpressionReader:
    """The reader of values, tags and conversions from the tokens of a routine."""

    def __init__(self, tokens: Sequence[Token], last: int, routine: Routine) -> None:
        self._tokens = tokens
        self._end = Token("end", "", last)
        self._place = 0
        self._routine = routine
        #: The indices that are not numbers, each with the size of its dimension.
        self.ranges: list[tuple[str, int]] = []

    # --- tokens ---------------------------------------------------------------------------

    def _peek(self, ahead: int = 0) -> Token:
        place = self._place + ahead
        return self._tokens[place] if place < len(self._tokens) else self._end

    def _next(self) -> Token:
        token = self._peek()
        self._place += 1
        return token

    def _take(self, word: str) -> bool:
        if self._peek().word == word:
            self._place += 1
            return True
        return False

    def _expect(self, word: str) -> None:
        token = self._peek()
        if not self._take(word):
            found = repr(token.text) if token.text else "the end"
            raise self._error(f"{word} is expected, not {found}", token)

    def _error(self, message: str, token: Token, hint: str = "") -> InputError:
        return InputError(message, file=self._routine.file, line=token.at, hint=hint)

    # --- expressions ----------------------------------------------------------------------

    def _condition(self) -> str:
        token = self._peek()
        text, kind = self._value()
        if kind != "BOOL":
            raise self._error(f"a condition must be BOOL, not {kind}", token)
        return bare(text)

    def _whole(self, value: Value) -> str:
        text, kind = value
        if kind not in INTEGERS:
            raise self._error(f"a whole number is needed, not {kind}", self._peek())
        return text

    def _value(self, rank: int = 0) -> Value:
        if rank == len(_RANKS):
            return self._unary()
        left = self._value(rank + 1)
        while self._peek().word in _RANKS[rank]:
            token = self._next()
            left = self._binary(left, token, self._value(rank + 1))
        return left

    def _binary(self, left: Value, token: Token, right: Value) -> Value:
        op = {"&": "AND"}.get(token.word, token.word)
        left, right = self._flags(left, right), self._flags(right, left)
        kinds = {left[1], right[1]}
        compares = op in ("=", "<>", "<", ">", "<=", ">=")
        if op in ("AND", "OR", "XOR"):
            if kinds == {"BOOL"}:
                return f"({left[0]} {op} {right[0]})", "BOOL"
            if kinds <= set(INTEGERS):
                kind = _common(left[1], right[1])
                bits = _BITS[kind]
                sides = [f"{kind}_TO_{bits}({_as(one, kind)})" for one in (left, right)]
                return f"{bits}_TO_{kind}({sides[0]} {op} {sides[1]})", kind
        elif compares and kinds in ({"BOOL"}, {"STRING"}):
            return f"({left[0]} {op} {right[0]})", "BOOL"
        elif kinds <= set(NUMBERS):
            kind = _common(left[1], right[1])
            if op == "MOD" and kind in ("REAL", "LREAL"):
                raise self._error("MOD of REAL is not supported", token)
            text = f"({_as(left, kind)} {op} {_as(right, kind)})"
            return text, "BOOL" if compares else kind
        raise self._error(f"{left[1]} {token.text} {right[1]} is not possible", token)

    def _flags(self, one: Value, other: Value) -> Value:
        """Replace a literal 0 or 1 by FALSE or TRUE if the other operand is BOOL."""
        if other[1] == "BOOL" and one in (("0", "DINT"), ("1", "DINT")):
            return ("TRUE" if one[0] == "1" else "FALSE"), "BOOL"
        return one

    def _unary(self) -> Value:
        token = self._peek()
        if self._take("NOT"):
            text, kind = self._unary()
            if kind == "BOOL":
                return f"NOT ({text})", "BOOL"
            if kind in INTEGERS:
                bits = _BITS[kind]
                return f"{bits}_TO_{kind}(NOT {kind}_TO_{bits}({text}))", kind
            raise self._error(f"NOT of {kind} is not possible", token)
        if self._take("-"):
            text, kind = self._unary()
            if kind not in NUMBERS:
                raise self._error(f"- of {kind} is not possible", token)
            return f"(-{text})", kind
        self._take("+")
        return self._power()

    def _power(self) -> Value:
        """Read operators `**`, which bind more tightly than a sign.

        Source: 1756-PM007, order of execution.
        """
        left = self._primary()
        while self._take("**"):
            right = self._unary() if self._peek().word in ("-", "+", "NOT") else self._primary()
            left = f"({_as(left, 'REAL')} ** {_as(right, 'REAL')})", "REAL"
        return left

    def _primary(self) -> Value:
        token = self._peek()
        if self._take("("):
            value = self._value()  # a compound value already has parentheses
            self._expect(")")
            return value
        if token.kind == "number":
            return _number(self._next().text, token, self._routine.file)
        if token.kind == "text":
            return self._next().text, "STRING"
        if token.kind != "name" or self._is_keyword(token):
            if token.word in ("TRUE", "FALSE"):
                return self._next().word, "BOOL"
            found = repr(token.text) if token.text else "the end"
            raise self._error(f"a value is expected, not {found}", token)
        if self._peek(1).text == "(":
            return self._function()
        text, data = self._variable()
        return self._read(text, data, token)

    def _read(self, text: str, data: Data, token: Token) -> Value:
        types = self._routine.types
        if types.is_string(data):
            return text, "STRING"
        if not types.is_simple(data):
            raise self._error(f"{text} is not a single value", token)
        kind = data.type
        if data.stored:
            text = f"{STORED[kind]}_TO_{kind}({text})"
        if kind in INTEGERS and INTEGERS.index(kind) < INTEGERS.index("DINT"):
            return f"{kind}_TO_DINT({text})", "DINT"
        return text, kind

    def _function(self) -> Value:
        token = self._next()
        self._expect("(")
        name = token.word
        value = self._value()
        self._expect(")")
        if name == "ABS" and value[1] in NUMBERS:
            return f"ABS({value[0]})", value[1]
        if name in ("TRUNC", "TRN") and value[1] in ("REAL", "LREAL"):
            return f"TRUNC({value[0]})", "DINT"
        if value[1] in NUMBERS:
            kind = "LREAL" if value[1] == "LREAL" else "REAL"
            if name in _REALS:
                return f"{name}({_as(value, kind)})", kind
            if name in _SCALED:
                return f"({_as(value, kind)} * {_SCALED[name]})", kind
        raise self._error(f"the function {token.text} of {value[1]} is not supported", token)

    # --- tags -----------------------------------------------------------------------------

    def _variable(self, *, written: bool = False, element: bool = True) -> tuple[str, Data]:
        """Read a tag with its members, elements and bits.

        If `element` is False, the last index is not read.
        """
        token = self._next()
        if token.kind != "name" or self._is_keyword(token):
            raise self._error(f"a tag is needed here, not {token.text!r}", token)
        routine = self._routine
        if token.word == "S:FS":
            routine.needs.add(FIRST_SCAN)
            return FIRST_SCAN, Data("BOOL")
        alias = routine.aliases.get(token.word)
        if alias is not None:
            inner = ExpressionReader(tokens_of([Line(alias, token.at)]), token.at, routine)
            text, data = inner._variable()
        else:
            found = routine.tags.get(token.word)
            if found is None:
                raise self._error(
                    f"there is no tag {token.text} in this file",
                    token,
                    "export the whole controller with decorated data, which describe the tags of "
                    "modules"
                    if ":" in token.text
                    else "",
                )
            text, data = plain_tag(token.text), found
        while self._peek().text in (".", "["):
            if self._peek().text == "[":
                if not data.sizes:
                    raise self._error(f"{text} is not an array", token)
                if not element and self._ends_with_index():
                    break
                text, data = self._indexed(text, data, token)
            else:
                self._next()
                text, data = self._member(text, data, token)
                if written and text.startswith("LEN("):
                    raise self._error("the length of a text cannot be set", token)
        return text, data

    def _is_keyword(self, token: Token) -> bool:
        """Return whether a name is a word of the standard, and no tag has this name."""
        routine = self._routine
        known = token.word in routine.tags or token.word in routine.aliases
        return token.word in KEYWORDS and not known

    def _ends_with_index(self) -> bool:
        """Return whether nothing follows the next index of a tag."""
        depth, ahead = 0, 0
        while self._peek(ahead).kind != "end":
            depth += {"[": 1, "]": -1}.get(self._peek(ahead).text, 0)
            ahead += 1
            if not depth:
                break
        return self._peek(ahead).text not in (".", "[")

    def _indexed(self, text: str, data: Data, token: Token) -> tuple[str, Data]:
        self._expect("[")
        indices = [self._whole(self._value())]
        while self._take(","):
            indices.append(self._whole(self._value()))
        self._expect("]")
        if len(indices) != len(data.sizes):
            raise self._error(f"{text} has {len(data.sizes)} dimensions", token)
        pairs = zip(indices, data.sizes, strict=True)
        self.ranges += [(index, size) for index, size in pairs if not index.isdigit()]
        return f"{text}[{', '.join(indices)}]", data.element

    def _member(self, text: str, data: Data, token: Token) -> tuple[str, Data]:
        name = self._next()
        types = self._routine.types
        if name.kind == "number" and data.type in INTEGERS and not data.sizes:
            return f"{text}.{name.text}", Data("BOOL")
        if types.is_string(data):
            if name.word == "LEN":
                return f"LEN({text})", Data("INT")
            raise self._error(f".{name.text} of a text is not supported", token)
        member = types.members.get(data.type.upper(), {}).get(name.word)
        if member is None or data.sizes:
            raise self._error(f"{text} has no member {name.text}", token)
        return f"{text}.{plain_tag(name.text)}", member

    # --- conversions ----------------------------------------------------------------------

    def _converted(self, value: Value, kind: str, token: Token) -> str:
        """Return a value converted to the type of a tag."""
        text, given = self._flags(value, ("", kind))
        if given == kind:
            return text
        same = re.fullmatch(rf"{kind}_TO_DINT\(([\w.]+)\)", text)
        if same:  # the value was only widened to DINT, so the conversion back changes nothing
            return same[1]
        if {given, kind} <= set(NUMBERS):
            literal = given == "DINT" and re.fullmatch(r"\d+", text)
            if literal and kind in INTEGERS and int(text) < 128:
                return text
            if literal and kind in ("REAL", "LREAL"):
                return f"{text}.0"
            return f"{given}_TO_{kind}({text})"
        raise self._error(f"{given} is not a value for {kind}", token)


def bare(text: str) -> str:
    """Return an expression without the parentheses that enclose all of it."""
    if not text.startswith("("):
        return text
    depth = 0
    for place, sign in enumerate(text):
        depth += {"(": 1, ")": -1}.get(sign, 0)
        if not depth:
            return text[1:-1] if place == len(text) - 1 else text
    return text


def tokens_of(lines: Sequence[Line]) -> list[Token]:
    """Return the tokens of some lines, without comments."""
    text = "\n".join(line.text for line in lines)
    found, number, behind = [], 0, 0
    for one in _TOKEN.finditer(text):
        if one.lastgroup != "skip":
            number += text.count("\n", behind, one.start())
            behind = one.start()
            found.append(Token(str(one.lastgroup), one.group(), lines[number].at))
    return found


def _common(one: str, other: str) -> str:
    """Return the type in which two numbers are calculated."""
    return max(one, other, "DINT", key=NUMBERS.index)


def _as(value: Value, kind: str) -> str:
    text, given = value
    if given == kind:
        return text
    if given == "DINT" and kind in ("REAL", "LREAL") and re.fullmatch(r"\d+", text):
        return f"{text}.0"
    return f"{given}_TO_{kind}({text})"


def _number(text: str, token: Token, file: Path) -> Value:
    plain = f"{'0' if text.startswith('.') else ''}{text.replace('_', '')}"
    if len(plain) > _LONGEST_NUMBER:
        shown = f"a number of {len(plain)} characters: {plain[:20]}..."
        raise InputError(shown, file=file, line=token.at, hint="write a value that a type can hold")
    if "#" in plain:
        base, _, digits = plain.partition("#")
        try:
            value = int(digits, int(base))
        except ValueError:
            raise InputError(f"{text} is not a number", file=file, line=token.at) from None
        if value >= 1 << 32:
            return f"LWORD_TO_LINT(LWORD#16#{value:X})", "LINT"
        if value >= 1 << 31:
            return f"DWORD_TO_DINT(DWORD#16#{value:X})", "DINT"
        return str(value), "DINT"
    if "." in plain or "e" in plain.lower():
        return (plain if "." in plain else re.sub("[eE]", ".0E", plain)), "REAL"
    if int(plain) >= 1 << 63:
        return plain, "ULINT"
    return plain, "LINT" if int(plain) >= 1 << 31 else "DINT"
