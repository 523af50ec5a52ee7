"""The arrangement of a routine's rungs with its jumps.

A jump forward guards the rungs up to its label. A jump backward repeats the rungs from its label to
the jump.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from structured_text.language.source import Line
from structured_text.projects.model import Lines, without_comments
from structured_text.projects.rockwell.ladder.call import Body, Jump

__all__ = ["arranged"]

_INDENT = "  "


def arranged(parts: Sequence[Lines], body: Body) -> Lines:
    """Return the statements of a routine from the statements of its rungs."""
    if not body.jumps:
        return tuple(line for part in parts for line in part)
    return tuple(_Arrangement(parts, body.jumps).lines())


class _Arrangement:
    def __init__(self, parts: Sequence[Lines], jumps: Sequence[Jump]) -> None:
        self._parts, self._jumps = parts, jumps
        self._loops = _loops(jumps)

    def lines(self) -> Iterator[Line]:
        for variable in dict.fromkeys(jump.variable for jump in self._jumps if not jump.back):
            yield self._line(f"{_INDENT}{variable} := FALSE;", 0, "jumps")
        yield from self._between(0, len(self._parts), _INDENT, 0)

    def _line(self, text: str, rung: int, network: str) -> Line:
        """Return a line at a rung.

        It does not belong to the rung, because it is also executed if the rung is skipped.
        """
        return Line(text, self._parts[rung][0].at, network=network)

    def _titles(self, first: int, last: int) -> str:
        """Return the titles of rungs, such as `rung 3` or `rung 3 to rung 5`."""
        titles = (self._parts[first][0].network, self._parts[last][0].network)
        return " to ".join(dict.fromkeys(titles))

    def _between(self, first: int, last: int, indent: str, depth: int) -> Iterator[Line]:
        """Yield the rungs from `first` up to `last`, with the loops that begin there."""
        number = first
        while number < last:
            loops = [loop for loop in self._loops if loop[0] == number]
            inner = loops[depth:] if number == first else loops
            if inner:
                start, end, variable = inner[0]
                del start
                loop = f"loop of {self._titles(number, end)}"
                yield self._line(f"{indent}REPEAT", number, loop)
                yield self._line(f"{indent}{_INDENT}{variable} := FALSE;", number, loop)
                deeper = depth + 1 if number == first else 1
                yield from self._between(number, end + 1, indent + _INDENT, deeper)
                yield self._line(f"{indent}UNTIL NOT {variable}", end, loop)
                yield self._line(f"{indent}END_REPEAT;", end, loop)
                number = end + 1
                continue
            behind = min([loop[0] for loop in self._loops if loop[0] > number] + [last])
            yield from self._guarded(range(number, behind), indent)
            number = behind

    def _guarded(self, rungs: Sequence[int], indent: str) -> Iterator[Line]:
        arrivals = [rung for rung in rungs if any(self._arrived(rung))]
        for (guard, _), some in groupby(
            rungs, lambda rung: (self._guard(rung), sum(label <= rung for label in arrivals))
        ):
            numbers = list(some)
            for variable in self._arrived(numbers[0]):
                yield self._line(f"{indent}{variable} := FALSE;", numbers[0], "jumps")
            jump = f"jump over {self._titles(numbers[0], numbers[-1])}"
            inside = indent
            texts = [line.text for number in numbers for line in self._parts[number]]
            if not without_comments("\n".join(texts)).strip():
                guard = ()  # an IF without statements is not legal
            if guard:
                text = guard[0] if len(guard) == 1 else f"({' OR '.join(guard)})"
                yield self._line(f"{indent}IF NOT {text} THEN", numbers[0], jump)
                inside += _INDENT
            for number in numbers:
                for line in self._parts[number]:
                    yield replace(line, text=inside + line.text[len(_INDENT) :])
            if guard:
                yield self._line(f"{indent}END_IF;", numbers[-1], jump)

    def _guard(self, rung: int) -> tuple[str, ...]:
        """Return the variables of the jumps that skip a rung."""
        found = [
            jump.variable
            for jump in self._jumps
            if not jump.back and jump.source < rung < jump.target
        ]
        ends = {variable: end for _, end, variable in self._loops}
        found += [
            jump.variable
            for jump in self._jumps
            if jump.back and jump.source < rung <= ends[jump.variable]
        ]
        return tuple(dict.fromkeys(found))

    def _arrived(self, rung: int) -> Iterator[str]:
        """Yield the variables of forward jumps whose label is at this rung in a loop."""
        if any(start <= rung <= end for start, end, _ in self._loops):
            yield from dict.fromkeys(
                jump.variable for jump in self._jumps if not jump.back and jump.target == rung
            )


def _loops(jumps: Sequence[Jump]) -> list[tuple[int, int, str]]:
    """Return the first and last rung and the variable of each loop; outer loops come first.

    A loop that would overlap another one is made longer, so that it contains the other one.
    """
    ends: dict[tuple[int, str], int] = {}
    for jump in jumps:
        if jump.back:
            key = jump.target, jump.variable
            ends[key] = max(ends.get(key, 0), jump.source)
    changed = True
    while changed:
        changed = False
        for (start, _), end in list(ends.items()):
            for (other, name), last in list(ends.items()):
                if other < start <= last < end:
                    ends[other, name] = end
                    changed = True
    found = [(start, end, variable) for (start, variable), end in ends.items()]
    return sorted(found, key=lambda loop: (loop[0], -loop[1]))
