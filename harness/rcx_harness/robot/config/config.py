"""The properties of a virtual controller by section; each property is a key of the robot file.

Where the manual is silent, a property selects the behaviour; spec/rules.toml lists these
properties. Times are in milliseconds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_harness.robot.config.checks import STORED, check_programs, check_stored, check_value
from rcx_harness.robot.config.file import NO_KEY, read_value
from rcx_harness.robot.config.models import merged, model_of
from rcx_harness.robot.config.programs import Brought, brought
from rcx_harness.robot.stored import EXAMPLE_POINTS, Hand, Pallet, Point, Shift
from rcx_harness.spec.robots import RobotModel
from rcx_harness.spec.wire import SIZE
from structured_text.errors import InputError
from structured_text.output.toml_files import line_of, parse_toml, toml_text

__all__ = [
    "SECTIONS",
    "Axis",
    "Delay",
    "Motion",
    "Programs",
    "References",
    "Robot",
    "RobotConfig",
    "RobotProgram",
]

#: A delay in milliseconds: a fixed number, or a range (shortest, longest). A range is drawn anew
#: from the seed for each delay.
Delay = float | tuple[float, float]
#: A corner of a work area: X, Y and optionally Z [mm].
Corner = tuple[float, ...]


@dataclass(frozen=True)
class Axis:
    """One axis. For a rotating axis, `pulses_per_mm` is per degree. Speeds are in pulses/s.

    `max_acceleration` is the acceleration without a load, if the robot has a model.

    `type` is `absolute`, `incremental` or `semi_absolute`; `origin_method` is `sensor`,
    `stroke_end` or `mark`.
    """

    robot: int = 1
    type: str = "absolute"
    origin_method: str = "sensor"
    pulses_per_mm: float = 1000.0
    zero: int = 0  # position at 0 mm or 0 degrees [pulses]
    max_speed: float = 1_000_000.0  # [pulses/s]
    max_acceleration: float = 5_000_000.0  # [pulses/s^2]
    soft_low: int = -1_000_000  # [pulses]
    soft_high: int = 1_000_000  # [pulses]
    start: int = 0  # position at power-on [pulses]
    motor_rotation: int = 16384  # [pulses per rotation of the motor]
    robot_type: int = 2000  # number of the robot's type; 2000 is a YK250X
    holding_torque: int = 0  # torque at rest with the servo on [% of the maximum]
    moving_torque: int = 10  # extra torque in a movement, in its direction [% of the maximum]
    rated_torque: int = 20  # [% of the maximum torque]
    workpiece: int | None = None  # position of a workpiece that stops PUSH [pulses]


@dataclass(frozen=True)
class RobotProgram:
    """A robot program: a text in the robot language, `steps` in it, or a `duration` in ms.

    If `loop` is set, steps and durations are repeated. A text is never repeated. `file` is the file
    of the text (.PGM), relative to the robot file.

    `path` and `offset` are not keys of a robot file; `RobotConfig.load` sets them. `path` is the
    absolute path of the file with the text (.PGM or .ALL), and `offset` the number of lines of that
    file before the program.
    """

    name: str = "MAIN"
    duration: float = 1000.0
    loop: bool = True
    steps: tuple[str, ...] = ()
    file: str = ""
    text: str = ""
    path: str = field(default="", compare=False, repr=False, metadata=NO_KEY)
    offset: int = field(default=0, compare=False, repr=False, metadata=NO_KEY)

    @property
    def has_code(self) -> bool:
        """Return whether the program has statements; a program with only a duration has none."""
        return bool(self.steps or self.text)

    @property
    def begins_again(self) -> bool:
        """Return whether the program begins again at its end."""
        return self.loop and not self.text


#: The default axes. They have two types, so that both inputs for a return-to-origin have an effect.
_AXES = (Axis(), Axis(), Axis(type="incremental"), Axis(type="incremental"))


@dataclass(frozen=True)
class Robot:
    """Size of the areas, axes and programs."""

    size: int = SIZE
    robot: tuple[str, ...] = ()  # models of robots 1, 2 ...; a text if there is only one
    axes: tuple[Axis, ...] = _AXES
    scara_robots: tuple[int, ...] = (1, 2, 3, 4)
    programs: tuple[RobotProgram, ...] = (RobotProgram(),)
    # Two opposite corners of each area by its name [mm]; the areas are only drawn in charts.
    work_areas: Mapping[str, tuple[Corner, Corner]] = field(default_factory=dict)


@dataclass(frozen=True)
class StoredData:
    """Stored data at the start; remote commands change them."""

    points: Mapping[int, Point] = field(default_factory=lambda: dict(EXAMPLE_POINTS))
    comments: Mapping[int, str] = field(default_factory=dict)
    pallets: Mapping[int, Pallet] = field(default_factory=dict)
    shifts: Mapping[int, Shift] = field(default_factory=dict)
    hands: Mapping[tuple[int, int], Hand] = field(default_factory=dict)  # by robot and hand number
    variables: Mapping[str, float] = field(default_factory=dict)  # by name, such as SGI5 or SGR5
    parameters: Mapping[str, int | tuple[int, ...]] = field(default_factory=dict)
    comment_filler: str = "zeros"  # zeros, spaces
    real_to_integer: str = "round"  # round, truncate
    several_elements: bool = True
    max_payload: int = 50  # [kg]


@dataclass(frozen=True)
class PowerAndLink:
    """State at power-on, state of the surroundings, and effects of a loss of power or link."""

    booted: bool = True  # whether the power is on at time 0, where boot_time begins
    auto_mode: bool = True
    pendant_authority: bool = False
    safety_disables_inputs: bool = False
    origin_complete: bool = True
    program_is_reset: bool = False
    sequence_program: bool = True
    parallel_io: str = "none"  # none, valid, invalid
    parallel_stop: bool = True  # whether the stop input DI06 is ON
    ip_address: str = "set"  # set, none, duplicate
    idle_header: str = "loss"  # loss, hold
    loss_clears_inputs: bool = True
    power_loses_origin: bool = True
    power_loses_settings: bool = False
    power_clears_internal_outputs: bool = True
    power_clears_variables: bool = False  # whether SGI0 to SGI31, SGR0 to SGR31 are cleared


@dataclass(frozen=True)
class Timing:
    """Times that the controller takes."""

    boot_time: Delay = 200.0
    link_error_delay: Delay = 100.0
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


@dataclass(frozen=True)
class DedicatedSignals:
    """Effects of the dedicated inputs, and the conditions that block these inputs."""

    min_interval: float = 100.0
    late_levels: bool = True
    recovery_edges: bool = False
    mp_ready_in_emergency_stop: bool = True
    reset_in_emergency_stop: bool = False
    pendant_blocks_inputs: bool = True
    safety_keeps_stops: bool = True
    parallel_disables_si: bool = False
    servo_on_with_alarm: bool = False
    servo_off_brakes_free_axes: bool = True
    emergency_stops_sequence: bool = False
    reset_clears_warning: bool = False
    origin_needs_servo: bool = True
    origin_clears_complete: bool = True
    di17_mode: str = "ABS/ORG"  # ABS, ABS/ORG


@dataclass(frozen=True)
class Programs:
    """Robot programs and general-purpose ports."""

    start_needs_auto: bool = True
    program_needs_servo: bool = False
    restart_begins_anew: bool = False
    reset_while_running: bool = False
    motor_power_stops_program: bool = True
    manual_mode_stops_program: bool = True
    running_shows_all_tasks: bool = True
    main_ends_tasks: bool = False
    reset_clears_outputs: bool = False
    program_words_between_commands: bool = True
    waiting_is_standby: bool = True
    program_info_while_running: bool = True
    program_statements: int = 100  # greatest number of statements of a task in a controller cycle
    program_stack: int = 20  # greatest depth of nested GOSUB and CALL
    plain_variables: str = "real"  # type of variables without %, ! or $: real or integer
    tcounter_ms: int = 1  # unit of the function TCOUNTER [ms]
    program_error_stops_all: bool = True
    program_error_is_serious: bool = False
    name_filler: str = "spaces"  # zeros, spaces


@dataclass(frozen=True)
class Commands:
    """The handshake of remote commands."""

    first_image_commands: bool = True
    skip_run_status: str = "short"  # never, short, always
    strict_unused_words: bool = True
    changed_command_status: str = "run"  # run, ready
    data_belong_to_command: bool = True
    early_command_waits: bool = False


@dataclass(frozen=True)
class Motion:
    """Speeds and movements."""

    auto_speed: int = 100  # [%]
    program_speed: int = 100  # [%]
    manual_speed: int = 20  # [%]
    inching_amount: int = 100  # [pulses or 0.001 mm]
    movei_start_position: str = "keep"  # keep, reset
    end_in_tolerance: bool = False
    jog_limit: str = "alarm"  # alarm, normal
    arch_zero_is_parameter: bool = False
    outer_angle: float = 3.0  # smallest angle of axis 2 on lines and arcs, else an alarm [degree]
    motion_during_program: bool = True
    servo_needs_motor_power: bool = True
    semi_absolute_is_incremental: bool = True


@dataclass(frozen=True)
class References:
    """Data that commands read: position, clock, versions, real time output."""

    unasked_positions_zero: bool = True
    position_flag_bit0: bool = True
    position_hand: bool = False
    clock: str = "2014-01-01 10:59:59"  # date and time at time 0
    option_slots: tuple[int, ...] = (0x0401, 0x0100, 0, 0)
    ivy2_unit: int = 0
    newest_message_first: bool = True
    motor_data_of_all_robots: bool = False
    real_time_items: Mapping[int, str] = field(default_factory=lambda: {13: "motor_duty"})
    real_time_interval: float = 5.0  # [ms]
    host_version: int = 0x0108
    host_revision: int = 0x0030
    fpga_version: int = 0x1001
    driver_version: int = 0x0101


@dataclass(frozen=True)
class Alarms:
    """Behaviour of alarms, and the numbers of alarms that the manual does not give."""

    power_on_alarm: str = ""
    power_on_emergency_alarm: bool = False
    link_error_alarm: str = "12.551"
    link_loss_alarm: str = "12.552"
    link_error_latches: bool = False
    command_alarm_is_serious: bool = False
    alarm_stops_servo: bool = True
    minor_alarms: tuple[str, ...] = ("12.400",)
    power_restart_alarms: tuple[str, ...] = ("12.762", "12.763", "12.900", "12.904")
    module_fault_alarms: tuple[str, ...] = ("12.762", "12.900", "12.904")
    module_error_alarms: tuple[str, ...] = ("12.763",)
    cpu_fault_alarms: tuple[str, ...] = ()
    main_power_alarm: str = ""
    alarm_history_length: int = 500
    format_alarm: str = "4.2"
    undefined_code_alarm: str = "12.75"
    absent_robot_alarm: str = "4.204"
    no_axis_alarm: str = "4.205"
    pendant_alarm: str = "12.76"
    busy_alarm: str = "6.281"
    moving_alarm: str = "6.282"
    servo_off_alarm: str = "6.301"
    motor_power_alarm: str = "6.300"
    not_scara_alarm: str = "4.2"
    out_of_reach_alarm: str = "2.335"
    outer_range_alarm: str = "2.352"
    to_left_alarm: str = "2.319"
    to_right_alarm: str = "2.320"
    drive_xy_alarm: str = "2.337"
    origin_method_alarm: str = "6.317"
    absolute_reset_alarm: str = "6.312"
    undefined_program_alarm: str = "3.203"
    undefined_task_alarm: str = "6.262"
    manual_mode_alarm: str = "0.20"
    absent_controller_alarm: str = "4.213"
    impossible_date_alarm: str = "4.2"
    undefined_point_alarm: str = "6.204"
    no_circle_alarm: str = "2.330"
    undefined_pallet_alarm: str = "6.236"
    # for undefined comments, shifts, hands, messages; empty: they read as 0 or nothing
    undefined_data_alarm: str = ""
    work_position_alarm: str = "6.283"
    point_unit_alarm: str = "6.205"
    overflow_alarm: str = "6.252"
    division_alarm: str = "6.203"
    program_type_alarm: str = "5.999"
    program_stack_alarm: str = "5.998"
    program_path_alarm: str = "5.997"


#: Maps each key that is a list of tables to the class of these tables.
_TABLES: dict[str, type] = {"axes": Axis, "programs": RobotProgram}


@dataclass(frozen=True)
class RobotConfig(  # the field order of a dataclass begins with its last base class
    Alarms,
    References,
    Motion,
    Commands,
    Programs,
    DedicatedSignals,
    Timing,
    PowerAndLink,
    StoredData,
    Robot,
):
    """The properties of a virtual controller. They are immutable, so all snapshots share them."""

    def __post_init__(self) -> None:
        """Raise InputError if a value is invalid."""
        if isinstance(self.robot, str):
            object.__setattr__(self, "robot", (self.robot,))
        if self.robot and self.axes is _AXES:
            axes = tuple(Axis(**keys) for keys in merged(self.robot, ()))
            object.__setattr__(self, "axes", axes)
        for entry in fields(self):
            if entry.name in STORED:
                check_stored(entry.name, getattr(self, entry.name), len(self.axes))
            else:
                check_value(entry.name, str(entry.type), getattr(self, entry.name))
        check_programs(self.programs, self.size, self.plain_variables)

    def __deepcopy__(self, memo: object) -> RobotConfig:
        """Return the object itself. It never changes, so a snapshot needs no copy."""
        return self

    def axes_of(self, robot: int) -> tuple[int, ...]:
        """Return the indices into `axes` of the axes of robot 1 to 4; 0 means robot 1."""
        wanted = robot or 1
        return tuple(k for k, axis in enumerate(self.axes) if axis.robot == wanted)

    def axes_of_type(self, indices: Iterable[int], kind: str) -> tuple[int, ...]:
        """Return the axes that remote commands treat as `absolute` or `incremental`."""
        kinds = {kind}
        if kind == "incremental" and self.semi_absolute_is_incremental:
            kinds.add("semi_absolute")
        return tuple(index for index in indices if self.axes[index].type in kinds)

    def model(self, robot: int) -> RobotModel | None:
        """Return the model of robot 1 to 4, or None if the robot file names none."""
        return model_of(self.robot[robot - 1]) if robot <= len(self.robot) else None

    @property
    def workpieces(self) -> Mapping[int, int]:
        """Return the positions of the workpieces for PUSH [pulses], by the index into `axes`."""
        given = ((index, axis.workpiece) for index, axis in enumerate(self.axes))
        return {index: place for index, place in given if place is not None}

    @classmethod
    def load(cls, path: str | Path) -> RobotConfig:
        """Read a robot file; its keys are the fields of this class.

        Axes are `[[axes]]` tables, programs `[[programs]]` tables. For the form of points and other
        stored data see config/file.py.
        """
        file = Path(path)
        text = toml_text(file)
        if "data_file" in text or "file" in text:
            return _configured(file, parse_toml(text, file))
        return _loaded(file, text)


@lru_cache(maxsize=64)
def _loaded(file: Path, text: str) -> RobotConfig:
    """Return the properties from the text of a robot file; cached, because they never change."""
    return _configured(file, parse_toml(text, file))


def _configured(file: Path, table: dict[str, Any]) -> RobotConfig:
    """Return the properties from the table of a robot file and from the files that it names."""
    others = brought(file, table)
    if others.programs:
        table["programs"] = list(others.programs)
    try:
        table = _with_models(table)
        values = {key: read_value(RobotConfig, key, value, _TABLES) for key, value in table.items()}
        for key, data in others.data.items():
            values[key] = {**data, **values.get(key, {})}
        if "programs" in values:
            values["programs"] = tuple(_placed(one, others) for one in values["programs"])
        if others.parameters:
            listed = others.listed(len(RobotConfig(**values).axes))
            values["parameters"] = {**listed, **values.get("parameters", {})}
        return RobotConfig(**values)
    except InputError as error:
        if error.file:  # a program in a separate file
            raise InputError(
                error.message, file=file.parent / error.file, line=error.line, hint=error.hint
            ) from error
        quoted = re.search(r"'([^']+)'", error.message)
        line = line_of(file, quoted[1]) if quoted else None
        raise InputError(error.message, file=file, line=line, hint=error.hint) from error


def _placed(program: RobotProgram, others: Brought) -> RobotProgram:
    """Return the program; if its text is in a separate file, with `path` and `offset` set."""
    path, offset = others.places.get(program.name, ("", 0))
    return replace(program, path=path, offset=offset) if path else program


def _with_models(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the table whose `[[axes]]` are completed from the robot models."""
    names, axes = table.get("robot", ()), table.get("axes", [])
    names = [names] if isinstance(names, str) else names
    check_value("robot", "models", tuple(names) if isinstance(names, list) else names)
    plain = isinstance(axes, list) and all(isinstance(entry, dict) for entry in axes)
    if not names or not plain:  # read_value reports the error
        return dict(table)
    return {**table, "robot": names, "axes": merged(names, axes)}


#: The sections of the properties, in the order of their fields.
SECTIONS: tuple[type, ...] = tuple(reversed(RobotConfig.__bases__))
