"""Names of the variables that a translation of a chart adds to its POU."""

from __future__ import annotations

import re
from collections.abc import Iterable

from structured_text.errors import VARIABLES

__all__ = ["Names", "replaced"]

_WORD = re.compile(r"[^\W\d]\w*")
_BLANK = re.compile(
    r"\(\*.*?(?:\*\)|\Z)|//[^\n]*|/\*.*?(?:\*/|\Z)|'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\"",
    re.DOTALL,
)
_MEMBER = re.compile(r"(?<![\w.])([^\W\d]\w*)\s*\.\s*(X|T|Q)\b(?!\s*\()", re.IGNORECASE)


class Names:
    """The variables of a chart; no name occurs as a word in `text`, the text of the POU."""

    def __init__(self, text: str) -> None:
        self._taken = {word.upper() for word in _WORD.findall(text)}
        self._made: dict[tuple[str, str], str] = {}

    def of(self, kind: str, name: str = "") -> str:
        """Return the variable of a kind, such as `Step`, for a step, action or transition."""
        key = kind, name.upper()
        if key not in self._made:
            self._made[key] = self._new(kind, name)
        return self._made[key]

    def _new(self, kind: str, name: str) -> str:
        # Names in matiec have neither two underscores in a row nor an underscore at the end.
        plain = re.sub(r"_+", "_", name).strip("_")
        base = f"{VARIABLES}{kind}_{plain}" if plain else f"{VARIABLES}{kind}"
        found, number = base, 2
        while found.upper() in self._taken:
            found, number = f"{base}_{number}", number + 1
        self._taken.add(found.upper())
        return found

    def has(self, kind: str, name: str) -> bool:
        """Return whether `of` has made this variable."""
        return (kind, name.upper()) in self._made


def replaced(text: str, steps: Iterable[str], actions: Iterable[str], names: Names) -> str:
    """Return a text with variables in place of the flags `Step.X`, `Step.T` and `Action.Q`.

    Comments and texts in quotes stay as they are.
    """
    of_steps = {name.upper() for name in steps}
    of_actions = {name.upper() for name in actions}

    def flag(found: re.Match[str]) -> str:
        name, member = found[1].upper(), found[2].upper()
        if member == "Q" and name in of_actions:
            return names.of("Action", name_of[name])
        if member in "XT" and name in of_steps:
            return names.of("Step" if member == "X" else "Time", name_of[name])
        return found[0]

    name_of = {name.upper(): name for name in (*actions, *steps)}
    parts, behind = [], 0
    for blank in _BLANK.finditer(text):
        parts += [_MEMBER.sub(flag, text[behind : blank.start()]), blank[0]]
        behind = blank.end()
    return "".join((*parts, _MEMBER.sub(flag, text[behind:])))
