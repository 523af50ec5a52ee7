"""The lexer: splits text into tokens and records constructs that are not portable or not valid.

Three decisions need more than the characters of a token. First, many words are keywords only in
some places, so that programs may use them as names elsewhere; `words.Context` decides that.
Second, an LALR(1) parser cannot tell a CASE label from a statement, since both begin with a name.
The lexer looks ahead for `:`, `,` or `..` and yields LABEL instead of IDENT. Third, `S=`, `R=` and
`REF=` are one sign only behind something that can be assigned to.
"""

from __future__ import annotations

import re
import unicodedata
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lark import Token

from structured_text.errors import InputError
from structured_text.language.conditional import PRAGMA, ConditionError, Conditions
from structured_text.language.constructs import Use
from structured_text.language.source import origin
from structured_text.language.syntax import Name, Position
from structured_text.language.words import EXCEPTIONS, OBJECT_WORDS, Context, is_soft

__all__ = ["KEYWORDS", "PUNCTUATION", "Notes", "tokens"]

#: Words that open a construct. The construct ends with END_ and the same word.
_GROUPS = (
    *("ACTION", "CASE", "CONFIGURATION", "FOR", "FUNCTION", "FUNCTION_BLOCK", "IF", "PROGRAM"),
    *("REPEAT", "RESOURCE", "STRUCT", "TYPE", "UNION", "VAR", "WHILE"),
)
_SECTIONS = (
    *("CONFIG", "EXTERNAL", "GENERIC", "GLOBAL", "IN_OUT", "INPUT", "INST", "OUTPUT"),
    *("STAT", "TEMP"),
)
KEYWORDS = frozenset(
    (
        *_GROUPS,
        *(f"END_{word}" for word in _GROUPS),
        *(f"VAR_{word}" for word in _SECTIONS),
        *OBJECT_WORDS,
        *("AND", "AND_THEN", "ARRAY", "AT", "BY", "CONSTANT", "CONTINUE", "DO", "ELSE", "ELSIF"),
        *("EXIT", "FALSE", "MOD", "NON_RETAIN", "NOT", "OF", "ON", "OR", "OR_ELSE", "PERSISTENT"),
        *("RETAIN", "RETURN", "TASK", "THEN", "TO", "TRUE", "UNTIL", "WITH", "XOR"),
    )
)

PUNCTUATION = {
    ":=": "ASSIGN",
    "?=": "ATTEMPT",
    "=>": "SENDTO",
    "<=": "LE",
    ">=": "GE",
    "<>": "NE",
    "**": "POWER",
    "..": "DOTDOT",
    "+": "PLUS",
    "-": "MINUS",
    "*": "STAR",
    "/": "SLASH",
    "&": "AMPERSAND",
    "=": "EQ",
    "<": "LT",
    ">": "GT",
    "(": "LPAR",
    ")": "RPAR",
    "[": "LSQB",
    "]": "RSQB",
    ",": "COMMA",
    ";": "SEMICOLON",
    ":": "COLON",
    ".": "DOT",
    "^": "CARET",
}

#: CoDeSys 2.3 also accepts these keywords without the underscore.
_SPELLINGS = {"FUNCTIONBLOCK": "FUNCTION_BLOCK", "END_FUNCTIONBLOCK": "END_FUNCTION_BLOCK"}
#: Access specifiers that may also stand before types and programs.
_ACCESS = frozenset(("PUBLIC", "INTERNAL"))
#: Words that are keywords only inside a CONFIGURATION. Elsewhere they may be names of variables.
_OF_CONFIGURATIONS = frozenset(["ON", "RESOURCE", "TASK", "WITH", "END_RESOURCE"])
#: Words of the standard that some tools accept as names.
_RESERVED = frozenset(
    [*_OF_CONFIGURATIONS, "STEP", "TRANSITION", "FROM", "EN", "ENO", "R_EDGE", "F_EDGE", "ACTION"]
)

