"""Recordings as one page of HTML. The page contains all data and loads no other files."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from importlib.resources import files
from math import gcd
from typing import Any

from rcx_harness.spec.wire import AREA_SIZES, CYCLE_US
from rcx_harness.trace.records import Cycle, Record, Scan
from rcx_harness.trace.view.lanes import Group, Lane, Lanes, Variables, Wire
from rcx_harness.trace.view.pack import Numbers, Packed, Texts, put_whole
from rcx_harness.trace.view.programs import Programs
from rcx_harness.trace.view.robots import Robots
from rcx_harness.watch.sections import section_of
from structured_text.errors import InputError, Violation
from structured_text.projects.diagrams.networks.draw.svg import RULES

__all__ = ["SCRIPTS", "View"]

#: The scripts of the page; each script imports only from scripts before it.
SCRIPTS = (
    "data.js",
    "axis.js",
    "search.js",
    "draw.js",
    "chart.js",
    "robot.js",
    "robots.js",
    "listing.js",
    "programs.js",
    "networks.js",
    "play.js",
    "page.js",
)
#: If a number has more changes than this, it is drawn as a curve, and its changes are not events.
_OFTEN = 50
#: Greatest number of broken rules in the page. Further broken rules are only counted.
_MOST_RULES = 10_000
_MOST_CONTROLLERS = 64
_SIZES = (0, *AREA_SIZES)
#: Entries in the header of a trace that the page shows unchanged.
_TOLD = ("engine", "link", "seed", "by", "of")
#: Factor for positions, which are stored in thousandths.
_FINE = 1000
_MS = 1_000
_MODULE = re.compile(r"^import .*\n|^export ", re.MULTILINE)


class View:
    """The maker of a page from the records of a recording.

    Call `take` for each record, then `page`.

    Args:
        header: The header of the trace.
        networks: The drawn networks (`DrawnProgram.groups`). They become a part of the page as they
            are, so they must not come from a file.
    """

    def __init__(
        self, header: Mapping[str, Any], networks: Sequence[Mapping[str, Any]] = ()
    ) -> None:
        self._header, self._networks = header, networks
        self._lanes = Lanes()
        self._wires: dict[int, dict[type, Wire]] = {}
        self._rules = self._lanes.new("Rules broken", Texts(), "rule")
        self._sections: dict[int, str] = {}
        self.broken = self._scans = self._cycles = 0
        self._begin_us: int | None = None
        self._end_us = self._step_us = 0
        try:
            self._variables = Variables(self._lanes, header.get("watch", {}))
            self._cycle_us = int(header.get("cycle_us", CYCLE_US))
            titles = [[str(one) for one in names] for names in header.get("positions", [])]
        except (AttributeError, KeyError, TypeError, ValueError):
            raise InputError(
                "the header does not describe variables and times in a known form"
            ) from None
        self._positions = [
            [self._axis(title, who) for title in names] for who, names in enumerate(titles, 1)
        ]
        unit = "pulses" if any("[pulses]" in one for names in titles for one in names) else "mm"
        lanes = self._positions if "robots" in header else []
        try:
            self._robots = Robots(header.get("robots", []), lanes, unit)
        except (AttributeError, KeyError, TypeError, ValueError):
            raise InputError("the header does not describe the robots in a known form") from None
        try:
            self._programs = Programs(self._lanes, header.get("programs", []))
        except (AttributeError, KeyError, TypeError, ValueError):
            raise InputError(
                "the header does not describe the robot programs in a known form"
            ) from None

    def _axis(self, title: str, controller: int) -> Lane:
        who = f"{controller}: " if controller > 1 else ""
        more = {"show": {"fine": _FINE}, "is_curve": True, "rests": True}
        return self._lanes.new(f"{who}{title}", Numbers(), "curve", **more)

    def take(self, record: Record) -> None:
        """Add the next record of the recording."""
        if self._begin_us is None:
            self._begin_us = record.t_us
        self._end_us = max(self._end_us, record.t_us)
        self._step_us = gcd(self._step_us, record.t_us)
        if isinstance(record, Violation):
            self._take_rule(record)
            return
        if isinstance(record, Scan):
            self._scans += 1
            si, so = record.si, record.so
        else:
            self._cycles += 1
            si, so = record.rcx_si, record.rcx_so
        if len(si) not in _SIZES or len(so) not in _SIZES:
            raise InputError(
                f"areas of {len(so)} and {len(si)} bytes do not belong to a controller"
            )
        self._wire(record).take(record.t_us, si, so)
        try:
            if isinstance(record, Scan) and record.vars is not None:
                self._variables.take(record.t_us, record.vars)
            elif isinstance(record, Cycle) and record.positions is not None and self._positions:
                axes = self._positions[record.controller - 1]
                for lane, value in zip(axes, record.positions, strict=True):
                    self._lanes.note(lane, record.t_us, round(value * _FINE))
            if isinstance(record, Cycle) and record.poses is not None and "robots" in self._header:
                self._robots.take(record.t_us, record.controller, record.poses)
            if isinstance(record, Cycle) and record.tasks is not None:
                self._programs.take(record.t_us, record.controller, record.tasks)
        except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError):
            text = f"the values at {record.t_us} us are not those that the header describes"
            raise InputError(text) from None

    def _wire(self, record: Scan | Cycle) -> Wire:
        """Return the lanes for the controller and the side (PLC or controller) of a record."""
        sides = self._wires.get(record.controller)
        if sides is None:
            if not 1 <= record.controller <= _MOST_CONTROLLERS:
                raise InputError(f"there is no controller {record.controller}")
            sides = self._wires[record.controller] = {}
        kind = type(record)
        if kind not in sides:
            who = f"Controller {record.controller}: " if record.controller > 1 else ""
            is_plc = kind is Scan
            plain = is_plc or self._only_cycles
            sides[kind] = Wire(self._lanes, who, plain=plain, reads_outputs_first=is_plc)
        return sides[kind]

    @property
    def _only_cycles(self) -> bool:
        return bool(self._header.get("by") == "rcx serve")

    def _take_rule(self, one: Violation) -> None:
        self.broken += 1
        if self.broken <= _MOST_RULES:
            number = self._lanes.text(one.text)
            self._sections[number] = section_of(one.rule)
            self._lanes.add(self._rules, one.t_us, number)

    @property
    def is_empty(self) -> bool:
        """Return whether the recording has neither a scan nor a cycle."""
        return not self._wires

    def _groups(self) -> Iterator[Group]:
        if self.broken:
            yield Group("Rules", [self._rules])
        sides = [one for _, both in sorted(self._wires.items()) for one in both.values()]
        groups = [group for wire in sides for group in wire.groups()]
        others = list(self._variables.groups())
        yield from self._programs.groups()
        yield from (group for group in groups if group.open)
        yield from (group for group in others if group.open)
        for who, axes in enumerate(self._positions, 1):
            moving = [lane for lane in axes if lane.packed.first is not None]
            if moving:
                of = f"Controller {who}: " if len(self._positions) > 1 else ""
                yield Group(f"{of}Positions", moving)
                yield Group(f"{of}Speeds", [self._speed(lane) for lane in moving])
        yield from (group for group in [*others, *groups] if not group.open)

    def _speed(self, position: Lane) -> Lane:
        name = re.sub(
            r"(Position|Robot \d+) ", lambda found: f"{found[0]}speed ", position.name, count=1
        )
        name = re.sub(r"\[(.*)\]", r"[\1/s]", name).replace("Position speed", "Speed")
        return self._lanes.new(name, Packed(), "curve", is_curve=True, speed_of=position)

    def page(self, title: str) -> str:
        """Return the page. The same records give the same bytes."""
        content, style = (_asset(name) for name in ("page.html", "page.css"))
        script = "\n".join(_MODULE.sub("", _asset(name)) for name in SCRIPTS)
        filled = {
            "TITLE": escape(title),
            "STYLE": f"{style}{RULES}\n",
            "DATA": base64.b64encode(self._packed(title)).decode(),
            "SCRIPT": script,
        }
        return re.sub(r"@([A-Z]+)@", lambda found: filled[found[1]], content)

    def _packed(self, title: str) -> bytes:
        """Return the compressed data of the page: length of the table, table, changes."""
        groups = list(self._groups())
        shown = [lane for group in groups for lane in group.lanes]
        places = {id(lane): place for place, lane in enumerate(shown)}
        stream = bytearray()
        table = {
            "title": title,
            "about": self._about(),
            "begin": self._begin_us or 0,
            "end": max(self._end_us, (self._begin_us or 0) + 1),
            "cycle": self._cycle_us,
            "step": _MS if self._step_us % _MS == 0 else 1,
            "broken": self.broken,
            "texts": list(self._lanes.texts),
            "sections": self._sections,
            "robots": self._robots.table(places),
            "programs": self._programs.table(places),
            "networks": list(self._networks),
            "variables": self._variables.table(places) if self._networks else {},
            "groups": [
                {"title": one.title, "open": one.open, "lanes": [places[id(k)] for k in one.lanes]}
                for one in groups
            ],
            "lanes": [_entry(lane, stream, places) for lane in shown],
        }
        numbers = [places.get(id(lane), -1) for lane in self._lanes.every]
        kept = {self._lanes.number(k) for k in shown if not _is_curve(k)}
        order, told = bytearray(), 0
        for number in self._lanes.order:
            if number in kept:
                put_whole(order, numbers[number])
                told += 1
        table["order"] = {"at": len(stream), "count": told}
        text = json.dumps(table, ensure_ascii=False, separators=(",", ":")).encode(
            "utf-8", "replace"
        )
        head = bytearray(len(text).to_bytes(4, "little")) + text
        return zlib.compress(bytes(head + stream + order), 6)

    def _about(self) -> str:
        """Return one line of text about the recording and its origin."""
        known = self._header
        scans = "changes of the areas" if known.get("only") == "changes" else "scans"
        counts = ((self._scans, scans), (self._cycles, "controller cycles"))
        told = [f"{number:,} {what}" for number, what in counts if number]
        if isinstance(known.get("scan_us"), int):
            told.append(f"scan {known['scan_us'] / 1000:g} ms")
        if "size" in known:
            told.append(f"areas of {known['size']} bytes")
        told += [f"{key} {known[key]}" for key in _TOLD if key in known]
        return ", ".join(told)


def _is_curve(lane: Lane) -> bool:
    """Return whether a lane is drawn as a line: a curve, or a number with many changes."""
    number = lane.packed.form in ("whole", "real") and "digits" not in lane.show
    return lane.is_curve or (number and lane.packed.count > _OFTEN)


def _entry(lane: Lane, stream: bytearray, places: Mapping[int, int]) -> dict[str, Any]:
    """Return the entry of a lane in the table of the page; append its changes to the stream."""
    packed, at = lane.packed, len(stream)
    stream += packed.data
    entry: dict[str, Any] = {"name": lane.name, "colour": lane.colour, "form": packed.form}
    entry |= {"at": [at, len(packed.data)], "count": packed.count}
    first = packed.first
    finite = first is not None and first == first and abs(first) != float("inf")
    entry["first"] = first if finite or first is None else str(first)
    if lane.short:
        entry["short"] = lane.short
    if lane.idle is not None:
        entry["idle"] = lane.idle
    entry |= lane.show
    if _is_curve(lane):
        entry |= {"curve": True, "rests": lane.rests}
    if lane.speed_of is not None:
        entry["speedOf"] = places[id(lane.speed_of)]
    return entry


def _asset(name: str) -> str:
    return files(__package__).joinpath("page").joinpath(name).read_text(encoding="utf-8")
