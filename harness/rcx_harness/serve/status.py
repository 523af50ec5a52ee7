"""The reports that the process of a served controller sends, each as a line of JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

__all__ = ["Change", "CommandNote", "Connection", "Event", "Note", "Status"]


@dataclass(frozen=True)
class Change:
    """The state of the signals of the chart after a change.

    `si` and `so` are four bytes each in hexadecimal: word 0, then the two dedicated bytes.
    """

    t_us: int
    connected: bool
    si: str
    so: str


@dataclass(frozen=True)
class CommandNote:
    """A remote command: its request, and its result (empty while it runs)."""

    t_us: int
    request: str
    result: str = ""


@dataclass(frozen=True)
class Note:
    """A text with a time, such as a broken rule or an alarm."""

    t_us: int
    text: str


@dataclass(frozen=True)
class Event:
    """An event in words, with its time and kind.

    Kinds are connection, readers, refused, dropped, leds, alarms, commands, violations, skipped and
    lost. Each kind is throttled separately, so that a flood of one kind does not hide other kinds.
    """

    t_us: int
    kind: str
    text: str


@dataclass(frozen=True)
class Connection:
    """The master's connection: `state` is none, waiting, run, idle, timed out or closed.

    `peer` is the master's address. The packet intervals are in microseconds, 0 without a
    connection. `received` and `sent` count packets. `others` counts further connections, which only
    listen. `dropped` is a text about all packets dropped since the start, with reasons. `untaken`
    is the same text for the packets since a waiting master has opened its connection. `refused` is
    a sentence about the last refused connection; it is empty after a minute, or once a master has
    connected.
    """

    state: str = "none"
    peer: str = ""
    to_robot_us: int = 0
    to_master_us: int = 0
    received: int = 0
    sent: int = 0
    others: int = 0
    dropped: str = ""
    untaken: str = ""
    refused: str = ""


@dataclass(frozen=True)
class Status:
    """The state of a controller, and the changes since the previous report.

    `si` and `so` are the areas in hexadecimal; `si` is empty if the controller sees no connection.
    The LEDs have the values of `rcx_harness.robot.Led`. Positions are listed robot by robot, in
    pulses and in mm. `way` has the positions [pulses] during movements since the previous report,
    each after its time [us]. `poses` and `shapes` come from `rcx_harness.robot.shape`; `shapes` is
    empty if it has not changed. `tasks` and `listings` come from `rcx_harness.robot.listing`;
    `tasks` is empty if no robot program exists as source text, and `listings` is empty except in
    the first report. `workpieces` has the axis and the pulses of each workpiece, and `held` the
    outputs that are held or forced. `stalled` names the processes of the controller's network that
    give no sign of life. `events` are the events since the previous report.
    """

    t_us: int = 0
    cycles: int = 0
    skipped: int = 0
    connection: Connection = field(default_factory=Connection)
    si: str = ""
    so: str = ""
    module_led: str = "off"
    network_led: str = "off"
    powered: bool = True
    online: bool = True
    link_cut: bool = False
    emergency_stop: bool = False
    pendant: bool = False
    auto_switch: bool = True
    warning: bool = False
    main_power: bool = True
    safety: bool = False
    parallel_stop: bool = True
    held: tuple[str, ...] = ()
    workpieces: tuple[tuple[int, int], ...] = ()
    recording: bool = False
    recorded: int = 0
    positions: tuple[int, ...] = ()
    mm: tuple[float, ...] = ()
    way: tuple[tuple[int, ...], ...] = ()
    poses: tuple[dict[str, Any], ...] = ()
    shapes: tuple[dict[str, Any], ...] = ()
    tasks: tuple[dict[str, Any], ...] = ()
    listings: tuple[dict[str, Any], ...] = ()
    alarms: tuple[str, ...] = ()
    executed: int = 0
    commands: tuple[CommandNote, ...] = ()
    violation_count: int = 0
    violations: tuple[Note, ...] = ()
    changes: tuple[Change, ...] = ()
    stalled: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()

    def to_json(self) -> str:
        """Return the report as one line, without a line feed at the end."""
        return json.dumps(asdict(self), separators=(",", ":"), ensure_ascii=False)

    @classmethod
    def from_table(cls, message: Mapping[str, Any]) -> Status:
        """Create the report from the JSON object that `to_json` has written."""
        table = dict(message)
        kinds: dict[str, type[Any]] = {
            "commands": CommandNote,
            "violations": Note,
            "changes": Change,
            "events": Event,
        }
        for name, kind in kinds.items():
            table[name] = tuple(kind(**entry) for entry in table[name])
        table["connection"] = Connection(**table["connection"])
        for name in ("positions", "mm", "poses", "shapes", "tasks", "listings"):
            table[name] = tuple(table[name])
        for name in ("alarms", "held", "stalled"):
            table[name] = tuple(table[name])
        table["way"] = tuple(tuple(sample) for sample in table["way"])
        table["workpieces"] = tuple((axis, at) for axis, at in table["workpieces"])
        return cls(**table)