#: Words that belong to unsupported constructs, with the names of the constructs. The words may
#: still be used as names.
_UNSUPPORTED = {
    **dict.fromkeys(
        ("STEP", "INITIAL_STEP", "END_STEP", "TRANSITION", "END_TRANSITION"),
        "Sequential Function Chart",
    ),
    "VAR_ACCESS": "access paths",
    **dict.fromkeys(("JMP", "GOTO"), "jumps"),
}
#: Tokens that are followed by a name. A word behind such a token is not a keyword.
_BEFORE_NAMES = frozenset(
    (
        "DOT",
        "FUNCTION_BLOCK",
        "FUNCTION",
        "INTERFACE",
        "METHOD",
        "PROPERTY",
        "PROGRAM",
        "CLASS",
        "WORD",
    )
)
#: Matches the text behind a word of `_UNSUPPORTED` if the word is a keyword and not a variable.
_MEANT = re.compile(r"\s+(?!(?:AND|OR|XOR|MOD|THEN|DO|OF|TO|BY)\b)[A-Z_\x80-\uffff]", re.IGNORECASE)

#: Matches the text behind a word such as __TRY if the word is the name of a variable.
_DECLARED = re.compile(r"\s*[:.,=]")
_GIVEN = re.compile(r"\s*(?::=|=>)")
_DECIMAL = re.compile(r"(?:^|#[-+]?)10#")
#: Matches a token with the white space before it.
_PATTERN = re.compile(
    r"""\s*(?:
      (?P<TYPED>
          L?(?:T|TIME)\#[-+]?[\w.]+
        | L?(?:D|DATE|TOD|TIME_OF_DAY|DT|DATE_AND_TIME)\#[\d:.\-_]+
        | W?(?:CHAR|STRING)\#(?:'(?:\$.|[^$'\n])*'|"(?:\$.|[^$"\n])*")
        | [A-Z_]\w*\#[-+]?
          (?:\d+\#\w+|[ \t]+[A-Z_]\w*
          |\d[\d_]*(?:\.\d[\d_]*)?E[-+]?\d+|\d[\d_]*\.\d[\d_]*|\d\w*|[A-Z_]\w*)
      )
    | (?P<IDENT>[A-Z_]\w*)
    | (?P<comment>\(\*)
    | (?P<line_comment>//)
    | (?P<block_comment>/\*)
    | (?P<foreign>==|!=|=!|=<(?!=)|&&|\|\|?|!|[-+*/]=(?!>)|(?:\+\+|--)(?=\s*;))
    | (?P<punctuation>:=|\?=|=>|<=|>=|<>|\*\*|\.\.|[-+*/&=<>()\[\],;:.^])
    | (?P<REALNUM>\d[\d_]*(?:\.\d[\d_]*(?:E[-+]?\d+)?|E[-+]?\d+))
    | (?P<INTEGER>(?:2|8|10|16)\#\w+|\d[\d_]*)
    | (?P<STRING>'(?:\$.|[^$'\n])*'|"(?:\$.|[^$"\n])*")
    | (?P<PART>%[XBWDL]\d+(?!\.))
    | (?P<DIRECT>%[A-Z]*(?:[\d.]+|\*))
    | (?P<pragma>[{}])
    | (?P<hash>\#(?=[A-Z_\x80-\uffff]))
    | (?P<unknown>\S)
    )""",
    re.VERBOSE | re.IGNORECASE | re.ASCII,
)

#: Operators of C and other signs without a meaning in Structured Text, each with the operator that
#: is meant.
_OF_C = {"==": "=", "!=": "<>", "&&": "AND", "||": "OR", "|": "OR", "!": "NOT", "%": "MOD"}
_FOREIGN = {**_OF_C, "=!": "<>", "=<": "<="}
_MEANT_KINDS = frozenset((*(PUNCTUATION.get(one, one) for one in _FOREIGN.values()), "ASSIGN"))
#: Characters without a meaning in Structured Text, with the text to write instead.
_INSTEAD = {
    "#": "write a comment as // text or (* text *)",
    "?": "write IF, or SEL(condition, value if FALSE, value if TRUE)",
    "\\": "remove it",
}
#: Forms of numbers that Structured Text does not have: with a unit of time, and hexadecimal as in
#: C.
_DURATION = re.compile(r"\d[\d_.]*(?:d|h|m|s|ms|us|ns)\b", re.IGNORECASE)
_HEXADECIMAL = re.compile(r"0x([0-9a-f]+)\b", re.IGNORECASE)

