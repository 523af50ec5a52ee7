"""Events at the controller that do not come from the master. A test or a stimulus injects them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any

from rcx_harness.robot.config.checks import alarm_code
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.ports import port as port_by_name
from structured_text.errors import InputError

__all__ = ["EVENTS", "happen"]


def _alarm(machine: Machine, group: int = 99, category: int = 999) -> None:
    number = f"{group}.{category}"
    alarm_code(number)
    machine.raise_alarm(number)


def _parallel(machine: Machine, port: int, on: int) -> None:
    """Set an input of the parallel I/O board by its port and bit, as in the robot language.

    Of the dedicated inputs only the stop signal has an effect (manual chapter 1, 4.1); see
    Machine.stopped. All others are read only by robot programs and the I/O port reference.
    """
    if on > 1:
        raise InputError(f"on = {on} of event 'parallel_input' is not a level", hint="use 0 or 1")
    machine.ports.set_input(port_by_name(f"DI({port:02})"), on)
    if port == _PARALLEL_STOP:
        machine.parallel_stop = bool(on)


def _set(name: str, value: bool) -> Callable[[Machine], None]:
    return lambda machine: setattr(machine, name, value)


def _mode(**switches: bool) -> Callable[[Machine], None]:
    return lambda machine: machine.switch_mode(**switches)


def _warning(value: bool) -> Callable[[Machine], None]:
    return lambda machine: setattr(machine.alarms, "warning", value)


_PARALLEL_STOP = 6

_ACTIONS: dict[str, tuple[str, Callable[..., None]]] = {
    "emergency_stop": (
        "press an emergency stop of the robot (SAFETY connector or programming box)",
        Machine.press_emergency_stop,
    ),
    "emergency_stop_release": ("release that emergency stop", _set("hard_wired_stop", False)),
    "power_off": ("switch the controller off", Machine.power_off),
    "power_on": ("switch the controller on", Machine.power_on),
    "power_cycle": ("switch the controller off and on", Machine.power_off),
    "alarm": (
        "raise an alarm: group = 12, category = 600; without them 99.999, a number of our own: "
        "a serious alarm that an alarm reset clears",
        _alarm,
    ),
    "warning": ("a warning begins (SO(15))", _warning(True)),
    "warning_clear": ("the warning ends", _warning(False)),
    "pendant_on": ("the programming box takes control authority", _set("pendant_authority", True)),
    "pendant_off": ("the programming box gives authority back", _set("pendant_authority", False)),
    "manual_mode": ("select MANUAL mode", _mode(auto_input=False, manual_lock=True)),
    "auto_mode": ("select AUTO mode", _mode(auto_input=True, manual_lock=False)),
    "auto_input_on": ("the AUTO input of the SAFETY connector turns ON", _mode(auto_input=True)),
    "auto_input_off": ("the AUTO input of the SAFETY connector turns OFF", _mode(auto_input=False)),
    "manual_lock_on": ("the programming box locks MANUAL mode", _mode(manual_lock=True)),
    "manual_lock_off": ("the programming box releases that lock", _mode(manual_lock=False)),
    "main_power_off": (
        "switch off the main power of the motors; the controller stays on",
        lambda machine: machine.switch_main_power(False),
    ),
    "main_power_on": (
        "switch on the main power of the motors",
        lambda machine: machine.switch_main_power(True),
    ),
    "safety_on": (
        "a safety setting disables dedicated inputs and commands",
        _set("inputs_disabled", True),
    ),
    "safety_off": ("the safety setting of safety_on ends", _set("inputs_disabled", False)),
    "parallel_stop": ("DI06 of the parallel I/O board turns OFF", _set("parallel_stop", False)),
    "parallel_stop_release": ("DI06 turns ON", _set("parallel_stop", True)),
    "parallel_input": (
        "set an input of the parallel I/O board: port = 1 for DI01, 20 for DI(20), on = 0 or 1",
        _parallel,
    ),
    "program_end": (
        "end the main robot program",
        lambda machine: machine.program.end_main(),
    ),
}

#: Maps the name of each event to its description.
EVENTS: dict[str, str] = {name: text for name, (text, _) in _ACTIONS.items()}


def happen(machine: Machine, event: str, args: dict[str, Any]) -> None:
    """Apply an event to the machine; raise InputError for an unknown event or argument."""
    if event not in _ACTIONS:
        near = get_close_matches(event, _ACTIONS)
        hint = f"did you mean {' or '.join(near)}" if near else "see rcx run --help"
        raise InputError(f"unknown robot event {event!r}", hint=hint)
    action = _ACTIONS[event][1]
    parameters = list(inspect.signature(action).parameters.values())[1:]
    takes = [one.name for one in parameters]
    by_default = not args and all(one.default is not one.empty for one in parameters)
    if sorted(args) != sorted(takes) and not by_default:
        raise _wrong_arguments(event, takes, args)
    for name, value in args.items():
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 0xFFFF:
            given = f"{name} = {value!r} of event {event!r}"
            raise InputError(f"{given} is not a number from 0 to 65535")
    action(machine, **args)


def _wrong_arguments(event: str, takes: list[str], args: dict[str, Any]) -> InputError:
    """Return the error for unknown or missing arguments; its hint shows the correct event."""
    if not takes:
        return InputError(f"event {event!r} takes no arguments", hint=f'write robot = "{event}"')
    foreign = [name for name in args if name not in takes]
    missing = [name for name in takes if name not in args]
    problem = f"has no argument {foreign[0]!r}" if foreign else f"needs {' and '.join(missing)}"
    example = ", ".join(f"{name} = ..." for name in takes)
    hint = f'write robot = {{ event = "{event}", {example} }}'
    return InputError(f"event {event!r} {problem}", hint=hint)
