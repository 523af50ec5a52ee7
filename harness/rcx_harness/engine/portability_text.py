"""The portability rules that show in the text itself: spelling and layout."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from rcx_harness.engine.frontend.lexer import KEYWORDS, tokens
from rcx_harness.engine.frontend.syntax import Position

__all__ = ["text_findings"]

_LONGEST = 100
#: One text, in which every byte may be an escape as `$E3`: no place to break the line.
#: Escapes of quotes, at which some compilers take the text to have ended; `$$` is none.
_QUOTE = re.compile(r"\$(?:([\'\"])|.)")
_ONE_TEXT = re.compile(r"\s*[\w.]+ := '(?:\$[0-9A-F]{2}|[^$'])+';")


def text_findings(file: Path) -> Iterator[tuple[Position, str]]:
    """Check lines and tokens of a file that has no syntax error."""
    text = file.read_text(encoding="utf-8-sig")
    for number, line in enumerate(text.splitlines(), start=1):
        if "\t" in line:
            yield Position(number, line.index("\t") + 1), "a tab; indent with two spaces"
        if len(line) > _LONGEST and not _ONE_TEXT.fullmatch(line):
            yield Position(number, _LONGEST + 1), f"longer than {_LONGEST} characters"
    for token in tokens(text, file):
        here = Position(token.line or 1, token.column or 1)
        if token.type in KEYWORDS and token.value != token.type:
            yield here, f"{token.value}: write keywords in upper case"
        elif token.type == "STRING":
            for escape in _QUOTE.finditer(token.value):
                if escape[1]:
                    code = f"${ord(escape[1]):02X}"
                    text = f"{escape[0]} ends the text on some PLCs: write {code}"
                    yield Position(here.line, here.column + escape.start()), text
