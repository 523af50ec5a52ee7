"""The drawn networks of a program for the page, and the values that show what was energised.

A trace does not have the drawings. `rcx run --view` knows the program and records its variables for
the page; `rcx view` gets the program from the user (`--program`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rcx_harness.trace.records import Record, Scan
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.language.displayed import described
from structured_text.language.scalars import ANY_INT, DIGITS
from structured_text.language.types import BlockType, ElementaryType, EnumType, Type
from structured_text.projects.diagrams.networks.draw.live import Found, edges_of, live_network
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.diagrams.networks.stored import lines_of

__all__ = ["DrawnProgram"]

#: Columns of a drawing; it is then about as wide as the chart of a window of 1400 pixels.
_WIDTH = 110
#: Greatest number of networks in a page. The networks of further instances are left out.
_MOST = 500
#: A bit of a variable: the variable and the number of the bit.
_BIT = re.compile(r"(.+)\.(\d{1,2})")
_NUMBERS = (*ANY_INT, *DIGITS)
_PATH = re.compile(r"[^\W\d]\w*(?:\.\w+|\[[\d, -]+\]|\^)*")


class DrawnProgram:
    """The networks of a running program.

    Args:
        program: The program.
        sources: Its sources; those of a project have their diagrams (`Extract.diagrams`).
    """

    def __init__(self, program: Program, sources: Sequence[Path]) -> None:
        self._program = program
        self._types: dict[str, Type] = {}
        self.groups: list[dict[str, Any]] = []
        """The diagrams with their networks, for the page."""
        count = 0
        for instance, title, source, owner, diagram in self._drawn(sources):
            count += len(diagram.networks)
            if count > _MOST:
                break
            self.groups.append(self._group(instance, title, source, owner, diagram))
        self._read = program.reader(list(self._types))

    def __bool__(self) -> bool:
        """Return whether the program has a network."""
        return bool(self.groups)

    def header(self, header: Mapping[str, Any]) -> dict[str, Any]:
        """Return the header of a trace, with the variables that the networks show."""
        watched = {path: described(kind) for path, kind in self._types.items()}
        return {**header, "watch": {**header.get("watch", {}), **watched}}

    def filled(self, record: Record) -> Record:
        """Return the record of the present scan with the values of these variables."""
        if not self._types or not isinstance(record, Scan) or record.controller > 1:
            return record
        own = dict(zip(self._types, self._read(), strict=True))
        return record._replace(vars={**(record.vars or {}), **own})

    def _drawn(self, sources: Sequence[Path]) -> Iterator[tuple[str, str, Path, str, Diagram]]:
        """Yield each diagram for each instance of its POU: path, title, source, owner, diagram."""
        instances: dict[str, list[str]] = {}
        found = [*self._program.instances().items(), *self._program.walk()]
        for path, kind in dict(found).items():
            if isinstance(kind, BlockType):
                instances.setdefault(kind.name.upper(), []).append(path)
        every = [
            (place, number, path, source, owner, diagram)
            for number, source in enumerate(sources)
            for owner, diagram in getattr(source, "diagrams", ())
            for place, path in enumerate(instances.get(owner.partition(".")[0].upper(), ()))
        ]
        for _, _, path, source, owner, diagram in sorted(
            every, key=lambda entry: (entry[2].count("."), entry[:2])
        ):
            part = owner.partition(".")[2]
            yield path, f"{path}.{part}" if part else path, source, owner, diagram

    def _group(
        self, instance: str, title: str, source: Path, owner: str, diagram: Diagram
    ) -> dict[str, Any]:
        def find(text: str) -> Found | None:
            return self._found(instance, text)

        number_of = len(self.groups) + 1
        networks = [
            live_network(
                diagram,
                network.number,
                find,
                edges_of(lines_of(source, owner, network.number)),
                width=_WIDTH,
                name=f"d{number_of}",
            )
            for network in diagram.networks
            if any(element.network == network.number for element in diagram.elements)
        ]
        for network in networks:
            for path in network.pop("paths"):
                self._record(path)
        return {"title": title, "networks": networks}

    def _record(self, path: str) -> None:
        """Record a variable; for a bit (`Main.Word.3`), record the whole variable."""
        bit = _BIT.fullmatch(path)
        recorded = bit[1] if bit else path
        self._types[recorded] = self._program.type_of(recorded)

    def _found(self, instance: str, text: str) -> Found | None:
        """Return a variable of an instance, or a global one."""
        name = text.strip()
        if not _PATH.fullmatch(name):
            return None
        bit = _BIT.fullmatch(name)
        for path in (f"{instance}.{name}", name):
            try:
                kind = self._program.type_of(path.removesuffix(f".{bit[2]}") if bit else path)
            except InputError:
                continue
            if bit:
                is_number = isinstance(kind, ElementaryType) and kind.name in _NUMBERS
                return Found(path, True, True) if is_number else None
            boolean = isinstance(kind, ElementaryType) and kind.name == "BOOL"
            shown = isinstance(kind, (ElementaryType, EnumType))
            return Found(path, boolean, shown)
        return None
