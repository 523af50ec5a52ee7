"""Files of STruC++'s unit tests, `TEST "name" ... END_TEST`, as suites of a framework.

Each test becomes a block with the variables and statements of SETUP, of the test and of TEARDOWN.
Programs of the sources become blocks, because tests declare and call them like blocks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import Extract, Line, source_text, title_of
from structured_text.projects.model import without_comments

__all__ = ["TestFiles", "is_test_file"]

_TEST = re.compile(r"^[ \t]*TEST\s+(?=['\"])", re.IGNORECASE | re.MULTILINE)
_HEAD = re.compile(
    r"\b(SETUP|TEARDOWN|TEST)\b\s*(?:\"([^\"\n]*)\"|'((?:\$.|[^'$\n])*)')?", re.IGNORECASE
)
_VARS = re.compile(r"\s*(VAR\w*\b.*?\bEND_VAR\b\s*;?)", re.IGNORECASE | re.DOTALL)
_CALL = re.compile(
    r"\b(ASSERT_\w+|ADVANCE_TIME|MOCK_VERIFY_CALLED|MOCK_VERIFY_CALL_COUNT)\s*\(", re.IGNORECASE
)
_MOCK = re.compile(r"\bMOCK\s+([A-Z_][\w.]*)\s*;", re.IGNORECASE)
_RETURNS = re.compile(r"\bMOCK_FUNCTION\s+(\w+)\s+RETURNS\s+", re.IGNORECASE)
_RESULT = r"\bFUNCTION\s+{name}\s*:\s*(\w+(?:\s*[\[(]\s*\d+\s*[\])])?)"
_COMPARED = {
    "EQ": ("=", ""),
    "NEQ": ("<>", "not "),
    "GT": (">", "> "),
    "LT": ("<", "< "),
    "GE": (">=", ">= "),
    "LE": ("<=", "<= "),
}
_LONGEST = 200
_PREFIX = "unittest_"


def is_test_file(file: Path) -> bool:
    """Return whether a source is a file with unit tests of STruC++ (TEST blocks)."""
    try:
        return bool(_TEST.search(without_comments(source_text(file))))
    except InputError:
        return False


@dataclass(frozen=True)
class _Words:
    """Names of the framework that translated tests use."""

    case: str
    counts: str
    fail: str
    text: str
    advance: str
    mock: str
    calls: str
    returns: str
    test: str
    finished: str
    run: str


@dataclass
class TestFiles:
    """The translation of all test files of a run.

    Attributes:
        case: The function block that translated tests extend.
        words: Names of the framework: counts, fail, text, advance, mock, calls, returns, test,
            finished, run.
    """

    __test__ = False

    case: str
    words: dict[str, str]

    def sources(self, own: Sequence[Path]) -> tuple[list[Path], dict[str, str]]:
        """Return all sources with translated tests, and the title of each instance of a test.

        Raises:
            InputError: A test file has an error.
        """
        word = _Words(self.case, **self.words)
        tests = [file for file in own if is_test_file(file)]
        if not tests:
            return list(own), {}
        others = [_with_blocks(file) for file in own if file not in tests]
        texts = [without_comments(source_text(file)) for file in others]
        made: list[Path] = []
        titles: dict[str, str] = {}
        for file in tests:
            for lines in _File(file, word, texts).cases():
                name = f"{_PREFIX}{len(titles) + 1}"
                kind = f"{name}_block"
                at = lines[0].at
                head = Line(f"FUNCTION_BLOCK {kind} EXTENDS {word.case}", at)
                made.append(Extract.make(file, (head, *lines), kind))
                titles[f"{_PREFIX}program.{name}"] = title_of(file)
        variables = "".join(
            f" {path.rpartition('.')[2]} : {path.rpartition('.')[2]}_block;" for path in titles
        )
        program = f"PROGRAM {_PREFIX}program VAR{variables} END_VAR {word.run}(); END_PROGRAM"
        made.append(Extract.make(tests[0], (Line(program, 1),), f"{_PREFIX}program"))
        return [*others, *made], titles


class _File:
    """A test file."""

    def __init__(self, file: Path, word: _Words, sources: Sequence[str]) -> None:
        self._file, self._word, self._sources = file, word, sources
        self._whole = source_text(file)
        self._code = _blanked(self._whole)
        self._mocks = 0

    def cases(self) -> Iterator[list[Line]]:
        """Yield the lines of each test, without the head of its block."""
        setup = teardown = ("", 0, "", 0)
        found: list[tuple[str, int, tuple[str, int, str, int]]] = []
        place = 0
        while (head := _HEAD.search(self._code, place)) is not None:
            kind = head[1].upper()
            end = re.compile(rf"\bEND_{kind}\b\s*;?", re.IGNORECASE).search(self._code, head.end())
            if end is None:
                raise self._error(f"this {kind} is never closed", head.start(), f"END_{kind}")
            parts = self._parts(head.end(), end.start())
            if kind == "TEST":
                given = _HEAD.match(self._whole, head.start())
                name = (given and (given[2] or given[3])) or ""
                if not name:
                    raise self._error("a TEST needs a name", head.start(), 'TEST "name"')
                found.append((name, head.start(), parts))
            elif kind == "SETUP":
                setup = parts
            else:
                teardown = parts
            place = end.end()
        for name, start, parts in found:
            self._mocks = 0
            yield self._case(name, start, setup, parts, teardown)

    def _parts(self, start: int, end: int) -> tuple[str, int, str, int]:
        """Return declarations and statements of SETUP, TEARDOWN or a test, with their offsets."""
        place = start
        while (found := _VARS.match(self._code, place, end)) is not None:
            place = found.end()
        return self._whole[start:place], start, self._whole[place:end], place

    def _case(
        self,
        name: str,
        start: int,
        setup: tuple[str, int, str, int],
        test: tuple[str, int, str, int],
        teardown: tuple[str, int, str, int],
    ) -> list[Line]:
        word, at = self._word, self._line(start)
        methods: list[Line] = []
        more: list[str] = []
        for title, part in (("Setup", setup), ("Body", test), ("Teardown", teardown)):
            methods.append(Line(f"METHOD {_PREFIX}{title}", at))
            methods += self._lines(self._statements(part[2], part[3], more), part[3])
            methods.append(Line("END_METHOD", at))
        lines = [Line("", at)]
        for part in (setup, test, teardown):
            lines += self._lines(part[0], part[1])
        if more:
            lines.append(Line(f"VAR {' '.join(more)} END_VAR", at))
        lines += methods
        lines.append(Line(f"{word.test}({_quoted(name)});", at))
        calls = "".join(f" {_PREFIX}{title}();" for title in ("Setup", "Body", "Teardown"))
        lines.append(Line(f"{calls} {word.finished}();", at))
        lines.append(Line("END_FUNCTION_BLOCK", at))
        return lines

    # --- statements ---

    def _statements(self, text: str, start: int, more: list[str]) -> str:
        """Return statements in which asserts and mocks use the framework's names."""
        word, made, place = self._word, "", 0
        code = _blanked(text)
        while True:
            matches = [
                one
                for one in (
                    _CALL.search(code, place),
                    _MOCK.search(code, place),
                    _RETURNS.search(code, place),
                )
                if one
            ]
            if not matches:
                return made + text[place:]
            found = min(matches, key=lambda one: one.start())
            made += text[place : found.start()]
            if found.re is _MOCK:
                made += f"{word.mock}({_quoted(found[1])});"
                place = found.end()
                continue
            closed = ";" if found.re is _RETURNS else ")"
            end = _end(code, found.end(), closed)
            if end < 0:
                raise self._error(f"this {found[1]} has no end", start + found.start(), closed)
            inner = text[found.end() : end]
            if found.re is _RETURNS:
                new = self._returns(found[1], inner, start + found.start(), more)
                end += 1
            else:
                arguments = [one.strip() for one in _split(inner)]
                new = self._call(found[1].upper(), arguments, start + found.start())
                end += 1
                rest = re.compile(r"\s*;").match(code, end)
                end = rest.end() if rest else end
            made += " ".join(new.split("\n")) + "\n" * text.count("\n", found.start(), end)
            place = end

    def _call(self, name: str, given: list[str], start: int) -> str:
        word = self._word
        if name == "ADVANCE_TIME" and len(given) == 1:
            return f"{word.advance}({word.text}({given[0]}));"
        if name == "MOCK_VERIFY_CALLED" and len(given) == 1:
            calls = f"{word.calls}({_quoted(given[0])})"
            return self._assert(f"{calls} > 0", "'a call'", "'none'", name, given, 1)
        if name == "MOCK_VERIFY_CALL_COUNT" and len(given) == 2:
            calls = f"{word.calls}({_quoted(given[0])})"
            texts = f"{word.text}({given[1]})", f"DINT_TO_STRING({calls})"
            return self._assert(f"{calls} = ({given[1]})", *texts, name, given, 2)
        kind = name.partition("_")[2]
        if kind in ("TRUE", "FALSE") and given:
            other = "FALSE" if kind == "TRUE" else "TRUE"
            condition = f"({given[0]}) = {kind}"
            return self._assert(condition, f"'{kind}'", f"'{other}'", name, given, 1)
        if kind in _COMPARED and len(given) >= 2:
            operator, said = _COMPARED[kind]
            expected = f"CONCAT('{said}', {word.text}({given[1]}))"
            condition = f"({given[0]}) {operator} ({given[1]})"
            return self._assert(condition, expected, f"{word.text}({given[0]})", name, given, 2)
        if kind == "NEAR" and len(given) >= 3:
            expected = f"CONCAT({word.text}({given[1]}), ' within {_quoted(given[2])[1:]})"
            condition = f"ABS(({given[0]}) - ({given[1]})) <= ({given[2]})"
            return self._assert(condition, expected, f"{word.text}({given[0]})", name, given, 3)
        raise self._error(f"{name} with {len(given)} arguments is not known", start, "")

    def _assert(
        self, condition: str, expected: str, actual: str, name: str, given: list[str], used: int
    ) -> str:
        word = self._word
        said = _plain(given[used]) if len(given) > used else f"{name}({', '.join(given)})"
        message = _quoted(said[:_LONGEST])
        return (
            f"{word.counts}(); IF NOT ({condition}) THEN "
            f"{word.fail}({expected}, {actual}, {message}); RETURN; END_IF;"
        )

    def _returns(self, name: str, value: str, start: int, more: list[str]) -> str:
        """Return the statements that let a function return a value."""
        pattern = re.compile(_RESULT.format(name=re.escape(name)), re.IGNORECASE)
        kinds = [found[1] for text in self._sources if (found := pattern.search(text))]
        if not kinds:
            raise self._error(f"there is no function {name}", start, "name its file, too")
        self._mocks += 1
        variable = f"{_PREFIX}result{self._mocks}"
        more.append(f"{variable} : {kinds[0]};")
        call = f"{self._word.returns}({_quoted(name)}, {_quoted(variable)});"
        return f"{variable} := {value.strip()}; {call}"

    # --- places ---

    def _line(self, place: int) -> int:
        return self._whole.count("\n", 0, place) + 1

    def _lines(self, text: str, place: int) -> list[Line]:
        first = self._line(place)
        return [Line(line, first + number) for number, line in enumerate(text.split("\n"))]

    def _error(self, message: str, place: int, hint: str) -> InputError:
        return InputError(message, file=self._file, line=self._line(place), hint=hint)


