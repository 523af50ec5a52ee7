"""The relations: changes of a program, and the parts of its course that must stay the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import timedelta
from itertools import zip_longest
from random import Random
from typing import Any, NamedTuple

from rcx_tools.evidence.metamorphic.changes import in_bytes, in_words, resized, shifted, slower
from rcx_tools.evidence.metamorphic.course import Course, Options, Seen
from rcx_tools.evidence.metamorphic.programs import EVERY_COMMAND, Subject, every_command
from rcx_tools.library.tables import library
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.output.units import format_us

__all__ = ["RELATIONS", "Relation", "Variant", "head_of", "reason_against", "same", "same_scans"]

#: Bytes in an image (RCX_IMAGE and RCX_IMAGE_WORDS alike).
_IMAGE = 512
#: Factors by which everything takes longer.
_FACTORS = (2, 3)


class Variant(NamedTuple):
    """A changed program, and the options of its run."""

    name: str
    subject: Subject
    options: Options


@dataclass(frozen=True)
class Relation:
    """A change that must not matter.

    Attributes:
        name: The subject of the change.
        statement: The meaning of "the same".
        variants: Yields the changed programs, from the program, its options and a seed.
        differs: Returns the first difference of two courses as a sentence; empty if none.
        against: Returns why the relation does not apply to a program; empty if it does.
        basis: Returns the program with which the variants are compared.
    """

    name: str
    statement: str
    variants: Callable[[Subject, Options, int], Iterator[Variant]]
    differs: Callable[[Course, Course], str]
    against: Callable[[Subject], str]
    basis: Callable[[Subject], Subject] = lambda subject: subject


# --- comparisons of courses -------------------------------------------------------------------


def same(base: Course, other: Course) -> str:
    """Compare scan for scan and cycle for cycle: time, both areas, all watched variables."""
    return _first_difference(base, other) or _same_cycles(base.cycles, other.cycles)


def head_of(base: Course, other: Course) -> str:
    """Compare like `same` the first 48 bytes of each area; the bytes behind them must be 0."""
    for course in (base, other):
        areas = [area for seen in course.scans for area in (seen.so[48:], seen.si[48:])]
        areas += [area for _, si, so in course.cycles for area in (si[48:], so[48:])]
        if any(map(any, areas)):
            return "something stands behind the first 48 bytes"
    return same(_cut(base), _cut(other))


def same_scans(base: Course, other: Course) -> str:
    """Compare scan for scan, counted from the start: both areas and all watched variables.

    The time since the last scan in RCX_REF and values of TIME are left out, because they must
    differ. The controller's cycle stays at 5 ms. A movement may take any time, so the slower run
    may see its end one scan earlier. It never sees it later, because the faster run rounds up more.
    """
    base, other = _timeless(base), _timeless(other)
    strict = _first_difference(base, other, times=False)
    if not strict or base.broken or other.broken or other.outside:
        return strict
    kept = _without_rounding(base.scans, other.scans)
    if kept is None:
        return strict
    pairs = list(zip(kept, other.scans, strict=False))
    return "" if all(first == second for first, second in pairs) else strict


def _timeless(course: Course) -> Course:
    """Return the course without RCX_REF.Inner.Elapsed and the program's own values of TIME."""
    scans = [seen._replace(values=tuple(map(_no_time, seen.values))) for seen in course.scans]
    return replace(course, scans=scans)


def _no_time(value: Any) -> Any:
    if isinstance(value, timedelta):
        return timedelta(0)
    if isinstance(value, dict) and "Inner" in value:
        return {**value, "Inner": {**value["Inner"], "Elapsed": 0}}
    return value


def _without_rounding(base: list[Seen], other: list[Seen]) -> list[Seen] | None:
    """Return `base` without the single scans that still wait for the end of a command."""
    kept: list[Seen] = []
    for at, seen in enumerate(base):
        place = len(kept)
        if place >= len(other):
            break
        if seen == other[place]:
            kept.append(seen)
            continue
        waits = at > 0 and seen == base[at - 1] and _is_end(other[place])
        if not waits or at + 1 == len(base) or base[at + 1] != other[place]:
            return None
    return kept


def _is_end(seen: Seen) -> bool:
    """Return whether it shows the end status of a command, 0x0200 or 0x4000."""
    return seen.so[:2] in (b"\x00\x02", b"\x00\x40")


def _cut(course: Course) -> Course:
    scans = [Seen(seen.so[:48], seen.si[:48], seen.values) for seen in course.scans]
    cycles = [(t_us, si[:48], so[:48]) for t_us, si, so in course.cycles]
    return replace(course, scans=scans, cycles=cycles)


def _first_difference(base: Course, other: Course, *, times: bool = True) -> str:
    if base.paths != other.paths:
        return "the programs do not have the same variables"
    if other.outside:
        return f"{other.outside} bytes of the output image beside the area are not 0"
    if base.broken != other.broken:
        return f"rules that are broken: {base.broken[:1]} and {other.broken[:1]}"
    pairs = zip_longest(base.scans, other.scans)
    for number, (first, second) in enumerate(pairs):
        if first is None or second is None:
            return f"one run has {len(base.scans)} scans, the other {len(other.scans)}"
        when = base.times[number]
        if times and when != other.times[number]:
            return f"scan {number} is at {format_us(when)} and at {format_us(other.times[number])}"
        if first != second:
            return f"scan {number} ({format_us(when)}): {_what(base.paths, first, second)}"
    return ""


