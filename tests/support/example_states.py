"""Controllers in the states of the worked examples, and their data after an example.

The head of tests/data/worked_examples.toml explains the keys. All of these robots have 1000 pulses
per millimetre, so 0.001 mm is one pulse.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from rcx_harness.robot import Axis, Point, RobotConfig, RobotProgram
from rcx_harness.robot.alarms import Place
from rcx_harness.robot.data import Definition
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.ports import port
from rcx_harness.robot.stored import Hand, Pallet
from robot_master import Master

#: Number of lines of every program. No program ends within a test.
_STEPS = ("DELAY 60000",) * 120
_ARMS = ("right", "left")
_PARAMETERS = {259: "TOLE", 260: "OUTPOS"}
_PLACES = {"C1O1": Place(1, 1, 3, 1)}
#: A position between two quarters of the motor's rotation, which are 4096 pulses each.
_BETWEEN_QUARTERS = 5000

#: Keys of a state that are fields of RobotConfig with the same name.
_SAME_NAME = ("inching_amount", "auto_speed", "manual_speed", "program_speed")


def example_config(state: Mapping[str, Any], **knobs: Any) -> RobotConfig:
    """Return a configuration whose stored data are those of a state.

    Args:
        state: State of an example.
        knobs: More fields of RobotConfig.
    """
    given: dict[str, Any] = {key: state[key] for key in _SAME_NAME if key in state}
    given["axes"] = tuple(_axis(state, number) for number in range(1, state.get("axes", 4) + 1))
    given["scara_robots"] = (1,) if state.get("scara") else ()
    given["points"] = {int(n): _point(entry) for n, entry in state.get("points", {}).items()}
    given["comments"] = {int(n): text for n, text in state.get("comments", {}).items()}
    given["pallets"] = {
        int(n): Pallet(one["nx"], one["ny"], one["nz"], one["first_point"])
        for n, one in state.get("pallets", {}).items()
    }
    given["shifts"] = {int(n): _thousand(data) for n, data in state.get("shifts", {}).items()}
    given["hands"] = {(1, int(n)): _hand(entry) for n, entry in state.get("hands", {}).items()}
    given["variables"] = {f"SGI{n}": value for n, value in state.get("variables", {}).items()}
    given["programs"] = _programs(state)
    if "option_slots" in state:
        given["option_slots"] = tuple(state["option_slots"])
    return RobotConfig(**{**given, **knobs})


def in_state(state: Mapping[str, Any], **knobs: Any) -> Master:
    """Return a master whose controller is in this state.

    By default it is powered up with the servos on.
    """
    config = example_config(state, **knobs)
    master = Master(**{name: getattr(config, name) for name in config.__dataclass_fields__})
    if state.get("motor_power") == "off":
        master.power_up()
    else:
        master.servo_on()
    for key, value in state.items():
        if key in _SET:
            _SET[key](master, value)
    return master


def found(master: Master, effect: Mapping[str, Any]) -> dict[str, Any]:
    """Return the controller's data for the keys of `effect`, in the notation of `effect`."""
    master.run(100)
    return {key: _FOUND[key](master.robot.machine, value) for key, value in effect.items()}


