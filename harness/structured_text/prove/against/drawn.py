"""Random runs of both versions with the same inputs, from a seed."""

from __future__ import annotations

from random import Random
from typing import Any

from structured_text.language.scalars import INT_RANGE, WIDTH
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.prove import values
from structured_text.prove.against.search import Run
from structured_text.prove.against.step import give, machines
from structured_text.prove.against.versions import Pair
from structured_text.prove.invariants import constants
from structured_text.prove.search import ScanInput

__all__ = ["drawn_run"]

#: Probability that an input, or an area, changes before a scan.
_CHANGES = 0.15
_SECOND_NS = 1_000_000_000


def drawn_run(pair: Pair, scan_us: int, scans: int, seed: str) -> Run:
    """Return a run with random inputs. Equal seeds give equal runs."""
    random = Random(seed)
    inputs = [one for one in pair.inputs() if one.any.searched]
    sizes = _areas(pair)
    numbers = sorted(set().union(*(constants(v.project, v.own) for v in pair.versions)))
    content = {device: bytearray(size) for device, size in sizes.items()}
    connected = dict.fromkeys(sizes, True)
    last: dict[str, Any] = {one.name: one.any.initial for one in inputs}
    steps = []
    for number in range(scans):
        for device, area in content.items():
            if random.random() < _CHANGES:
                area[random.randrange(len(area))] ^= 1 << random.randrange(8)
            connected[device] = random.random() > _CHANGES / 10
        given = {}
        for one in inputs:
            if random.random() < _CHANGES:
                value = _drawn(one.any.type, random, numbers)
                if value != last[one.name] or not one.steady:
                    given[one.name] = last[one.name] = value
        areas = {device: (bytes(area), connected[device]) for device, area in content.items()}
        steps.append(ScanInput(number * scan_us, areas, given))
    return Run(scan_us, tuple(steps))


def _areas(pair: Pair) -> dict[int, int]:
    """Return the size of the area of each device."""
    both = machines(pair, frozenset(), "")
    for version, machine in zip(pair.versions, both, strict=True):
        version.around.start(machine)
    areas = give(pair, [], both, 0, everything=False).areas
    return {device: len(content) for device, (content, _) in areas.items()}


def _drawn(kind: Type, random: Random, numbers: list[int]) -> Any:
    """Return a random value: often a constant of the programs, or a number next to it."""
    if kind == ElementaryType("BOOL"):
        return random.random() < 0.5
    if isinstance(kind, EnumType):
        return random.randrange(len(kind.members))
    if values.is_duration(kind):
        return random.randrange(4_000) * (_SECOND_NS // 1000)
    if random.random() < 0.7:
        return values.wrapped(kind, random.choice(numbers) + random.randint(-1, 1))
    name = getattr(kind, "name", "")
    low = INT_RANGE[name][0] if name in INT_RANGE else 0
    return low + random.randrange(1 << WIDTH[name])