def _what(paths: tuple[str, ...], first: Seen, second: Seen) -> str:
    for name, one, two in (("read", first.so, second.so), ("written", first.si, second.si)):
        if one != two:
            at = next((k for k in range(min(len(one), len(two))) if one[k] != two[k]), 0)
            return f"the area {name} differs from byte {at} on: {one[at:].hex()}, {two[at:].hex()}"
    pairs = zip(paths, first.values, second.values, strict=True)
    return next(f"{path} is {one!r} and {two!r}" for path, one, two in pairs if one != two)


def _same_cycles(
    base: list[tuple[int, bytes, bytes]], other: list[tuple[int, bytes, bytes]]
) -> str:
    for number, (first, second) in enumerate(zip_longest(base, other)):
        if first != second:
            return f"controller cycle {number} differs: {first}, {second}"
    return ""


# --- reasons against a relation ---------------------------------------------------------------


def reason_against(subject: Subject) -> str:
    """Return no reason: the relation applies to every program."""
    return ""


def _uses_extension(subject: Subject) -> str:
    return "it uses words beyond the first 48 bytes" if subject.size == 256 else ""


#: Examples with movements or robot programs that follow one another without a pause.
_MOVES = (
    *("example 07_pallet", "example 08_program_by_name", "example 11_emergency_stop"),
    "example 13_pallet_by_table",
)


def _cuts(subject: Subject) -> str:
    if subject.cuts:
        return "the connection is lost: a scanner's 100 ms to open it anew are no scans"
    if subject.name in _MOVES:
        return "what the robot does, one after the other, ends between scans: in others if slower"
    return ""


def _no_matiec(subject: Subject) -> str:
    if find_matiec() is None or find_c_compiler() is None:
        return "matiec not found (RCX_MATIEC, PATH)"
    return ""


# --- the changes ------------------------------------------------------------------------------


def _shifts(subject: Subject, options: Options, seed: int) -> Iterator[Variant]:
    """Yield the first and the last legal offset, and two random ones."""
    random = Random(f"offsets {seed} {subject.name}")
    step = 2 if subject.words else 1
    last = _IMAGE - subject.size

    def drawn() -> int:
        return random.randrange(last // step + 1) * step

    for m, n in ((0, last), (last, 0), (drawn(), drawn()), (drawn(), drawn())):
        yield Variant(f"m = {m}, n = {n}", shifted(subject, m, n), options)


def _sizes(subject: Subject, options: Options, seed: int) -> Iterator[Variant]:
    yield Variant("256 bytes", resized(subject, 256), options)


def _areas(subject: Subject, options: Options, seed: int) -> Iterator[Variant]:
    if subject.words:
        yield Variant("bytes", in_bytes(subject), options)
    else:
        yield Variant("words", in_words(subject), options)


def _without_clock(subject: Subject) -> Subject:
    """Return the program without FB_ReadTime: a slower run reads a later time of day."""
    if subject.name != EVERY_COMMAND:
        return subject
    return every_command(tuple(name for name in library().blocks if name != "FB_ReadTime"))


def _scales(subject: Subject, options: Options, seed: int) -> Iterator[Variant]:
    for factor in _FACTORS:
        changed = slower(_without_clock(subject), factor)
        yield Variant(f"{factor} times as slow", changed, replace(options, slower=factor))


def _engines(subject: Subject, options: Options, seed: int) -> Iterator[Variant]:
    other = "builtin" if options.engine == "matiec" else "matiec"
    yield Variant(other, subject, replace(options, engine=other))


def _links(subject: Subject, options: Options, seed: int) -> Iterator[Variant]:
    yield Variant("enip", subject, replace(options, link="enip"))


RELATIONS: dict[str, Relation] = {
    one.name: one
    for one in (
        Relation(
            "offsets",
            "m and n anywhere in the images: the same in every scan and cycle; nothing is "
            "written beside the area",
            _shifts,
            same,
            reason_against,
        ),
        Relation(
            "size",
            "256 bytes instead of 48: the first 48 the same in every scan and cycle, the rest 0",
            _sizes,
            head_of,
            _uses_extension,
        ),
        Relation(
            "areas",
            "images of words instead of bytes, or the other way round: the same in every scan "
            "and cycle",
            _areas,
            same,
            reason_against,
        ),
        Relation(
            "scan time",
            "scan, RPI, T# literals, Interval, Margin, stimulus and the controller's delays and "
            "movements so many times as long: the same in the same scan, counted from the start; "
            "the end of a movement may be seen one scan earlier, since a controller cycle stays "
            "5 ms; the clock of the controller is not read",
            _scales,
            same_scans,
            _cuts,
            _without_clock,
        ),
        Relation(
            "engine",
            "matiec and the built-in engine: the same in every scan and cycle",
            _engines,
            same,
            _no_matiec,
        ),
        Relation(
            "link",
            "EtherNet/IP in lock-step instead of in process: the same in every scan and cycle",
            _links,
            same,
            reason_against,
        ),
    )
}