def _axis(state: Mapping[str, Any], number: int) -> Axis:
    text = str(number)
    marked = number in state.get("mark_axes", ())
    at_reset = number in state.get("at_reset_position", ())
    axis = Axis(
        type="absolute" if number < 3 else "incremental",
        origin_method="mark" if marked else "sensor",
        start=_BETWEEN_QUARTERS if marked and not at_reset else 0,
        robot_type=state.get("robot_type", 2000),
        holding_torque=state.get("max_torque_percent", {}).get(text, 0),
    )
    workpiece = state.get("workpiece", {})
    if workpiece.get("axis") == number:
        place = workpiece["pulses"] if "pulses" in workpiece else round(1000 * workpiece["mm"])
        axis = replace(axis, workpiece=place)
    if rated := state.get("rated_torque_percent", {}).get(text):
        axis = replace(axis, holding_torque=20, rated_torque=2000 // rated)
    return axis


def _thousand(mm: list[float]) -> tuple[Any, ...]:
    return tuple(round(1000 * value) for value in mm)


def _point(entry: Mapping[str, Any]) -> Point:
    data = _thousand(entry["mm"]) if "mm" in entry else tuple(entry["pulses"])
    return Point(data + (0,) * (6 - len(data)), mm="mm" in entry)


def _hand(entry: Mapping[str, Any]) -> Hand:
    one, two, three = _thousand(entry["data_mm"])
    return Hand((one, two, three, int(entry["on_r_axis"])))


def _programs(state: Mapping[str, Any]) -> tuple[RobotProgram, ...]:
    names = state.get("programs") or {str(k + 1): f"P{k}" for k in range(5)}
    return tuple(RobotProgram(names[str(k + 1)], steps=_STEPS) for k in range(len(names)))


def _register(master: Master, entries: list[Mapping[str, Any]]) -> None:
    machine = master.robot.machine
    for task in machine.program.tasks:
        task.number = 0
    for k, entry in enumerate(entries, 1):
        task = machine.program.tasks[entry.get("program", k) - 1]
        task.number, task.priority = entry["task"], entry.get("priority", 32)
        task.at = entry.get("line", 1) - 1
        status = entry.get("status", "stopped" if task.at else "ready")
        task.state = "stopped" if status == "running" else status
        if status == "running":
            task.go(machine.now_us)


def _set_history(master: Master, entries: Mapping[str, Mapping[str, str]]) -> None:
    """Raise the alarms of this history. If entry 10 is given, raise nine other alarms after it."""
    alarms = master.robot.alarms
    for number, entry in entries.items():
        alarms.note(entry["alarm"], master.now_us)
        for _ in range(int(number) - 1):
            alarms.note("99.9", master.now_us)


def _make_latest_alarm(master: Master, entry: Mapping[str, str]) -> None:
    """Send axis 1 of robot 1 beyond its soft limit."""
    assert entry == {"alarm": "2.334", "place": "R1A1"}
    answer = master.execute(0x0007, 0x0001, 0x0001, 0, 0, 0x7FFF)
    assert answer[:3] == (0x4000, 2, 334)


def _set_ports(master: Master, entries: Mapping[str, int]) -> None:
    ports = master.robot.machine.ports
    for name, value in entries.items():
        place = port(name)
        (ports.write if place.output else ports.set_input)(place, value)


def _set_parameters(master: Master, entries: list[Mapping[str, int]]) -> None:
    parameters = master.robot.machine.memory.parameters
    for one in entries:
        parameters.set(1, _PARAMETERS[one["number"]], one["value"], one["axis"] - 1)


def _set_real_time(master: Master, entries: Mapping[str, Mapping[str, int]]) -> None:
    for word, one in entries.items():
        definition = Definition(one["item"], one["option1"], one["option2"])
        master.robot.machine.data.real_time.define(int(word), definition)


def _set_arm(name: str) -> Callable[[Master, str], None]:
    def put(master: Master, arm: str) -> None:
        setattr(master.robot.machine.settings.of(1), name, _ARMS.index(arm))

    return put


def _set_positions(master: Master, positions: list[int]) -> None:
    master.robot.positions[:] = positions[:4]


#: Keys that are set while the controller runs. The other keys are part of its configuration.
_SET: Mapping[str, Callable[[Master, Any], None]] = {
    "start_mm": lambda master, mm: _set_positions(master, list(_thousand(mm))),
    "start_pulses": _set_positions,
    "registered": _register,
    "history": _set_history,
    "latest_alarm": _make_latest_alarm,
    "ports": _set_ports,
    "parameters": _set_parameters,
    "realtime": _set_real_time,
    "arm": _set_arm("arm"),
    "arm_status": _set_arm("arm_status"),
    "origin_complete": lambda master, states: master.robot.origins.__setitem__(
        slice(None), [state == 1 for state in states]
    ),
    "servo_states": lambda master, states: master.robot.machine.servos.states.__setitem__(
        slice(None), states
    ),
    "date": lambda master, date: master.robot.machine.data.clock.set_date(master.now_us, *date),
    "time": lambda master, time: master.robot.machine.data.clock.set_time(master.now_us, *time),
}


def _found_points(machine: Machine, wanted: Mapping[str, Any]) -> dict[str, Any]:
    points = {text: machine.points[int(text)] for text in wanted}
    return {
        text: {"mm": [v / 1000 for v in one.data]} if one.mm else {"pulses": list(one.data)}
        for text, one in points.items()
    }


def _found_hands(machine: Machine, wanted: Mapping[str, Any]) -> dict[str, Any]:
    hands = {text: machine.memory.hands[1, int(text)] for text in wanted}
    return {
        text: {"data_mm": [v / 1000 for v in one.data[:3]], "on_r_axis": one.data[3] == 1}
        for text, one in hands.items()
    }


def _found_pallets(machine: Machine, wanted: Mapping[str, Any]) -> dict[str, Any]:
    pallets = {text: machine.memory.pallets[int(text)] for text in wanted}
    return {
        text: {"nx": one.nx, "ny": one.ny, "nz": one.nz, "first_point": one.first}
        for text, one in pallets.items()
    }


def _found_parameters(machine: Machine, wanted: list[Mapping[str, int]]) -> list[dict[str, int]]:
    get = machine.memory.parameters.get
    return [{**one, "value": get(1, _PARAMETERS[one["number"]], one["axis"] - 1)} for one in wanted]


def _found_registered(machine: Machine, wanted: list[Mapping[str, Any]]) -> list[dict[str, Any]]:
    every = [
        {"program": place, "task": task.number, "priority": task.priority, "line": task.line}
        for place, task in enumerate(machine.program.tasks, 1)
        if task.number
    ]
    return [{key: one[key] for key in keys} for one, keys in zip(every, wanted, strict=True)]


def _found_real_time(machine: Machine, wanted: Mapping[str, Any]) -> dict[str, Any]:
    definitions = {text: machine.data.real_time.definitions[int(text)] for text in wanted}
    return {text: dict(vars(one)) for text, one in definitions.items()}


def _setting(name: str) -> Callable[[Machine, Any], Any]:
    return lambda machine, _: getattr(machine.settings.of(1), name)


def _clock(machine: Machine, parts: str) -> list[int]:
    return [int(part) for part in f"{machine.data.clock.now(machine.now_us):{parts}}".split()]


def _six(states: list[int]) -> list[int]:
    return states + [9] * (6 - len(states))


_FOUND: Mapping[str, Callable[[Machine, Any], Any]] = {
    **{name: _setting(name) for name in (*_SAME_NAME, "shift")},
    "hand_number": _setting("hand"),
    "arm": lambda machine, _: _ARMS[machine.settings.of(1).arm],
    "points": _found_points,
    "comments": lambda machine, wanted: {n: machine.memory.comment(int(n)) for n in wanted},
    "pallets": _found_pallets,
    "shifts": lambda machine, wanted: {
        n: [value / 1000 for value in machine.memory.shifts[int(n)]] for n in wanted
    },
    "hands": _found_hands,
    "variables": lambda machine, wanted: {
        n: machine.memory.variables.integers[int(n)] for n in wanted
    },
    "parameters": _found_parameters,
    "ports": lambda machine, wanted: {n: machine.ports.read(port(n)) for n in wanted},
    "registered": _found_registered,
    "running_tasks": lambda machine, _: [
        task.number for task in machine.program.tasks if task.state == "running"
    ],
    "servo_states": lambda machine, _: _six(list(machine.servos.states)),
    "motor_power": lambda machine, _: "on" if machine.servos.motor_power else "off",
    "torque_limits": lambda machine, _: list(machine.settings.torque),
    "date": lambda machine, _: _clock(machine, "%y %m %d"),
    "time": lambda machine, _: _clock(machine, "%H %M %S"),
    "realtime": _found_real_time,
    "realtime_enabled": lambda machine, _: machine.data.real_time.enabled,
}