#: Length of the longest legal name, and of the part of a longer name that a message shows
#: [characters].
_LONGEST_NAME, _SHOWN = 1_000, 40
#: A name with letters beyond ASCII, or a member behind the name of its enumeration.
_WIDE = re.compile(r"[^\W\d][\w\u0300-\u036f]*(?:#[^\W\d][\w\u0300-\u036f]*)?")
#: A text with line ends in it, and what may stand behind such a text. Without the second condition,
#: a text that is never closed would reach to the beginning of the next one.
_LINES = re.compile(
    r"""(?:'(?:\$.|[^$'])*'|"(?:\$.|[^$"])*")(?=\s*(?:[;,)\]:+=<>]|\Z))""", re.DOTALL
)
#: Matches C code in a pragma; a pragma of a tool has no such text.
_C_CODE = re.compile(r"__[SG]ET_|data__|#\s*(?:include|define)\b|->")
_ATTRIBUTE = re.compile(r"\s*(?:[\w.]+\s*:=\s*\S+.*)?", re.DOTALL)
_TEXTS = re.compile(r"'[^']*'|\"[^\"]*\"")
_LITERALS = ("TYPED", "INTEGER", "REALNUM", "STRING", "DIRECT", "PART")
#: Text behind the first name of a CASE label: members after dots, white space, comments, and then
#: `:` (but not `:=`), `,` or `..`.
_LABEL_FOLLOWS = re.compile(
    r"(?:\s*\.\s*\w+)*(?:\s|\(\*[^*]*(?:\*(?!\))[^*]*)*\*\))*(?::(?!=)|,|\.\.)"
)
#: Words that no CASE contains, so that a CASE without END_CASE ends in front of them.
_ENDS_OF_CASES = frozenset(
    (
        *("END_PROGRAM", "END_FUNCTION", "END_FUNCTION_BLOCK", "END_ACTION", "TYPE", "VAR"),
        *(f"VAR_{word}" for word in _SECTIONS),
    )
)
#: Tokens that may stand before a statement of a CASE, and so before a label.
_BEFORE_LABEL = frozenset(
    (
        *("SEMICOLON", "OF", "COLON"),
        *("END_IF", "END_CASE", "END_FOR", "END_WHILE", "END_REPEAT", "END_TRY"),
    )
)
#: Tokens that can end an assignment target. Behind these tokens `S=` is one sign.
_TARGET_ENDS = frozenset(("IDENT", "RSQB", "CARET", "INTEGER", "PART"))
_LATCH = re.compile(r"(?:S|R|REF)=(?!=)", re.IGNORECASE)
_NESTED = re.compile(r"\(\*|\*\)")
_OPENS = frozenset(("THEN", "ELSE", "DO", "OF", "REPEAT"))
_ENDS = frozenset(
    ("END_IF", "END_CASE", "END_FOR", "END_WHILE", "END_REPEAT", "END_STRUCT", "END_UNION")
)
#: Tokens behind which an END such as END_IF needs no semicolon.
_NO_STATEMENT = frozenset(("SEMICOLON", "ASSIGN"))


@dataclass
class Notes:
    """The results of the lexer in addition to tokens: constructs, pragmas and errors."""

    uses: list[Use] = field(default_factory=list)
    pragmas: list[Name] = field(default_factory=list)
    errors: list[InputError] = field(default_factory=list)


def tokens(text: str, file: Path, notes: Notes | None = None) -> Iterator[Token]:
    """Split a source into tokens.

    `notes` receives constructs, pragmas and errors; without it the first error is raised.

    Yields:
        Tokens of lark with line and column. An identifier that begins a CASE label is a
        LABEL, because only the text behind it distinguishes it from a statement.

    Raises:
        InputError: The text has characters without a meaning, and `notes` is None.
    """
    return _Lexer(text, file, notes).tokens()


