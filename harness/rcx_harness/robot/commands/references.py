"""Category 6: references, by which the controller reports its state (guide, 4.7)."""

from __future__ import annotations

from rcx_harness.robot.alarms import EMERGENCY_STOP, STOP, ActiveAlarm, CommandError, Place
from rcx_harness.robot.commands.base import Action, Call, Execution, Response, act, takes_time
from rcx_harness.robot.config.checks import alarm_code
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.program.task import RobotTask
from rcx_harness.robot.stored import AXES

_MM = 0x506
_DRIVERS = 4
_NO_AXIS = 9
_NO_SCARA = 9
_DESIGNATION = 0x50B
_OF_MAX = 0x510
_TYPES = {1: "incremental", 2: "absolute"}
_HALF = 8  # number of tasks in one response
_STOPPED, _RUNNING, _SUSPENDED, _STANDBY, _NO_TASK = 0, 1, 2, 3, 9
_NETWORK_GROUP = 12
_ETHERNET_IP = 0x0401  # unit number of an EtherNet/IP unit in an option slot
_CONTROLLER, _SLOT = 1, 3  # values of `kind` and `detail` of a Place


@act(0x501)
def read_version(machine: Machine, call: Call) -> Response:
    """Return the software versions (4.7.1); the version of an absent driver is 0."""
    config = machine.config
    present = min(len(config.axes), _DRIVERS)
    return {
        "host_version": config.host_version,
        "host_revision": config.host_revision,
        "fpga_version": config.fpga_version,
        "driver_versions": (config.driver_version,) * present,
    }


@act(0x502)
def read_configuration(machine: Machine, call: Call) -> Response:
    """Return the type of a robot and the types of its axes (4.7.2)."""
    types = tuple(axis.robot_type for axis in call.arm.axes)
    return {"robot_type": types[0], "axis_types": types}


@act(0x513)
def read_option_slots(machine: Machine, call: Call) -> Response:
    """Return the units in the option slots of the only controller (4.7.15)."""
    if call.values["controller"] != 1:
        raise CommandError(machine.config.absent_controller_alarm)
    return {"slots": machine.config.option_slots, "ivy2": machine.config.ivy2_unit}


@act(0x505, 0x506)
def read_position_once(machine: Machine, call: Call) -> Response:
    """Return the current position of a robot (4.7.4)."""
    mm = call.code == _MM
    values = {"positions": call.arm.shown(mm=mm)}
    if not mm:
        return values
    config = machine.config
    hand = config.position_hand and call.arm.scara
    return {
        **values,
        "flag_bit0": int(config.position_flag_bit0),
        "hand": call.arm.hand_system if hand else 0,
    }


@takes_time(0x505, 0x506)
def read_position(machine: Machine, call: Call) -> Execution:
    """Return the current position once, or in every cycle until the status reset (4.7.4)."""
    return _Continuous(call) if call.values["continuous"] else Action(machine, call)


class _Continuous(Execution):
    """The continuous output of the position, in every cycle until the status reset command."""

    stoppable = True

    def __init__(self, call: Call) -> None:
        self._call = call

    def step(self, machine: Machine) -> Response | None:
        return None

    def interim(self, machine: Machine) -> Response:
        return read_position_once(machine, self._call)


@act(0x503)
def read_servos(machine: Machine, call: Call) -> Response:
    """Return the servo state and the brake state of each axis (4.7.3)."""
    states = [machine.servos.states[index] for index in call.arm.indices]
    return {"servo_states": _six(states, _NO_AXIS)}


@act(0x50A, absent=True)
def read_speeds(machine: Machine, call: Call) -> Response:
    """Return automatic, manual and program speed (4.7.8); 0 for a robot without axes."""
    if not call.arm.axes:
        return {}
    names = ("auto_speed", "manual_speed", "program_speed")
    return {name: getattr(call.arm.settings, name) for name in names}


@act(0x50B, 0x50C, absent=True)
def read_arm(machine: Machine, call: Call) -> Response:
    """Return arm designation (4.7.9) or current arm (4.7.10); 0 for a robot without axes."""
    if not call.arm.axes:
        return {}
    if not call.arm.scara:
        return {"arm_state": _NO_SCARA}
    arm = call.arm
    return {"arm_state": arm.settings.arm if call.code == _DESIGNATION else arm.hand_system - 1}