def _with_blocks(file: Path) -> Path:
    """Return a source with function blocks instead of programs, and without a configuration."""
    try:
        text = source_text(file)
    except InputError:
        return file
    code = _blanked(text)
    changes: list[tuple[int, int, str]] = []
    configurations = re.finditer(r"\bCONFIGURATION\b.*?\bEND_CONFIGURATION\b", code, re.I | re.S)
    for found in configurations:
        blank = re.sub(r"[^\n]", " ", found[0])
        for section in re.finditer(r"\bVAR_GLOBAL\b.*?\bEND_VAR\b", found[0], re.I | re.S):
            whole = text[found.start() + section.start() : found.start() + section.end()]
            blank = blank[: section.start()] + whole + blank[section.end() :]
        changes.append((found.start(), found.end(), blank))
    inside = [(start, end) for start, end, _ in changes]
    for found in re.finditer(r"\b(END_)?PROGRAM\b", code, re.IGNORECASE):
        if not any(start <= found.start() < end for start, end in inside):
            changes.append((found.start(), found.end(), f"{found[1] or ''}FUNCTION_BLOCK"))
    if not changes:
        return file
    for start, end, new in sorted(changes, reverse=True):
        text = text[:start] + new + text[end:]
    lines = tuple(Line(line, number) for number, line in enumerate(text.split("\n"), 1))
    return Extract.make(file, lines, title_of(file))


