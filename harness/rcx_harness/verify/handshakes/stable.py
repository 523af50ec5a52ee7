"""Data that must be stable while a strobe declares them valid, until they are acknowledged.

    [[stable]]
    name = "place"
    strobe = "SI(20)"
    data = ["SIW(2)"]
    acknowledge = "SO(20)"

The table works in both directions: the PLC sends data to the robot (SI, SIW), or the robot sends
data to the PLC (SO, SOW). Statements of the robot program are judged, too. The robot program may
read the PLC's data only while the strobe is ON. It may change its own data only while its strobe is
OFF or acknowledged.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcx_harness.robot.ports import Access, Ports, port, value_in
from rcx_harness.verify.handshakes.signals import bit_reader, bits_of, is_port, word_reader
from rcx_harness.verify.properties import Areas, Declared, Follower
from structured_text.bench import Bench
from structured_text.engines.base import Program
from structured_text.engines.conditions import Condition
from structured_text.errors import InputError
from structured_text.output.toml_files import check_keys, line_of

__all__ = ["StableData", "stable_in"]

_KEYS = ("name", "strobe", "data", "acknowledge", "before", "after", "controller")
_MOST_SCANS = 10_000
#: Greatest number of scans that a message states.
_SEVERAL = 3


@dataclass(frozen=True)
class StableData(Declared):
    """Data that do not change around the edge of a strobe, as declared by `[[stable]]`.

    Attributes:
        strobe: A port such as `SI(20)`, or a condition in Structured Text.
        data: Ports such as `SIW(2)`, or variables of the program.
        acknowledge: A port or a condition that ends the demand while the strobe is ON. Empty if
            there is no acknowledgement.
        scans_before: The data must be stable from this number of scans before the edge.
        scans_after: The demand ends this number of scans after the edge. With 0 it ends with the
            strobe.
        controller: The controller of the ports, from 1.
    """

    strobe: str = ""
    data: tuple[str, ...] = ()
    acknowledge: str = ""
    scans_before: int = 0
    scans_after: int = 0
    controller: int = 1

    @property
    def kind(self) -> str:
        """Return the kind of the failures that this property reports."""
        return f"stable {self.name}"

    @property
    def texts(self) -> tuple[str, ...]:
        """Return the conditions of this property in Structured Text."""
        return tuple(one for one in (self.strobe, self.acknowledge) if one and not is_port(one))

    def follow(
        self, made: Iterator[Condition], program: Program, cell: Bench | None, areas: Areas | None
    ) -> Follower:
        """Return the property, ready to be evaluated scan by scan."""
        try:
            return _Stable(self, made, program, cell, areas)
        except InputError as error:
            text = f"{self.name}: {error.message}"
            raise InputError(text, file=self.shown_file, hint=error.hint) from None


class _Stable:
    """The evaluation of a `StableData`, for each scan and for each access of a robot program."""

    has_before = False

    def __init__(
        self,
        declared: StableData,
        made: Iterator[Condition],
        program: Program,
        cell: Bench | None,
        areas: Areas | None,
    ) -> None:
        self.declared = declared
        at = declared.controller
        self._strobe, of_strobe = bit_reader(declared.strobe, made, areas, at)
        self._acknowledged: Callable[[], bool] = lambda: False
        of_acknowledge: tuple[str, ...] = ()
        if declared.acknowledge:
            self._acknowledged, of_acknowledge = bit_reader(declared.acknowledge, made, areas, at)
        self._data = [word_reader(one, program, areas, at) for one in declared.data]
        named = tuple(one for one in declared.data if not is_port(one))
        self.paths = (*of_strobe, *of_acknowledge, *named)
        self._statements = _Statements(declared, cell)
        self._said = ""
        self.forget()

    def forget(self) -> None:
        """Reset the memory of the property, because the program restarts."""
        self._was = True  # if the strobe is ON in the first scan, there is no edge
        self._history: tuple[tuple[Any, ...], ...] = ()
        self._valid: tuple[Any, ...] | None = None
        self._scans = 0
        self._reported: frozenset[str] = frozenset()

    def scan(self, now_us: int) -> bool:
        """Evaluate a scan, and return whether the data have changed while they must be stable."""
        del now_us
        told = [self._judged(), *self._statements.broken()]
        # A repeated statement is reported once. Otherwise a loop would report the statement in each
        # scan.
        new = [one for one in told if one and one not in self._reported]
        self._reported |= {one for one in new if one != told[0]}
        self._said = "; ".join(new)
        return bool(new)

    def _judged(self) -> str:
        declared = self.declared
        strobe, data = self._strobe(), tuple(read() for read in self._data)
        said = ""
        if strobe and not self._was:
            early = [then for then in self._history if then != data]
            if early:
                said = self._changed(early[-1], data, "before", len(self._history))
            self._valid, self._scans = data, 0
        elif not strobe:
            self._valid = None
        if self._valid is not None and self._acknowledged():
            self._valid = None
        if self._valid is not None and data != self._valid:
            said = self._changed(self._valid, data, "after", self._scans)
            self._valid = None
        self._scans += 1
        if declared.scans_after and self._scans > declared.scans_after:
            self._valid = None
        self._was = strobe
        if declared.scans_before:
            self._history = (*self._history, data)[-declared.scans_before :]
        return said

    def _changed(self, old: Sequence[Any], new: Sequence[Any], when: str, scans: int) -> str:
        """Return the data that changed, and the distance of the change to the edge in scans."""
        changes = ", ".join(
            f"{name} from {a} to {b}"
            for name, a, b in zip(self.declared.data, old, new, strict=True)
            if a != b
        )
        strobe = self.declared.strobe
        if when == "before":
            least = self.declared.scans_before
            return f"{changes}: changed less than {_scans(least)} before {strobe} became ON"
        wanted = self.declared.acknowledge
        until = f", before {wanted} has acknowledged it" if wanted else ""
        return f"{changes}: changed {_few_scans(scans)} after {strobe} became ON{until}"

    def told(self, program: Program) -> str:
        """Return the message about the data that have changed, with the time of the change."""
        del program
        return self._said

    def snapshot(self) -> object:
        """Return a snapshot of the memory of the property."""
        return self._was, self._history, self._valid, self._scans, self._reported

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the memory of the property."""
        self._was, self._history, self._valid, self._scans, self._reported = snapshot

    def memory(self, now_us: int) -> Hashable:
        """Return the memory of the property.

        Scan counts are limited to the largest count that has an effect.
        """
        del now_us
        counted = 0
        if self._valid is not None:
            counted = self._scans if self.declared.scans_after else min(self._scans, _SEVERAL)
        return self._was, self._history, self._valid, counted, self._reported

    def remember(self, memory: Any, now_us: int) -> None:
        """Restore the memory that `memory` returned."""
        del now_us
        self.restore(memory)


