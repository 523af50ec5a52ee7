"""What a virtual controller is like: its size, axes, delays and the readings of the manual.

Every assumption the controller makes where the manual is silent has its knob here; rules.py says
which. Times are in milliseconds.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.config_checks import check_programs, check_value
from rcx_harness.spec import load_toml

__all__ = ["Axis", "Delay", "Point", "RobotConfig", "RobotProgram"]

#: Milliseconds, fixed or as (shortest, longest), drawn anew each time from the seed.
Delay = float | tuple[float, float]

AXES = 6
ROBOTS = 4
HIGHEST_POINT = 29999


@dataclass(frozen=True)
class Axis:
    """One axis. `pulses_per_mm` is per degree for a rotating axis; speeds are in pulses.

    `type` is `absolute`, `incremental` or `semi_absolute`; `origin_method` is `sensor`,
    `stroke_end` or `mark`.
    """

    robot: int = 1
    type: str = "absolute"
    origin_method: str = "sensor"
    pulses_per_mm: float = 1000.0
    max_speed: float = 1_000_000.0  # [pulses/s]
    max_acceleration: float = 5_000_000.0  # [pulses/s^2]
    soft_low: int = -1_000_000  # [pulses]
    soft_high: int = 1_000_000  # [pulses]
    start: int = 0  # position at power-on [pulses]
    motor_rotation: int = 16384  # [pulses per rotation of the motor]


@dataclass(frozen=True)
class Point:
    """Point data (guide, 4.3.1): `data` per axis as on the wire, pulses or 0.001 mm.

    `hand` is 0 (none), 1 (right-handed) or 2 (left-handed); `arm1` and `arm2` are -1, 0 or 1.
    """

    data: tuple[int, ...] = (0,) * AXES
    mm: bool = False
    hand: int = 0
    arm1: int = 0
    arm2: int = 0


#: The points of the manual's examples, so that they run without a robot file: the move to point 19
#: (guide, 2; its place is ours), to point 100 (4.2.1), the reference to point 50 (4.3.1).
_EXAMPLE_POINTS = {
    19: Point((120_000, -45_000, 30_000, 0, 0, 0)),
    50: Point((10_000, -20_000, 5_000, -18_000, 0, 0), mm=True),
    100: Point((123_456, -123, 0, 0, 0, 0)),
}


@dataclass(frozen=True)
class RobotProgram:
    """A robot program that runs `duration` ms, or does its `steps` (see script.py).

    Then it ends, or begins again if `loop`.
    """

    name: str = "MAIN"
    duration: float = 1000.0
    loop: bool = True
    steps: tuple[str, ...] = ()


#: Both inputs of a return-to-origin have something to do.
_AXES = (Axis(), Axis(), Axis(type="incremental"), Axis(type="incremental"))


@dataclass(frozen=True)
class RobotConfig:
    """A virtual controller's properties; immutable, shared between snapshots."""

    size: int = 48
    axes: tuple[Axis, ...] = _AXES
    points: Mapping[int, Point] = field(default_factory=lambda: dict(_EXAMPLE_POINTS))
    programs: tuple[RobotProgram, ...] = (RobotProgram(),)

    # State at power-on and of the surroundings
    booted: bool = True  # at time 0; boot_time counts from then on
    boot_time: Delay = 200.0
    link_error_delay: Delay = 100.0
    auto_mode: bool = True
    pendant_authority: bool = False
    safety_disables_inputs: bool = False
    origin_complete: bool = True
    program_is_reset: bool = False
    sequence_program: bool = True
    power_on_alarm: str = ""
    parallel_io: str = "none"  # none, valid, invalid
    parallel_stop: bool = True  # DI06 is ON
    ip_address: str = "set"  # set, none, duplicate

    # How long the controller takes
    emergency_stop_delay: Delay = 0.0
    emergency_release_delay: Delay = 5.0
    servo_on_delay: Delay = 50.0
    alarm_reset_delay: Delay = 20.0
    program_reset_delay: Delay = 20.0
    program_start_delay: Delay = 20.0
    program_stop_delay: Delay = 5.0
    sequence_delay: Delay = 5.0
    auto_mode_delay: Delay = 0.0
    origin_time: Delay = 500.0
    command_accept_delay: Delay = 0.0
    command_delay: Delay = 10.0
    status_reset_delay: Delay = 0.0

    # Dedicated inputs
    min_interval: float = 100.0
    late_levels: bool = True
    recovery_edges: bool = False
    power_on_emergency_alarm: bool = False
    mp_ready_in_emergency_stop: bool = True
    reset_in_emergency_stop: bool = False
    pendant_blocks_inputs: bool = True
    safety_keeps_stops: bool = True
    servo_on_with_alarm: bool = False
    program_needs_servo: bool = False
    reset_while_running: bool = False
    origin_needs_servo: bool = True
    origin_clears_complete: bool = True
    power_loses_origin: bool = True
    di17_mode: str = "ABS/ORG"  # ABS, ABS/ORG
    parallel_disables_si: bool = False

    # Robot programs and general-purpose ports
    running_shows_all_tasks: bool = True
    main_ends_tasks: bool = False
    reset_clears_outputs: bool = False
    loss_clears_inputs: bool = True
    program_words_between_commands: bool = True

    # Remote commands
    skip_run_status: str = "short"  # never, short, always
    strict_unused_words: bool = True
    changed_command_status: str = "run"  # run, ready
    auto_speed: int = 100  # [%]
    program_speed: int = 100  # [%]
    manual_speed: int = 20  # [%]
    inching_amount: int = 100  # [pulses or 0.001 mm]
    scara_robots: tuple[int, ...] = (1, 2, 3, 4)
    power_loses_settings: bool = False
    servo_needs_motor_power: bool = True
    semi_absolute_is_incremental: bool = True
    position_flag_bit0: bool = True
    unasked_positions_zero: bool = True
    host_version: int = 0x0108
    host_revision: int = 0x0030
    fpga_version: int = 0x1001
    driver_version: int = 0x0101

    # Alarms
    link_error_alarm: str = "12.551"
    link_loss_alarm: str = "12.552"
    link_error_latches: bool = False
    command_alarm_is_serious: bool = False
    alarm_stops_servo: bool = True
    minor_alarms: tuple[str, ...] = ("12.400",)
    power_restart_alarms: tuple[str, ...] = ("12.762", "12.763", "12.900", "12.904")
    module_fault_alarms: tuple[str, ...] = ("12.762", "12.900", "12.904")
    module_error_alarms: tuple[str, ...] = ("12.763",)
    alarm_history_length: int = 500
    format_alarm: str = "4.2"
    undefined_code_alarm: str = "4.2"
    absent_robot_alarm: str = "4.2"
    no_axis_alarm: str = "4.2"
    pendant_alarm: str = "4.2"
    motion_during_program: bool = True
    busy_alarm: str = "4.2"
    servo_off_alarm: str = "4.2"
    motor_power_alarm: str = "4.2"
    not_scara_alarm: str = "4.2"
    origin_method_alarm: str = "4.2"
    absolute_reset_alarm: str = "4.2"
    undefined_point_alarm: str = "4.2"

    def __post_init__(self) -> None:
        """Refuse values that no controller could have (InputError)."""
        for entry in fields(self):
            check_value(entry.name, str(entry.type), getattr(self, entry.name))
        check_programs(self.programs, self.size)

    def __deepcopy__(self, memo: object) -> RobotConfig:
        """Itself: it never changes, and snapshots are cheaper for it."""
        return self

    def axes_of(self, robot: int) -> tuple[int, ...]:
        """Indices into `axes` of robot 1 to 4; robot 0 is robot 1."""
        wanted = robot or 1
        return tuple(k for k, axis in enumerate(self.axes) if axis.robot == wanted)

    @classmethod
    def load(cls, path: str | Path) -> RobotConfig:
        """Read a robot file: keys as the fields of this class.

        Axes are `[[axes]]` tables, programs `[[programs]]` tables, points `[points.19]` tables with
        `mm = [...]` (numbers in mm) or `pulses = [...]`, `hand`, `arm1`, `arm2`.

        Raises:
            InputError: unreadable file, unknown key (near names are given) or impossible value.
        """
        file = Path(path)
        table = load_toml(file)
        try:
            values = {key: _read(cls, key, value) for key, value in table.items()}
            return cls(**values)
        except InputError as error:
            word = re.search(r"'([\w.]+)'", error.message)
            line = _line_of(file, word[1]) if word else None
            raise InputError(error.message, file=file, line=line, hint=error.hint) from error