class _Lexer:
    """A single pass over a source; `tokens` creates it."""

    def __init__(self, text: str, file: Path, notes: Notes | None) -> None:
        self._text, self._file = text, file
        self._notes = notes
        self._starts = [0, *(match.end() for match in re.finditer("\n", text))]
        self._cases = 0
        self._configuration = False
        self._previous = ""
        self._context = Context()
        self._condition = 0
        self._conditions = Conditions(
            lambda detail: self._note("conditional compilation", self._condition, detail)
        )

    def _at(self, offset: int) -> Position:
        line = bisect_right(self._starts, offset)
        return Position(*origin(self._file, line, offset - self._starts[line - 1] + 1))

    def _refuse(self, message: str, offset: int, hint: str = "") -> None:
        line, column = self._at(offset)
        error = InputError(message, file=self._file, line=line, column=column, hint=hint)
        if self._notes is None:
            raise error
        self._notes.errors.append(error)

    def _note(self, construct: str, offset: int, detail: str = "") -> None:
        if self._notes is not None:
            self._notes.uses.append(Use(construct, self._file, self._at(offset), detail))

    def tokens(self) -> Iterator[Token]:
        """Yield the tokens; see the function `tokens`."""
        text = self._text
        behind = 0
        while found := _PATTERN.match(text, behind):
            kind = str(found.lastgroup)
            offset, behind = found.span(kind)
            value = text[offset:behind]
            if text[behind : behind + 1] > "\x7f" or value > "\x7f":
                kind, value, behind = self._wide(kind, value, offset, behind)
            if kind == "unknown" and value in "'\"" and (lines := _LINES.match(text, offset)):
                self._note("a text over several lines", offset)
                kind, value, behind = "STRING", lines.group(), lines.end()
            if kind == "foreign" or (kind == "unknown" and value == "%"):
                kind, value = self._meant(value, offset)
                if not kind:
                    continue
            if kind == "punctuation":
                kind = PUNCTUATION[value]
            elif kind == "IDENT":
                if len(value) > _LONGEST_NAME:
                    text = f"this name has {len(value):,} characters: {value[:_SHOWN]}..."
                    self._refuse(text, offset, f"use at most {_LONGEST_NAME:,}")
                    value = value[:_SHOWN]
                word = value.upper()
                if word in _SPELLINGS:
                    self._note("a keyword in another spelling", offset)
                    value = word = _SPELLINGS[word]
                special = self._context.kind(word, self._previous, text, behind)
                if special:
                    kind = special
                elif word in KEYWORDS and word not in OBJECT_WORDS:
                    kind = self._keyword(word, behind)
                if self._is_access(word, behind):
                    self._note("an access specifier", offset)
                    continue
                if kind == "IDENT":
                    latch = self._previous in _TARGET_ENDS and _LATCH.match(text, offset)
                    if latch:
                        kind, behind = "LATCH", latch.end()
                        value = latch.group()
                    elif word in ("REGION", "END_REGION") and self._skips(behind):
                        self._note("a REGION", offset)
                        behind = text.find("\n", behind) if word == "REGION" else behind
                        if behind < 0:
                            return
                        continue
                    else:
                        kind = self._name(value, word, offset, behind)
            elif kind == "unknown" and value in "'\"":
                self._unknown(kind, value, offset)
                kind, behind = "STRING", self._line_end(offset)
                value = "''"
            elif kind not in _LITERALS and kind not in _MEANT_KINDS:
                behind = self._skipped(kind, value, offset, behind)
                if behind < 0:
                    return
                continue
            elif kind in ("INTEGER", "REALNUM"):
                if text[behind : behind + 1].isalnum():
                    self._refuse("this number is malformed", offset, self._number(offset))
                elif kind == "REALNUM" and "." not in value:
                    self._note("a number such as 1E3", offset)
            if kind in ("INTEGER", "TYPED") and _DECIMAL.search(value):
                self._note("a number with 10#", offset)
            if kind == "SEMICOLON":
                self._empty(offset)
            elif self._previous in _ENDS and kind not in _NO_STATEMENT:
                self._note("no ; after END", offset)
            at = self._at(offset)
            yield Token(kind, value, offset, at.line, at.column)
            self._previous = kind
        if self._conditions.unclosed is not None:
            hint = "write {END_IF} behind its branches"
            self._refuse("this {IF} has no {END_IF}", self._conditions.unclosed, hint)

    def _meant(self, value: str, offset: int) -> tuple[str, str]:
        """Report a sign of another language; return kind and text of the correct token."""
        text = f"{value} is not an operator of Structured Text"
        meant = _FOREIGN.get(value, "")
        if not meant:
            self._refuse(text, offset, f"write it as a := a {value[0]} 1")
            return ("ASSIGN", ":=") if value.endswith("=") else ("", "")
        if value in _OF_C:
            text = f"{value} is an operator of C"
        self._refuse(text, offset, f"write {meant}{' to compare' if value == '==' else ''}")
        return PUNCTUATION.get(meant, meant), meant

    def _number(self, offset: int) -> str:
        """Return the hint for a number with letters behind it."""
        if found := _DURATION.match(self._text, offset):
            return f"write the duration as T#{found[0]}"
        if found := _HEXADECIMAL.match(self._text, offset):
            return f"write it as 16#{found[1]}"
        return "write reals as 1.0E3, hexadecimal as 16#FF"

    def _wide(self, kind: str, value: str, offset: int, behind: int) -> tuple[str, str, int]:
        """Return kind, text and end of a token that may be a name with letters beyond ASCII.

        The text is normalised, because one letter can have several codes, and Python, which runs
        the program, does not distinguish them.
        """
        found = _WIDE.match(self._text, offset) if kind in ("IDENT", "TYPED", "unknown") else None
        if found is None or (found.end() <= behind and kind != "unknown"):
            return kind, value, behind
        name = unicodedata.normalize("NFKC", found.group())
        if not all(part.isidentifier() for part in name.split("#")):
            return kind, value, behind
        self._note("a name with letters beyond ASCII", offset)
        return ("TYPED" if "#" in name else "IDENT"), name, found.end()

    def _is_access(self, word: str, behind: int) -> bool:
        """Return whether the word is PUBLIC or INTERNAL before a type or program."""
        if word not in _ACCESS or self._previous not in ("TYPE", "PROGRAM"):
            return False
        return re.match(r"\s+[A-Za-z_\x80-\uffff]", self._text[behind : behind + 40]) is not None

    def _line_end(self, offset: int) -> int:
        line = bisect_right(self._starts, offset)
        return self._starts[line] - 1 if line < len(self._starts) else len(self._text)

    def _keyword(self, word: str, behind: int) -> str:
        """Return the kind of a word that can be a keyword: the word itself, or IDENT."""
        if word in _OF_CONFIGURATIONS and not self._configuration:
            return "IDENT"
        if self._previous == "DOT" and not self._begins_line(behind - len(word)):
            return "IDENT"
        if is_soft(word, self._previous, self._text, behind):
            return "IDENT"
        if word == "CASE":
            self._cases += 1
        elif word == "END_CASE":
            self._cases -= 1
        elif word in _ENDS_OF_CASES:
            self._cases = 0
        elif word == "CONFIGURATION":
            self._configuration = True
        elif word == "END_CONFIGURATION":
            self._configuration = False
        return word

    def _begins_line(self, offset: int) -> bool:
        """Return whether only white space is before an offset in its line.

        A keyword that begins a line behind `Name.` is not a member: somebody is typing the member.
        """
        line = bisect_right(self._starts, offset)
        return not self._text[self._starts[line - 1] : offset].strip()

    def _name(self, value: str, word: str, offset: int, behind: int) -> str:
        """Return the kind of an identifier: LABEL at the beginning of a CASE label, else IDENT."""
        named = self._previous in _BEFORE_NAMES
        if word in EXCEPTIONS and not named and not _DECLARED.match(self._text, behind):
            return EXCEPTIONS[word]
        if word in _UNSUPPORTED and not named and _MEANT.match(self._text, behind):
            self._refuse(f"{word} is not supported ({_UNSUPPORTED[word]})", offset)
        elif word in ("R_EDGE", "F_EDGE") and self._previous == "IDENT":
            self._refuse(f"{word} is not supported (edge qualifiers)", offset, "use an R_TRIG")
        if "__" in word or word.endswith("_"):
            self._note("a name with __ or _ at its end", offset)
        elif word in ("EN", "ENO") and _GIVEN.match(self._text, behind):
            pass  # here EN and ENO are pins of a call, which the checker notes
        elif word in _RESERVED or word in KEYWORDS - OBJECT_WORDS:
            self._note("a reserved word as a name", offset)
        if self._cases and self._previous in _BEFORE_LABEL:
            return "LABEL" if _LABEL_FOLLOWS.match(self._text, behind) else "IDENT"
        return "IDENT"

    def _skips(self, behind: int) -> bool:
        """Return whether REGION opens a region here and is not a name."""
        rest = self._text[behind : behind + 40].lstrip(" \t")
        return self._previous != "DOT" and not rest.startswith((":", ".", ",", ")", "(", "="))

    def _empty(self, offset: int) -> None:
        """Note a semicolon that does not end a statement."""
        if self._previous in _OPENS or self._previous in ("SEMICOLON", "COLON", "", "END_VAR"):
            self._note("an empty statement", offset)

    def _skipped(self, kind: str, value: str, offset: int, behind: int) -> int:
        """Return the offset behind a comment, pragma or other text that is not a token.

        The result is -1 at the end of the text.
        """
        text = self._text
        if kind == "comment":
            return self._behind_comment(offset)
        if kind == "line_comment":
            self._note("a comment with // or /* */", offset)
            return text.find("\n", offset)
        if kind == "block_comment":
            self._note("a comment with // or /* */", offset, "/* */")
            end = text.find("*/", offset + 2)
            if end < 0:
                self._refuse("this comment is never closed", offset, "end it with */")
            return end + 2 if end >= 0 else -1
        if kind == "pragma" and value == "{":
            return self._behind_pragma(offset)
        if kind == "hash":
            self._note("# before a name", offset)
            return behind
        self._unknown(kind, value, offset)
        return behind

    def _behind_comment(self, offset: int) -> int:
        """Return the offset behind a comment and the comments inside it."""
        end = self._text.find("*)", offset + 2)
        if end < 0:
            self._refuse("this comment is never closed", offset, "end it with *)")
            return -1
        nested = self._text.find("(*", offset + 2, end)
        if nested < 0:
            return end + 2
        self._note("a comment inside a comment", nested)
        depth = 1
        for mark in _NESTED.finditer(self._text, offset + 2):
            depth += 1 if mark.group() == "(*" else -1
            if not depth:
                return mark.end()
        return end + 2  # some tools do not nest comments: there the first `*)` ends the comment

    def _behind_pragma(self, offset: int) -> int:
        if self._text.startswith("{{", offset):
            end = self._text.find("}}", offset)
            self._refuse("C code in a pragma is not supported", offset, "write Structured Text")
            return end + 2 if end > 0 else -1
        end = self._text.find("}", offset)
        if end < 0:
            self._refuse("this pragma is never closed", offset, "end it with }")
            return -1
        said = self._text[offset + 1 : end].strip()
        if _is_c_code(said):
            self._refuse("C code in a pragma is not supported", offset, "write Structured Text")
            return end + 1
        self._note("a pragma", offset)
        if conditional := PRAGMA.fullmatch(said):
            return self._behind_condition(conditional[1], conditional[2], offset, end + 1)
        if self._notes is not None:
            self._notes.pragmas.append(Name(said, self._at(offset)))
        return end + 1

    def _behind_condition(self, word: str, rest: str, offset: int, end: int) -> int:
        """Return the offset behind a pragma of conditional compilation and the text it excludes."""
        if word.upper() == "IF":
            self._note("conditional compilation", offset)
        self._condition = offset
        try:
            return self._conditions.behind(word, rest, offset, end, self._text)
        except ConditionError as error:
            self._refuse(str(error), offset, error.hint)
            return end

    def _unknown(self, kind: str, value: str, offset: int) -> None:
        """Report characters that do not begin any token."""
        if kind == "pragma":
            self._refuse("this } has no opening {", offset, "remove it")
        elif value in ("'", '"'):
            hint = f"end it with {value} on the same line"
            self._refuse("this string is never closed", offset, hint)
        else:
            hint = _INSTEAD.get(value, "")
            self._refuse(f"the character {value!r} has no meaning here", offset, hint)


def _is_c_code(said: str) -> bool:
    """Return whether a pragma contains C code, which a tool would compile into the program.

    A pragma of a tool is a word with texts, or a list of attributes such as `A := 'x'; B := 'y'`.
    """
    plain = _TEXTS.sub("''", said)
    if _C_CODE.search(plain):
        return True
    return ";" in plain and not all(_ATTRIBUTE.fullmatch(part) for part in plain.split(";"))