class _Statements:
    """The statements of robot programs that read or change the data of a `StableData`.

    The statements are judged only if data and strobe are ports of the same direction.
    """

    def __init__(self, declared: StableData, cell: Bench | None) -> None:
        self._declared = declared
        self._robots: Sequence[Any] = getattr(cell, "robots", ())
        self._strobe = port(declared.strobe) if is_port(declared.strobe) else None
        wanted = declared.acknowledge
        self._acknowledge = port(wanted) if is_port(wanted) else None
        self._judges_writes = self._acknowledge is not None or not wanted
        self._data = [port(one) for one in declared.data if is_port(one)]
        if self._strobe is not None and self._robots:
            self._data = [one for one in self._data if one.output == self._strobe.output]
            ports = self._ports()
            if ports.accesses is None and self._data:
                ports.accesses = []

    def _ports(self) -> Ports:
        ports: Ports = self._robots[self._declared.controller - 1].machine.ports
        return ports

    def broken(self) -> list[str]:
        """Return the messages about statements that broke the demand since the last scan."""
        if self._strobe is None or not self._robots or not self._data:
            return []
        recorded = self._ports().accesses or []
        return list(dict.fromkeys(filter(None, map(self._judged, recorded))))

    def _judged(self, access: Access) -> str:
        strobe = self._strobe
        assert strobe is not None
        touched = bits_of(access.place)
        name = next((one.name for one in self._data if touched & bits_of(one)), "")
        if not name:
            return ""
        where = f"robot program {access.program} %s {name} in line {access.line} while"
        if not strobe.output:
            if not access.changed and not value_in(strobe, access.inputs):
                return f"{where % 'reads'} {strobe.name} is OFF"
            return ""
        if not access.changed or not self._judges_writes or not value_in(strobe, access.outputs):
            return ""
        if self._acknowledge is not None:
            area = access.outputs if self._acknowledge.output else access.inputs
            if value_in(self._acknowledge, area):
                return ""
            return f"{where % 'changes'} {strobe.name} is ON and {self._acknowledge.name} is OFF"
        return f"{where % 'changes'} {strobe.name} is ON"


def _scans(count: int) -> str:
    return "1 scan" if count == 1 else f"{count} scans"


def _few_scans(count: int) -> str:
    return _scans(count) if count < _SEVERAL else f"{_SEVERAL} or more scans"


def stable_in(table: Mapping[str, Any], file: Path) -> list[StableData]:
    """Return the properties `[[stable]]` of a TOML file."""
    tables = table.get("stable", [])
    if not isinstance(tables, list) or not all(isinstance(one, dict) for one in tables):
        raise InputError("'stable' is not a list of tables", file=file, hint="write [[stable]]")
    found = []
    for number, one in enumerate(tables, 1):
        where, line = f"[[stable]] {number}", line_of(file, "stable", number)
        check_keys(one, _KEYS, where, file, every="keys are")
        for key in ("strobe", "data"):
            if key not in one:
                raise InputError(f"{where}: {key} is missing", file=file, line=line)
        for key in ("name", "strobe", "acknowledge"):
            if not isinstance(one.get(key, ""), str):
                raise InputError(f"{where}: {key} is not a text", file=file, line=line)
        given = one["data"] if isinstance(one["data"], list) else [one["data"]]
        if not given or not all(isinstance(name, str) for name in given):
            hint = 'write data = ["SIW(2)"]'
            raise InputError(f"{where}: data is not a list", file=file, line=line, hint=hint)
        numbers = {"before": 0, "after": 0, "controller": 1}
        for key, least in numbers.items():
            value = one.get(key, least)
            if type(value) is not int or not least <= value <= _MOST_SCANS:
                text = f"{where}: {key} is not a number from {least} to {_MOST_SCANS}"
                raise InputError(text, file=file, line=line)
            numbers[key] = value
        name = one.get("name", f"{', '.join(given)} with {one['strobe']}")
        found.append(
            StableData(
                name,
                "",
                file=str(file),
                strobe=one["strobe"],
                data=tuple(given),
                acknowledge=one.get("acknowledge", ""),
                scans_before=numbers["before"],
                scans_after=numbers["after"],
                controller=numbers["controller"],
            )
        )
    return found
