"""The signals of an example's chart: their selection and names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence

from rcx_harness.spec import command_name, signals
from rcx_harness.spec.telegram import Field
from rcx_harness.trace import Record, Scan
from rcx_harness.trace.chart import Lane
from rcx_harness.watch.wire import word
from rcx_tools.docs.blocks.examples import Snippet
from rcx_tools.docs.blocks.source import pous
from rcx_tools.library import library

__all__ = ["DRAWN", "Track", "not_too_many", "tracks_of"]

#: Types of pins that are drawn as signals. Pins with numbers are drawn as words of the area.
DRAWN = {"BOOL": "variable", "BYTE": "word", "WORD": "word", "UINT": "word"}

#: Greatest number of data words and of response words in a chart.
_MOST_WORDS = 6
_WORDS = 16
#: Names of the response words of an abnormal end.
_ALARM = {1: "alarm group", 2: "alarm category"}


class Track:
    """A signal with its lane in the chart and the function that reads its value from a scan."""

    def __init__(
        self,
        name: str,
        kind: str,
        value: Callable[[Scan], int],
        show: Callable[[int], str] | None = None,
    ) -> None:
        self.name = name
        self._value = value
        self._lane = Lane(name, kind, show=show)

    def take(self, record: Record) -> None:
        """Store the value of the signal if this entry of the trace is a scan."""
        if isinstance(record, Scan):
            self._lane.note(record.t_us, self._value(record))

    def changed(self, begin: int, end: int) -> bool:
        """Return whether the signal changed from `begin` to `end`.

        For pins and outputs of the PLC, a change at `begin` counts. Other signals must change after
        `begin`.
        """
        own = self._lane.kind == "variable" or self.name.startswith(("SI", "n "))
        return any(begin - own < t_us <= end for t_us, _ in self._lane.changes)

    def lane_of(self, begin: int) -> Lane:
        """Return the lane of the track, with times counted from `begin`."""
        changes = [(t_us - begin, value) for t_us, value in self._lane.changes]
        return Lane(self.name, self._lane.kind, changes, show=self._lane.show)


def tracks_of(snippet: Snippet, flags: Sequence[str]) -> Iterator[Track]:
    """Yield all signals that may be drawn, in the order of the chart.

    Args:
        snippet: The example.
        flags: Paths of the variables in the trace.
    """
    types = {pin.name: pin.type for pin in snippet.pou.pins}
    for path in flags:
        name = path.rpartition(".")[2]
        yield Track(name, DRAWN[types.get(name, "BOOL")], _variable(path))
    extra = [one.partition(" ") for one in snippet.show if not one.startswith("Main.")]
    given = {at: name for at, _, name in extra}
    remote = snippet.pou.folder == "command"
    dedicated = snippet.call is None or snippet.pou.folder != "area"
    for signal in signals().input:
        if (dedicated and not remote) or signal.short in given:
            name, byte, bit = f"{signal.signal} {signal.title}", signal.byte, signal.bit
            yield Track(name, "input", _bit("n", byte, bit))
    yield from (_place(at, name) for at, name in given.items() if at.startswith("n+"))
    if remote:
        yield from _words("n", snippet)
    for signal in signals().output if dedicated else ():
        name, byte, bit = f"{signal.signal} {signal.title}", signal.byte, signal.bit
        yield Track(name, "output", _bit("m", byte, bit))
    yield from (_place(at, name) for at, name in given.items() if at.startswith("m+"))
    if remote:
        yield from _words("m", snippet)


def _place(at: str, name: str) -> Track:
    """Return the track of a bit, `n+34.0`, or of a word, `m+48`."""
    byte, _, bit = at[2:].partition(".")
    label = f"{at[0]} + {at[2:]}: {name}"
    if bit:
        return Track(label, "input" if at[0] == "n" else "output", _bit(at[0], byte, bit))
    return Track(label, "word", _word(at[0], int(byte)))


def _variable(path: str) -> Callable[[Scan], int]:
    return lambda scan: int((scan.vars or {})[path])


def _bit(letter: str, byte: int | str, bit: int | str) -> Callable[[Scan], int]:
    k, b = int(byte), int(bit)
    if letter == "n":
        return lambda scan: scan.si[k] >> b & 1
    return lambda scan: scan.so[k] >> b & 1


def _word(letter: str, at: int) -> Callable[[Scan], int]:
    if letter == "n":
        return lambda scan: word(scan.si, at)
    return lambda scan: word(scan.so, at)


def _words(letter: str, snippet: Snippet) -> Iterator[Track]:
    """Yield the words of the remote command (n) or of its answer (m), with the fields' names."""
    block = library().blocks.get(snippet.pou.name)
    # If another command ran before, a lane contains words of two commands. Field names would be
    # wrong.
    mixed = any(pous()[step.block].folder == "command" for step in snippet.before)
    fields: Mapping[str, Field] = {}
    if block and not mixed:
        fields = block.requests if letter == "n" else block.responses
    ends_abnormally = any(step.end == "Error" for step in snippet.before)
    ends_abnormally = ends_abnormally or snippet.pou.name == "FB_Jog"
    shared = [one.split(" ")[0] for one in snippet.show]
    for k in range(_WORDS):
        if f"{letter}+{2 * k}" in shared:
            continue
        names = [_part(one, k) for one in fields.values() if k in one.words]
        name = names[0] if len(names) == 1 else "flags" if names else ""
        if not k:
            name = "command code" if letter == "n" else "status"
        elif not name and letter == "m":
            name = _ALARM.get(k, "") if ends_abnormally else "" if mixed else f"SOW({k})"
        label = f"{letter} + {2 * k}{': ' if name else ''}{name}"
        show = command_name if not k and letter == "n" else None
        yield Track(label, "word", _word(letter, 2 * k), show)


def _part(part: Field, k: int) -> str:
    """Return the name of word k of a field: `point`, `targets[2] high`."""
    place = k - part.words[0]
    if part.type not in ("s32", "u32"):
        return f"{part.name}[{place + 1}]" if part.count > 1 else part.name
    index = f"[{place // 2 + 1}]" if part.count > 1 else ""
    return f"{part.name}{index} {'high' if place % 2 else 'low'}"


def not_too_many(tracks: Sequence[Track]) -> tuple[list[Track], list[str]]:
    """Return the tracks to draw, and the names of words that do not fit into the chart."""
    shown: list[Track] = []
    left_out = []
    for track in tracks:
        match = re.match(r"([mn]) \+ \d+", track.name)
        same = [one for one in shown if match and one.name.startswith(f"{match[1]} + ")]
        if match and len(same) > _MOST_WORDS:
            left_out.append(match[0])
        else:
            shown.append(track)
    return shown, left_out
