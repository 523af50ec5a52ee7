"""The networks of a diagram in PLCopen XML, which has no element for them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from structured_text.projects.diagrams.networks.check import DiagramError, inputs_of
from structured_text.projects.diagrams.networks.model import (
    Element,
    Network,
    Position,
    Rail,
)

__all__ = ["Note", "numbered"]

#: In FBD, CODESYS numbers elements from this number times the number of their network.
_STRIDE = 10**10


@dataclass(frozen=True)
class Note:
    """A comment, a label, or the title with which CODESYS opens a network of ladder.

    Attributes:
        kind: comment, label or title.
        text: Its text.
        id: Its number in the file.
        corner: Its upper left corner.
        size: Its width and height.
        at: Line in the file.
        before: The number of elements before it in the file.
    """

    kind: str
    text: str
    id: str
    corner: Position
    size: Position
    at: int
    before: int = 0


def numbered(
    elements: Sequence[Element], notes: Sequence[Note], *, placed: bool
) -> tuple[tuple[Network, ...], list[Element]]:
    """Return the networks, and the elements with the numbers of their networks.

    `placed` is whether the file has the positions of the elements.
    """
    if placed:
        return _by_place(elements, notes)
    if any(note.kind == "title" for note in notes):
        return _by_title(elements, notes)
    if any(_stride(one.id) for one in (*elements, *notes)):
        return _by_stride(elements, notes)
    parts = _parts(elements)
    order = {one.id: number for number, one in enumerate(elements)}
    parts.sort(key=lambda part: min(order[one.id] for one in part))
    networks, made = _of_parts(elements, parts)
    for note in notes:
        number = next((one.network for one in made[note.before :] if one.network), len(networks))
        networks = _noted(networks, number, note)
    return tuple(networks), made


# --- files without positions -----------------------------------------------------------------


def _by_title(
    elements: Sequence[Element], notes: Sequence[Note]
) -> tuple[tuple[Network, ...], list[Element]]:
    """Return networks that a title opens; comment and label may stand before the title."""
    networks: list[Network] = []
    made: list[Element] = []
    waiting: list[Note] = []
    events: list[Element | Note] = list(elements)
    for note in reversed(notes):
        events.insert(note.before, note)
    for event in events:
        if isinstance(event, Note) and event.kind != "title":
            waiting.append(event)
            continue
        if isinstance(event, Note):
            networks.append(Network(len(networks) + 1, title=event.text, at=event.at))
        elif isinstance(event, Rail):
            made.append(replace(event, network=0))
            continue
        elif not networks:
            networks.append(Network(1, at=event.at))
        for note in waiting:
            networks = _noted(networks, networks[-1].number, note)
        waiting = []
        if not isinstance(event, Note):
            made.append(replace(event, network=networks[-1].number))
    for note in waiting:
        networks = _noted(networks, len(networks), note)
    return tuple(networks), made


def _stride(name: str) -> int:
    return int(name) // _STRIDE if name.isdigit() else 0


def _by_stride(
    elements: Sequence[Element], notes: Sequence[Note]
) -> tuple[tuple[Network, ...], list[Element]]:
    """Return networks by the numbers of their elements; a network that is missing is empty."""
    made = [
        replace(one, network=0 if isinstance(one, Rail) else max(_stride(one.id), 1))
        for one in elements
    ]
    highest = max([one.network for one in made] + [_stride(note.id) for note in notes] + [1])
    at = made[0].at if made else 1
    networks = []
    for number in range(1, highest + 1):
        at = min((one.at for one in made if one.network == number), default=at)
        networks.append(Network(number, at=at))
    for note in notes:
        networks = _noted(networks, max(_stride(note.id), 1), note)
    return tuple(networks), made


# --- files with positions --------------------------------------------------------------------


def _by_place(
    elements: Sequence[Element], notes: Sequence[Note]
) -> tuple[tuple[Network, ...], list[Element]]:
    """Return the connected parts from the top to the bottom of the drawing."""
    parts = _parts(elements)
    parts.sort(key=lambda part: min((one.position.y, one.position.x) for one in part))
    networks, made = _of_parts(elements, parts)
    for note in notes:
        if parts:
            distances = [_distance(note, part) for part in parts]
            networks = _noted(networks, distances.index(min(distances)) + 1, note)
        else:
            networks = _noted(networks, 1, note)
    return tuple(networks), made


def _distance(note: Note, part: Sequence[Element]) -> tuple[int, float, float]:
    """Return how far a part is from a comment or label: a part beside or below it is nearer."""
    top = min(one.position.y for one in part)
    bottom = max(one.position.y for one in part)
    left = min(one.position.x for one in part)
    right = max(one.position.x for one in part)
    upper, lower = note.corner.y, note.corner.y + note.size.y
    aside = max(0.0, left - note.corner.x - note.size.x, note.corner.x - right)
    if upper <= bottom and top <= lower:
        return 0, 0.0, aside
    if bottom > upper:
        return 1, top - lower, aside
    return 2, upper - bottom, aside


# --- connected parts -------------------------------------------------------------------------


def _parts(elements: Sequence[Element]) -> list[list[Element]]:
    """Return the connected parts. Rails are left out, because several rungs can share one."""
    known = {one.id: one for one in elements if not isinstance(one, Rail)}
    above = {name: name for name in known}

    def root(name: str) -> str:
        while above[name] != name:
            above[name] = above[above[name]]
            name = above[name]
        return name

    for one in known.values():
        for source in _sources(one):
            if source in known:
                above[root(one.id)] = root(source)
    parts: dict[str, list[Element]] = {}
    for name, one in known.items():
        parts.setdefault(root(name), []).append(one)
    return list(parts.values())


def _of_parts(
    elements: Sequence[Element], parts: Sequence[Sequence[Element]]
) -> tuple[list[Network], list[Element]]:
    number_of = {one.id: number for number, part in enumerate(parts, 1) for one in part}
    networks = [
        Network(number, at=min(one.at for one in part)) for number, part in enumerate(parts, 1)
    ]
    served: dict[str, set[int]] = {}
    for one in elements:
        for source in _sources(one):
            served.setdefault(source, set()).add(number_of.get(one.id, 0))
    made = []
    for one in elements:
        numbers = served.get(one.id, set()) - {0}
        rail = numbers.pop() if len(numbers) == 1 else 0
        made.append(replace(one, network=number_of.get(one.id, rail)))
    return networks, made


def _sources(element: Element) -> Iterable[str]:
    return [line.source for pin in inputs_of(element) for line in pin.connections]


def _noted(networks: list[Network], number: int, note: Note) -> list[Network]:
    """Return the networks with a comment or label added to one of them."""
    if not networks:
        networks = [Network(1, at=note.at)]
    old = networks[number - 1]
    if note.kind == "label" and old.label:
        text = f"network {number}: it has two labels, {old.label} and {note.text}"
        raise DiagramError(text, note.at, "use one label for both jumps")
    if note.kind == "label":
        new = replace(old, label=note.text)
    elif note.kind == "title":
        new = replace(old, title=note.text)
    else:
        new = replace(old, comment="\n".join(text for text in (old.comment, note.text) if text))
    return [*networks[: number - 1], new, *networks[number:]]
