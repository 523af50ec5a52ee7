"""The watched variables of a program, named by paths or by patterns."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from difflib import get_close_matches
from fnmatch import fnmatchcase
from itertools import islice, product

from structured_text.engines.base import Program, Value
from structured_text.errors import InputError, did_you_mean
from structured_text.language.displayed import check_watched, is_long, members, parts, value_text
from structured_text.language.types import ArrayType, BlockType, Type
from structured_text.output.limits import MOST_WATCHED

__all__ = ["Watched", "is_like"]

#: Separates patterns. A comma in brackets separates indices and does not match.
_COMMA = re.compile(r",(?![^\[\]]*\])")
_WILD = re.compile(r"[*?]")
_PART = re.compile(r"\.?((?:[^\W\d]|[*?])[\w*?]*)|\[([^\[\]]*)\]")
_MOST_NAMED = 12

#: A path, and the type of the variable at this path.
_Found = tuple[str, Type]


class Watched:
    """The watched variables of a program.

    Args:
        program: The program.
        patterns: Paths as for `Program.read`; a text may contain several, with commas between them.
            `*` stands for any characters of a name or index and `?` for one character. A pattern
            skips blocks and arrays that are too long to show.

    Raises:
        InputError: A path names no variable, or a pattern matches none; the error suggests similar
            names.
    """

    def __init__(self, program: Program, patterns: str | Sequence[str]) -> None:
        given = [patterns] if isinstance(patterns, str) else patterns
        self.types: dict[str, Type] = {}
        for pattern in (one.strip() for part in given for one in _COMMA.split(part)):
            if _WILD.search(pattern):
                self.types |= _matching(program, pattern)
            else:
                self.types[pattern] = program.type_of(pattern)
        check_watched(self.types)
        self._read = program.reader(list(self.types))
        self._last: tuple[Value, ...] | None = None

    def values(self) -> dict[str, Value]:
        """Return the values by path.

        After a call of `keep`, the values that `keep` has read are returned.
        """
        read = self._read() if self._last is None else self._last
        return dict(zip(self.types, read, strict=True))

    def texts(self) -> dict[str, str]:
        """Return the values as texts by path, with one entry for each member and element."""
        return {
            part.path: value_text(part.type, part.of(value))
            for path, value in self.values().items()
            for part in parts(path, self.types[path])
        }

    def keep(self) -> None:
        """Read and save the values for the last time, because the program is about to be freed."""
        self._last = self._read()


def _matching(program: Program, pattern: str) -> dict[str, Type]:
    parts = list(_PART.finditer(pattern))
    if "".join(part[0] for part in parts) != pattern or pattern[0] in ".[":
        raise InputError(
            f"{pattern!r} is not a pattern of variables", hint="write it as Main.Hmi.* or Main.A[*]"
        )
    first = next(k for k, part in enumerate(parts) if _WILD.search(part[0]))
    begin = pattern[: parts[first].start()]
    there = _within(program, begin) if begin else list(_roots(program))
    for part in parts[first:]:
        found = [one for one in there if _fits_part(one[0], part)]
        if not found:
            raise _nothing(pattern, part, there)
        there = list(islice(_below(found), MOST_WATCHED + 1))
        if len(there) > MOST_WATCHED and part is not parts[-1]:
            text = f"{pattern} matches more than {MOST_WATCHED:,} variables"
            raise InputError(text, hint="write names or indices in place of some * and ?")
    if not _WILD.search(parts[-1][0]):
        return dict(found)
    shown = {one[0]: one[1] for one in found if not _is_much(one[1])}
    if not shown:
        name = found[0][0]
        more = f", or its variables as {name}.*" if isinstance(found[0][1], BlockType) else ""
        raise InputError(
            f"{pattern} matches only blocks and long arrays", hint=f"name one: {name}{more}"
        )
    return shown


def _is_much(kind: Type) -> bool:
    """Return whether a variable is too large to be shown, unless the user names it."""
    return isinstance(kind, BlockType) or is_long(kind)


def _roots(program: Program) -> Iterator[_Found]:
    """Yield the program instances and the global variables."""
    yield from program.instances().items()
    yield from ((path, kind) for path, kind in program.walk() if "." not in path)


def _within(program: Program, path: str) -> list[_Found]:
    """Return the members or elements of a variable, or the variables of a global variable list."""
    try:
        return list(_below([(path, program.type_of(path))]))
    except InputError:
        listed = list(_listed(program, path))
        if not listed:
            raise
        return listed


def _listed(program: Program, name: str) -> Iterator[_Found]:
    for one, kind in _roots(program):
        path = f"{name}.{one}"
        with suppress(InputError):
            if program.type_of(path) == kind:
                yield path, kind


def _below(found: Iterable[_Found]) -> Iterator[_Found]:
    """Yield the members and elements of some variables."""
    for path, kind in found:
        for name, member in members(kind):
            yield f"{path}.{name}", member
        if isinstance(kind, ArrayType):
            for place in product(*(range(low, high + 1) for low, high in kind.bounds)):
                yield f"{path}[{','.join(map(str, place))}]", kind.element


def _fits_part(path: str, part: re.Match[str]) -> bool:
    """Return whether the last name or index of a path matches a name or index of a pattern."""
    if part[2] is not None:
        index = path.rpartition("[")[2].removesuffix("]") if path.endswith("]") else ""
        wanted, given = part[2].split(","), index.split(",")
        return len(wanted) == len(given) and all(map(is_like, wanted, given))
    return not path.endswith("]") and is_like(part[1], path.rpartition(".")[2])


def is_like(pattern: str, name: str) -> bool:
    """Return whether a name matches a pattern with `*` and `?`."""
    wanted = pattern.strip().upper().replace("[", "[[]")
    return fnmatchcase(name.upper(), wanted)


def _nothing(pattern: str, part: re.Match[str], there: Sequence[_Found]) -> InputError:
    """Return the error for a pattern that matches no variable, with similar names."""
    names = list(dict.fromkeys(re.split(r"\.(?!.*\.)|(?=\[)", path)[-1] for path, _ in there))
    meant = _WILD.sub("", part[0]).strip(".").upper()
    by_name = {name.upper(): name for name in names}
    near = [by_name[key] for key in get_close_matches(meant, by_name)]
    there_are = f"there are {', '.join(names[:_MOST_NAMED])}" if names else ""
    return InputError(f"no variable matches {pattern}", hint=did_you_mean(near) or there_are)