def _read(kind: type[Any], key: str, value: Any) -> Any:
    """A TOML value as the field wants it."""
    _known(kind, key)
    if key == "axes":
        return tuple(_table(Axis, entry, key) for entry in _tables(value, key))
    if key == "programs":
        return tuple(_table(RobotProgram, entry, key) for entry in _tables(value, key))
    if key == "points":
        if not isinstance(value, dict):
            raise InputError("'points' must be tables", hint="write [points.19]")
        return dict(_point(number, entry) for number, entry in value.items())
    return tuple(value) if isinstance(value, list) else value


def _tables(value: Any, key: str) -> list[dict[str, Any]]:
    if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
        raise InputError(f"'{key}' must be tables", hint=f"write [[{key}]]")
    return value


def _table(kind: type[Any], entry: dict[str, Any], key: str) -> Any:
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in entry.items()}
    for name, value in values.items():
        _known(kind, name, f" in [[{key}]]")
        declared = next(str(one.type) for one in fields(kind) if one.name == name)
        check_value(name, declared, value)
    return kind(**values)


def _point(number: str, entry: Any) -> tuple[int, Point]:
    what = f"'points.{number}'"
    if not number.isdigit() or int(number) > HIGHEST_POINT or not isinstance(entry, dict):
        raise InputError(f"{what} is not a point", hint="write [points.0] to [points.29999]")
    known = ("mm", "pulses", "hand", "arm1", "arm2")
    for name in entry:
        if name not in known:
            raise InputError(f"unknown key '{name}' in {what}", hint=_near(name, known))
    given = [unit for unit in ("mm", "pulses") if unit in entry]
    if len(given) != 1:
        raise InputError(f"{what} needs either mm = [...] or pulses = [...]")
    data = entry[given[0]]
    if not isinstance(data, list) or len(data) > AXES or not all(map(_is_number, data)):
        raise InputError(f"{what} needs at most {AXES} numbers in {given[0]}")
    scale = 1000 if given[0] == "mm" else 1
    wire = [round(value * scale) for value in data] + [0] * (AXES - len(data))
    rest = {name: value for name, value in entry.items() if name not in ("mm", "pulses")}
    return int(number), Point(tuple(wire), mm=given[0] == "mm", **rest)


def _known(kind: type[Any], key: str, where: str = "") -> None:
    names = [entry.name for entry in fields(kind)]
    if key not in names:
        raise InputError(f"unknown key '{key}'{where}", hint=_near(key, names))


def _near(name: str, known: Any) -> str:
    near = get_close_matches(name, list(known))
    return f"did you mean {' or '.join(near)}" if near else "see docs/fidelity.md for the keys"


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _line_of(file: Path, key: str) -> int | None:
    """The line where `key` stands, as tomllib does not tell."""
    pattern = re.compile(rf"^\s*(\[+\s*)?{re.escape(key)}\b")
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        if pattern.match(line):
            return number
    return None
