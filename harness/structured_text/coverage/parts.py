"""The counts of several processes, combined; a part contains the counts of one process."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from structured_text.coverage.listing import Branch, Listed, Listing, Point, Text, listing
from structured_text.engines.builtin.collector import Collector, Counted, CountedText
from structured_text.errors import InputError
from structured_text.language.compiling import deeply

__all__ = ["CountedPou", "Merged", "Part", "Source", "merge", "part_of"]

#: The counts of one process, as JSON.
Part = Mapping[str, Any]


def part_of(collector: Collector) -> Part:
    """Return the counts of a collector, with the texts of files unchanged since compilation."""
    made = deeply(lambda: _Part(collector.counted, collector.texts))
    return {
        "files": made.files,
        "pous": made.pous,
        "changed": sorted(made.changed),
        "elsewhere": sorted(collector.elsewhere),
    }


class _Part:
    """The counts of one process while they are collected."""

    def __init__(self, counted: Iterable[Counted], texts: Iterable[CountedText] = ()) -> None:
        self.files: list[dict[str, Any]] = []
        self.pous: list[dict[str, Any]] = []
        self.changed: set[str] = set()
        self._texts: dict[tuple[str, tuple[Path, ...]], Text | None] = {}
        for one in counted:
            self._add(one)
        for text in texts:
            self._add_text(text)

    def _add(self, one: Counted) -> None:
        key = one.file, one.sources
        if key not in self._texts:
            self._texts[key] = self._text(one)
        text = self._texts[key]
        if text is None:
            self.changed.add(one.file)
            return
        found = listing(one.pou, one.plan, text)
        self.pous.append(
            {
                "file": one.file,
                "hash": one.hash,
                "counters": list(one.counts.counters),
                "seen": [sorted(seen) for seen in one.counts.seen],
                "pou": found.name,
                "line": found.line,
                "statements": found.statements,
                "branches": found.branches,
                "decisions": found.decisions,
            }
        )

    def _add_text(self, one: CountedText) -> None:
        """Add the counts of a program in another language than Structured Text."""
        if not _is_unchanged(one.file, one.hash):
            self.changed.add(one.file)
            return
        entry = {"file": one.file, "hash": one.hash}
        lines, reasons = list(one.lines.items()), list(one.reasons.items())
        self.files.append({**entry, "lines": lines, "reasons": reasons})
        self.pous.append(
            {
                **entry,
                "counters": list(one.counters),
                "seen": [],
                "pou": one.name,
                "line": one.line,
                "statements": list(one.statements),
                "branches": list(one.branches),
                "decisions": [],
            }
        )

    def _text(self, one: Counted) -> Text | None:
        """Return the text of a POU's file; None if the file has changed since it was compiled."""
        file = Path(one.file)
        try:
            if not _is_unchanged(one.file, one.hash):
                return None
            text = Text(file, one.sources)
        except (OSError, InputError):
            return None
        entry = {"file": one.file, "hash": one.hash, "networks": list(text.networks.items())}
        lines, reasons = list(text.lines.items()), list(text.reasons.items())
        self.files.append({**entry, "lines": lines, "reasons": reasons})
        return text


def _is_unchanged(file: str, before: str) -> bool:
    """Return whether a file exists and its content still has the hash `before`."""
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest() == before
    except OSError:
        return False


@dataclass
class CountedPou:
    """A POU with one count per sequence of statements, and the vectors of each decision."""

    listing: Listing
    counters: list[int]
    seen: list[set[int]]


@dataclass
class Source:
    """A version of a source file.

    Attributes:
        lines: The text of the file, by line number.
        reasons: The reasons why lines are unreachable, by line number.
        networks: The rungs or networks that lines were translated from, by line number.
        pous: The POUs. The key is the name with the numbers of counters and decisions, because
            constants of other files may change these numbers.
    """

    lines: dict[int, str] = field(default_factory=dict)
    reasons: dict[int, str] = field(default_factory=dict)
    networks: dict[int, str] = field(default_factory=dict)
    pous: dict[tuple[str, int, int], CountedPou] = field(default_factory=dict)


class Merged:
    """The counts of all processes.

    Attributes:
        files: The versions of each file by hash. A file that was changed has several versions.
        changed: Files that were changed or removed after they were compiled.
        elsewhere: Other engines that also ran programs, although they cannot count.
    """

    def __init__(self) -> None:
        self.files: dict[str, dict[str, Source]] = {}
        self.changed: set[str] = set()
        self.elsewhere: set[str] = set()

    def add(self, part: Part) -> None:
        """Add the counts of one process."""
        self.changed.update(part["changed"])
        self.elsewhere.update(part["elsewhere"])
        for one in part["files"]:
            source = self._source(one)
            source.lines |= dict(one["lines"])
            source.reasons |= dict(one["reasons"])
            source.networks |= dict(one.get("networks", ()))
        for one in part["pous"]:
            self._add(self._source(one).pous, one)

    def _source(self, one: Mapping[str, Any]) -> Source:
        return self.files.setdefault(one["file"], {}).setdefault(one["hash"], Source())

    def _add(self, pous: dict[tuple[str, int, int], CountedPou], one: Mapping[str, Any]) -> None:
        key = one["pou"], len(one["counters"]), sum(len(row[3]) for row in one["decisions"])
        if key not in pous:
            found = Listing(
                one["pou"],
                one["line"],
                [Point(*row) for row in one["statements"]],
                [Branch(*row) for row in one["branches"]],
                [Listed(*row) for row in one["decisions"]],
            )
            counters, seen = [0] * len(one["counters"]), [set[int]() for _ in one["seen"]]
            pous[key] = CountedPou(found, counters, seen)
        pou = pous[key]
        pou.counters[:] = map(sum, zip(pou.counters, one["counters"], strict=True))
        for every, vectors in zip(pou.seen, one["seen"], strict=True):
            every.update(vectors)


def merge(parts: Iterable[Part]) -> Merged:
    """Combine the parts of all processes."""
    merged = Merged()
    for part in parts:
        merged.add(part)
    return merged
