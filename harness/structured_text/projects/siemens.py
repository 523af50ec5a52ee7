"""Siemens SCL: external sources of TIA Portal and STEP 7 (.scl, .udt, .db), as Structured Text.

The source is translated token by token, and each token remains in its line. Syntax that differs
(`#x`, `"Name"`, headers, DATA_BLOCK, ORGANIZATION_BLOCK, REGION, `+=`) becomes that of the
standard.
A construct without an equivalent is not changed, and the engine refuses it with its name and line.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.lexer import KEYWORDS
from structured_text.language.source import Line
from structured_text.output.limits import SOURCE
from structured_text.output.reading import file_bytes
from structured_text.projects.formats import SCL
from structured_text.projects.model import Piece, Project, Unit
from structured_text.projects.tasks import ToolTask, configuration

__all__ = ["called", "plain_name", "read_scl", "started"]

_TOKEN = re.compile(
    r"""(?P<comment>//[^\n]*|\(\*.*?(?:\*\)|\Z)|/\*.*?(?:\*/|\Z))
      | (?P<attribute>\{[^}]*(?:\}|\Z))
      | (?P<text>'(?:\$.|[^$'\n])*')
      | (?P<quoted>\#?"[^"\n]*")
      | (?P<local>\#[^\W\d]\w*)
      | (?P<literal>[A-Za-z_]+\#[\w.:+\-#]+|\d\w*(?:\#\w+)?(?:\.\d\w*)?)
      | (?P<direct>%[A-Za-z]+[\d.]+)
      | (?P<word>[^\W\d]\w*)
      | (?P<compound>[-+*/]=)
      | (?P<sign>:=|=>|<=|>=|<>|\*\*|\.\.|[^\s\w])
    """,
    re.VERBOSE | re.DOTALL,
)
_UNITS = {
    "FUNCTION_BLOCK": "FUNCTION_BLOCK",
    "FUNCTION": "FUNCTION",
    "ORGANIZATION_BLOCK": "PROGRAM",
    "TYPE": "TYPE",
    "DATA_BLOCK": "VAR_GLOBAL",
}
#: First words of header lines; such lines are ignored.
_HEADER = (
    *("TITLE", "VERSION", "AUTHOR", "FAMILY", "NAME", "KNOW_HOW_PROTECT", "CODE_VERSION1"),
    *("RETAIN", "NON_RETAIN", "UNLINKED", "READ_ONLY", "STANDARD", "S7_OPTIMIZED_ACCESS"),
)
_SECTIONS = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP")
_TITLE = re.compile(r"^([ \t]*TITLE[ \t]*=)[^\n]*", re.IGNORECASE | re.MULTILINE)
#: Blocks and types of Siemens that have another name in the standard.
_TYPES = {
    **{f"{name}_TIME": name for name in ("TON", "TOF", "TP")},
    **{f"{name}_LTIME": name for name in ("TON", "TOF", "TP")},
    **{f"{name}_INT": name for name in ("CTU", "CTD", "CTUD")},
}
#: Types of data blocks, with the blocks that can be called on them, as in `Timer.TON(...)`.
_GENERIC = {"IEC_TIMER": ("TON", "TOF", "TP"), "IEC_COUNTER": ("CTU", "CTD", "CTUD")}
_CALLED = tuple(name for names in _GENERIC.values() for name in names)
#: Kinds of tokens that can be names.
_NAMES = ("word", "local", "quoted")
_PREFIXES = {"B": "BYTE", "W": "WORD", "DW": "DWORD", "LW": "LWORD", "L": "DINT"}


@dataclass
class _Token:
    kind: str
    text: str
    start: int
    new: str | None = None

    @property
    def word(self) -> str:
        """Return the text of a word or sign in upper case; empty for any other token."""
        return self.text.upper() if self.kind in ("word", "sign") else ""


def plain_name(name: str) -> str:
    """Return a quoted name as a name of the standard; the result is the same in every file."""
    plain = re.sub(r"_+", "_", re.sub(r"\W", "_", name)).strip("_") or "Unnamed"
    if plain[0].isdigit():
        plain = f"N{plain}"
    return f"{plain}_1" if plain.upper() in KEYWORDS else plain


def called(files: Iterable[Path]) -> dict[str, str]:
    """Return the blocks that are called on data blocks, as in `"Timer".TON(...)`.

    The keys are the names of the data blocks in upper case. Raise InputError if a file cannot be
    read.
    """
    readers = [_Reader(_text(file), file) for file in files]
    return {name: word for one in readers for name, word in one.generic_calls(only_global=True)}


def read_scl(file: Path, calls: Mapping[str, str] | None = None) -> Project:
    """Read an external source, or raise InputError.

    `calls` are blocks that other files call on data blocks (see `called`).
    """
    content = file_bytes(file, SOURCE)
    reader = _Reader(_text(file), file, calls)
    units = tuple(reader.units())
    notes = [f"{file} is not UTF-8: it is read as Windows-1252"] if _is_narrow(content) else []
    return Project(units, (*notes, *reader.notes))


def _text(file: Path) -> str:
    return _TITLE.sub(r"\1", _decoded(file_bytes(file, SOURCE)))


def _is_narrow(content: bytes) -> bool:
    """Return whether a source has another encoding than UTF-8, or UTF-16 with a byte order mark."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return False
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return True
    return False


def _decoded(content: bytes) -> str:
    """Decode a source.

    TIA Portal writes UTF-8, or UTF-16 with a byte order mark; STEP 7 writes cp1252.
    """
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = content.decode("utf-16", errors="replace")
    elif _is_narrow(content):
        text = content.decode("cp1252", errors="replace")
    else:
        text = content.decode("utf-8-sig")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def started(units: Sequence[Unit]) -> Project:
    """Return a configuration that runs the main block if there are several organization blocks.

    A source does not contain the events that start its blocks. The other blocks get a note.
    """
    blocks = [unit for unit in units if unit.kind == "PROGRAM" and unit.file.suffix.lower() in SCL]
    main = [unit for unit in blocks if re.fullmatch(r"MAIN|OB_?1|CYCLE\w*", unit.name.upper())]
    if len(blocks) < 2 or len(main) != 1:
        return Project()
    one = main[0]
    at = one.piece.head[0].at
    task = ToolTask("", 0, None, ((one.name, one.name),), one.file, at)
    notes = tuple(
        f"{unit.file}:{unit.piece.head[0].at}: {unit.name} does not run: the source does "
        "not contain the event that starts it"
        for unit in blocks
        if unit is not one
    )
    return configuration([task]).plus(Project(notes=notes))


@dataclass
class _Data:
    """The initial values of a data block, nested by member like the structure."""

    values: dict[str, _Data | str] = field(default_factory=dict)

    def put(self, path: Sequence[str], value: str) -> None:
        """Set the initial value of the element that a path of names leads to."""
        first, *rest = path
        if not rest:
            self.values[first] = value
            return
        inner = self.values.setdefault(first, _Data())
        if isinstance(inner, _Data):
            inner.put(rest, value)

    def text(self) -> str:
        """Return the values as the initial value of a structure."""
        parts = (
            f"{name} := {value.text() if isinstance(value, _Data) else value}"
            for name, value in self.values.items()
        )
        return f"({', '.join(parts)})"


class _Reader:
    def __init__(self, text: str, file: Path, calls: Mapping[str, str] | None = None) -> None:
        self._text, self._file, self._calls = text, file, dict(calls or {})
        self._tokens = [
            _Token(str(found.lastgroup), found.group(), found.start())
            for found in _TOKEN.finditer(text)
        ]
        self._starts = [0, *(found.end() for found in re.finditer("\n", text))]
        #: Indices of the tokens that are not comments.
        self._code = [k for k, one in enumerate(self._tokens) if one.kind != "comment"]
        self.notes: list[str] = []

    def _line(self, token: _Token) -> int:
        return bisect_right(self._starts, token.start)

    def units(self) -> Iterator[Unit]:
        """Yield the translated blocks of the source, in their order."""
        self._calls.update(self.generic_calls())
        place = 0
        while place < len(self._code):
            token = self._at(place)
            if token.word not in _UNITS:
                if token.kind in ("attribute",) or token.text == ";":
                    place += 1
                    continue
                hint = f"begin the source with {', '.join(_UNITS)}"
                raise self._error(f"{token.text!r} is not expected here", token, hint)
            end = self._find(f"END_{token.word}", place, len(self._code))
            if end == len(self._code):
                raise self._error(f"this {token.word} has no END_{token.word}", token)
            yield self._unit(place, end)
            place = end + 1

    def _error(self, message: str, token: _Token, hint: str = "") -> InputError:
        return InputError(message, file=self._file, line=self._line(token), hint=hint)

    def _find(self, word: str, first: int, end: int) -> int:
        """Return the index of the first token with this word from `first` on.

        If there is no such token, return `end`.
        """
        return next((k for k in range(first, end) if self._at(k).word == word), end)

    def _at(self, place: int) -> _Token:
        return self._tokens[self._code[place]]

    def generic_calls(self, *, only_global: bool = False) -> Iterator[tuple[str, str]]:
        """Yield the variable and the called block of each `Timer.TON(...)`."""
        for place in range(len(self._code) - 3):
            name, dot, call, left = (self._at(place + k) for k in range(4))
            if dot.text == "." and left.text == "(" and call.word in _CALLED:
                dot.new = call.new = ""
                if name.text.startswith('"') or not only_global:
                    yield _named(name).upper(), call.word

    # --- one block ------------------------------------------------------------------------

    def _unit(self, start: int, end: int) -> Unit:
        first, last = self._at(start), self._at(end)
        word = first.word
        kind = _UNITS[word]
        if start + 1 >= end:
            raise self._error(f"this {word} has no name", first)
        name = _named(self._at(start + 1))
        place = self._header(start + 2, end, word)
        self._replace_constants(place, end)
        self._translate(place, end)
        self._at(start + 1).new = name
        if word == "TYPE":
            # `TYPE Name STRUCT` has no colon; the standard needs one
            if place < end and self._at(place).text != ":":
                self._at(start + 1).new = f"{name} :"
        elif word == "DATA_BLOCK":
            self._data_block(start, place, end, name)
        else:
            if (begin := self._find("BEGIN", place, end)) < end:
                self._at(begin).new = ""
            first.new, last.new = kind, f"END_{kind}"
        lines = self._lines(self._code[start], self._code[end])
        return Unit(kind, Piece(name, lines), self._file)

    def _replace_constants(self, place: int, end: int) -> None:
        """Replace the names of `CONST Name := value; … END_CONST` by their values.

        Such a constant has no type of its own; the type follows from its use. Raise InputError if a
        section has no end, or an entry has no value.
        """
        values: dict[str, str] = {}
        k = place
        while k < end:
            token = self._at(k)
            if token.word == "CONST" and self._at(k + 1).text not in (":", ":=", ".", ","):
                last = self._find("END_CONST", k, end)
                if last == end:
                    raise self._error("this CONST has no END_CONST", token)
                self._read_constants(k + 1, last, values)
                for one in range(k, last + 1):
                    self._at(one).new = ""
                k = last
            else:
                before, after = self._at(k - 1).text, self._at(k + 1).text
                named = after == ":=" and before in ("(", ",")
                value = values.get(_named(token).upper()) if token.kind in _NAMES else None
                if value is not None and before != "." and not named:
                    token.new = value
            k += 1

    def _read_constants(self, first: int, last: int, values: dict[str, str]) -> None:
        """Add the values of the constants between two tokens, by upper-case name."""
        entry: list[_Token] = []
        for k in range(first, last):
            token = self._at(k)
            if token.text != ";":
                entry.append(token)
                continue
            if len(entry) < 3 or entry[1].text != ":=" or entry[0].kind not in _NAMES:
                hint = "write Name := value;"
                raise self._error("a constant needs a name and a value", token, hint)
            for one in entry[2:]:
                known = values.get(_named(one).upper()) if one.kind in _NAMES else None
                if known is not None:
                    one.new = known
                else:
                    self._one(one, k, "", last)
            text = " ".join(_now(one) for one in entry[2:])
            # A CASE label takes no parentheses, so a signed number is inserted without them.
            plain = len(entry) == 3 or (len(entry) == 4 and entry[2].text == "-")
            values[_named(entry[0]).upper()] = text if plain else f"({text})"
            entry = []
        if entry:
            raise self._error("a ';' is missing", entry[-1])

    def _header(self, place: int, end: int, word: str) -> int:
        """Blank the header between a block's name and its variables; return the next index."""
        if word == "FUNCTION" and self._at(place).text == ":":
            result = self._at(place + 1)
            if result.word == "VOID":
                self._at(place).new = result.new = ""
            else:
                self._translate(place, place + 2)
            place += 2
        while place < end:
            token = self._at(place)
            if token.kind == "attribute":
                token.new = _blank(token.text)
                place += 1
            elif token.word in _HEADER:
                line = self._line(token)
                while place < end and self._line(self._at(place)) == line:
                    self._at(place).new = ""
                    place += 1
            else:
                break
        return place

    def _data_block(self, start: int, place: int, end: int, name: str) -> None:
        """Translate a data block to a global variable with its initial values.

        The variable is a structure, or has a named type or block as its type.
        """
        self._at(start).new = "VAR_GLOBAL"
        self._at(end).new = "END_VAR"
        begin = self._find("BEGIN", place, end)
        initial = self._initial_values(begin + 1, end)
        for k in range(begin, end):
            self._at(k).new = ""
        value = f" := {initial.text()}" if initial.values else ""
        parts = [self._at(k) for k in range(place, begin)]
        words = [one.word for one in parts]
        self._at(start + 1).new = f"{name} :"
        if "END_VAR" in words:
            opened = False
            for one, word in zip(parts, words, strict=True):
                if word in _SECTIONS:
                    one.new = "" if opened else "STRUCT"
                    opened = True
                elif word in ("RETAIN", "NON_RETAIN", "DB_SPECIFIC", "END_VAR"):
                    one.new = ""
            parts[len(words) - 1 - words[::-1].index("END_VAR")].new = f"END_STRUCT{value};"
        else:
            ends = [one for one in parts if one.text != ";" and one.kind != "attribute"]
            if not ends:
                raise self._error(f"the data block {name} has no type", self._at(start))
            for one in parts[parts.index(ends[-1]) + 1 :]:
                one.new = ""
            if len(ends) == 1:
                self._generic_type(ends[0], name)
            ends[-1].new = f"{_now(ends[-1])}{value};"

    def _initial_values(self, place: int, end: int) -> _Data:
        """Return the values of statements such as `a.b := 5;` in a data block.

        Values of array elements are omitted, with a note.
        """
        found = _Data()
        statement: list[_Token] = []
        for k in range(place, end):
            token = self._at(k)
            if token.text != ";":
                statement.append(token)
                continue
            texts = [one.text for one in statement]
            if ":=" in texts:
                target = statement[: texts.index(":=")]
                value = " ".join(_now(one) for one in statement[texts.index(":=") + 1 :])
                if "[" in texts[: len(target)]:
                    written = "".join(one.text for one in target)
                    self.notes.append(
                        f"{self._file}:{self._line(target[0])}: the initial value of {written} "
                        "is not read"
                    )
                elif target:
                    found.put([_now(one) for one in target if one.text != "."], value)
            statement = []
        return found

    # --- tokens ---------------------------------------------------------------------------

    def _translate(self, place: int, end: int) -> None:
        before = ""
        for k in range(place, end):
            token = self._at(k)
            if token.new is None:
                self._one(token, k, before, end)
            before = token.word or token.text

    def _one(self, token: _Token, place: int, before: str, end: int) -> None:
        after = self._at(place + 1).text if place + 1 < len(self._code) else ""
        if token.kind == "attribute":
            token.new = _blank(token.text)
        elif token.kind in ("quoted", "local"):
            if token.text.upper() == '"THIS"' and before == "." and after == "[":
                # In a data block that is an array, "THIS" stands for the array.
                self._at(place - 1).new = token.new = ""
                return
            token.new = _named(token)
        elif token.kind == "literal":
            prefix, mark, value = token.text.partition("#")
            if mark and prefix.upper() in _PREFIXES:
                token.new = f"{_PREFIXES[prefix.upper()]}#{value}"
        elif token.kind == "compound":
            self._compound(place, end)
        elif token.word == "DIV" and before not in ("VAR", ":", ".") and after not in (":", "("):
            token.new = "/"
        elif token.word in ("REGION", "END_REGION") and before != ".":
            self._region(token, place, end)
        elif token.word == ":" and before == "ELSE":
            token.new = ""
        elif before in (":", "OF"):
            self._generic_type(token, self._declared(place))

    def _generic_type(self, token: _Token, name: str) -> None:
        """Rename a Siemens block or type.

        A generic type is replaced by the block that is called on the variable.
        """
        if token.word in _TYPES:
            token.new = _TYPES[token.word]
        elif token.word in _GENERIC:
            token.new = self._calls.get(name.upper(), _GENERIC[token.word][0])

    def _declared(self, place: int) -> str:
        """Return the name of the variable whose type stands at this index."""
        while place > 0 and self._at(place).text != ":":
            place -= 1
        while place > 0 and self._at(place - 1).kind == "attribute":
            place -= 1
        return _named(self._at(place - 1))

    def _region(self, token: _Token, place: int, end: int) -> None:
        """Blank a region's title, which is free text up to the end of the line."""
        token.new = ""
        line = self._line(token)
        for k in range(place + 1, end):
            other = self._at(k)
            if self._line(other) != line or (token.word == "END_REGION" and other.text != ";"):
                break
            other.new = ""

    def _compound(self, place: int, end: int) -> None:
        """Translate `a += b;` to `a := a + (b);`."""
        token = self._at(place)
        first = place
        while (
            first > 0 and self._at(first - 1).kind in ("quoted", "local", "word", "literal")
        ) or (first > 0 and self._at(first - 1).text in (".", "[", "]", ",")):
            first -= 1
            if self._at(first).word in KEYWORDS:
                first += 1
                break
        target = " ".join(_now(self._at(k)) for k in range(first, place))
        token.new = f":= {target.replace(' . ', '.')} {token.text[0]} ("
        last = next((k for k in range(place, end) if self._at(k).text == ";"), None)
        if last is not None:
            self._at(last).new = ");"

    def _lines(self, first: int, last: int) -> tuple[Line, ...]:
        """Return the translated text of some tokens, each in its original line."""
        start = self._tokens[first].start
        parts = []
        behind = start
        for token in self._tokens[first : last + 1]:
            parts.append(self._text[behind : token.start])
            parts.append(_now(token))
            behind = token.start + len(token.text)
        at = self._line(self._tokens[first])
        texts = "".join(parts).split("\n")
        return tuple(Line(text.rstrip(), at + k) for k, text in enumerate(texts))


def _named(token: _Token) -> str:
    """Return the name in a token, without `#` and quotes."""
    text = token.text.removeprefix("#")
    return plain_name(text.strip('"')) if text.startswith('"') else text


def _now(token: _Token) -> str:
    return token.text if token.new is None else token.new


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", "", text)