def _blanked(text: str) -> str:
    """Return the text with blanks in place of comments and of the contents of texts."""
    pattern = r"\(\*.*?(?:\*\)|\Z)|//[^\n]*|/\*.*?(?:\*/|\Z)|'(?:\$.|[^$'\n])*'|\"[^\"\n]*\""

    def blank(found: re.Match[str]) -> str:
        whole = found[0]
        if whole[0] in "'\"":
            return whole[0] + "x" * (len(whole) - 2) + whole[-1]
        return re.sub(r"[^\n]", " ", whole)

    return re.sub(pattern, blank, text, flags=re.DOTALL)


def _end(code: str, start: int, closed: str) -> int:
    """Return the offset of the bracket or semicolon that ends an argument list.

    The result is -1 if there is none.
    """
    depth = 0
    for place in range(start, len(code)):
        letter = code[place]
        if depth == 0 and letter == closed:
            return place
        depth += (letter in "([") - (letter in ")]")
    return -1


def _split(text: str) -> list[str]:
    """Return arguments that are separated by commas."""
    code, depth, parts, first = _blanked(text), 0, [], 0
    for place, letter in enumerate(code):
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and not depth:
            parts.append(text[first:place])
            first = place + 1
    return [*parts, text[first:]] if text.strip() else []


def _plain(text: str) -> str:
    """Return the content of a string literal."""
    return text[1:-1] if text[:1] in ("'", '"') else text


def _quoted(text: str) -> str:
    """Return a text as a string literal."""
    plain = " ".join(text.split())
    return "'" + plain.replace("$", "$$").replace("'", "$'") + "'"