@act(0x50F)
def read_origins(machine: Machine, call: Call) -> Response:
    """Return the origin state of each axis, or of the entire system (4.7.11)."""
    if not call.designated:
        return {"origin_states": int(machine.origin_complete)}
    every = call.arm.indices
    kind = _TYPES.get(call.values["motor_type"])
    asked = machine.config.axes_of_type(every, kind) if kind else every
    complete = machine.origins.complete
    states = [int(complete[index]) if index in asked else _NO_AXIS for index in every]
    return {"origin_states": _six(states, _NO_AXIS)}


@act(0x510, 0x516)
def read_torques(machine: Machine, call: Call) -> Response:
    """Return current torques relative to the maximum (4.7.12) or the rated torque (4.7.18).

    The torque is 0 for absent axes and for axes that were not selected.
    """
    every = call.arm.indices
    asked = call.values["axes"] or ~0
    chosen = [index for k, index in enumerate(every) if asked >> k & 1]
    torques = machine.data.torques
    read = torques.of_max if call.code == _OF_MAX else torques.of_rated
    values = [read(index) if index in chosen else 0 for index in every]
    return {"torques": _six(values, 0)}


@act(0x514)
def read_inching_amount(machine: Machine, call: Call) -> Response:
    """Return the inching amount (4.7.16)."""
    return {"amount": call.arm.settings.inching_amount}


@act(0x507)
def read_states(machine: Machine, call: Call) -> Response:
    """Return the states of eight tasks (4.7.5)."""
    return {"task_states": tuple(_task_state(machine, task) for task in _tasks(machine, call))}


@act(0x508)
def read_lines(machine: Machine, call: Call) -> Response:
    """Return the current lines of eight tasks (4.7.6); 0 for a task without a program."""
    return {"lines": tuple(task.line if task else 0 for task in _tasks(machine, call))}


@act(0x509)
def read_message(machine: Machine, call: Call) -> Response:
    """Return an entry of the alarm history (4.7.7)."""
    config, history = machine.config, machine.alarms.history
    number = call.values["message"]
    if number > len(history):
        if config.undefined_data_alarm:
            raise CommandError(config.undefined_data_alarm)
        return {}
    return _entry(machine, history[-number if config.newest_message_first else number - 1])


@act(0x515)
def read_latest(machine: Machine, call: Call) -> Response:
    """Return the latest alarm that ended a remote command (4.7.17); zeros if there is none."""
    latest = machine.alarms.latest_of_command
    return _entry(machine, latest) if latest else {}


@act(0x511)
def read_date(machine: Machine, call: Call) -> Response:
    """Return the date of the controller's clock (4.7.13)."""
    now = machine.data.clock.now(machine.now_us)
    return {"year": now.year % 100, "month": now.month, "day": now.day}


@act(0x512)
def read_time(machine: Machine, call: Call) -> Response:
    """Return the time of the controller's clock (4.7.14)."""
    now = machine.data.clock.now(machine.now_us)
    return {"hour": now.hour, "minute": now.minute, "second": now.second}


def _six(values: list[int], absent: int) -> tuple[int, ...]:
    """Return the values of the six axis fields; axes that do not exist get the value `absent`."""
    return tuple(values + [absent] * (AXES - len(values)))


def _tasks(machine: Machine, call: Call) -> list[RobotTask | None]:
    first = 1 + _HALF * call.values["task_range"]
    return [machine.program.in_task(number) for number in range(first, first + _HALF)]


def _task_state(machine: Machine, task: RobotTask | None) -> int:
    if task is None:
        return _NO_TASK
    if task.state == "running":
        return _STANDBY if task.waits and machine.config.waiting_is_standby else _RUNNING
    return _SUSPENDED if task.state == "suspended" else _STOPPED


def _entry(machine: Machine, alarm: ActiveAlarm) -> Response:
    group, category = alarm_code(alarm.number)
    place = alarm.place or _place(machine, alarm.number, group)
    return {
        "alarm_group": group,
        "alarm_category": category,
        "place": place.kind,
        "place_number": place.number,
        "detail": place.detail,
        "detail_number": place.detail_number,
    }


def _place(machine: Machine, number: str, group: int) -> Place:
    """Return the place of an alarm: controller 1, or its option slot (C1O1) for a network alarm."""
    slots = machine.config.option_slots
    of_network = group == _NETWORK_GROUP and number not in (EMERGENCY_STOP, STOP)
    if not of_network or _ETHERNET_IP not in slots:
        return Place(_CONTROLLER)
    return Place(_CONTROLLER, 1, _SLOT, slots.index(_ETHERNET_IP) + 1)
