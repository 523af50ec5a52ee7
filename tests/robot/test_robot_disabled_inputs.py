"""A table gives the effect of each dedicated input under each setting."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from robot_master import Master, powered_up, servos_on

#: Settings that disable inputs, each with its configuration and the event that activates it.
_SETTINGS: dict[str, tuple[dict[str, Any], str]] = {
    "none": ({}, ""),
    "pendant": ({}, "pendant_on"),
    "pendant, by its key": ({"pendant_blocks_inputs": False}, "pendant_on"),
    "safety": ({}, "safety_on"),
    "safety, by its key": ({"safety_keeps_stops": False}, "safety_on"),
    "parallel": ({"parallel_io": "valid"}, ""),
    "parallel, by its key": ({"parallel_io": "valid", "parallel_disables_si": True}, ""),
    "parallel invalid, by its key": ({"parallel_io": "invalid", "parallel_disables_si": True}, ""),
}

_ALL = {"SI00", "SI01", "SI06", "SI10", "SI12", "SI14", "SI15", "SI16", "SI17", "terminal"}
_STOPS = {"SI00", "SI06", "terminal"}  # chapter 1, 5: SI(00), SI(06) and the terminal are valid

#: The inputs that have an effect under each setting.
_WORKS: dict[str, set[str]] = {
    "none": _ALL,
    "pendant": _STOPS | {"SI10", "SI16"},
    "pendant, by its key": _ALL,
    "safety": _STOPS,
    "safety, by its key": {"terminal"},
    "parallel": _ALL,
    "parallel, by its key": _STOPS,
    "parallel invalid, by its key": _STOPS,
}


def _off(name: str) -> Callable[[Master], None]:
    return lambda master: master.turn_and_wait(name, False)


def _pulse(name: str) -> Callable[[Master], None]:
    return lambda master: master.pulse(name)


def _press(master: Master) -> None:
    master.robot.inject("emergency_stop")
    master.run(20)


#: For each input: a function that uses it, and a function that shows its effect.
_TRIES: dict[str, tuple[Callable[[Master], None], Callable[[Master], bool]]] = {
    "SI00": (_off("SI00"), lambda master: master.on("SO00")),
    "terminal": (_press, lambda master: master.on("SO00")),
    "SI06": (_off("SI06"), lambda master: not master.on("SO13")),
    "SI01": (_pulse("SI01"), lambda master: master.on("SO02")),
    "SI10": (
        lambda master: master.turn_and_wait("SI10", True),
        lambda master: master.on("SO12"),
    ),
    "SI12": (_pulse("SI12"), lambda master: master.on("SO13")),
    "SI14": (_pulse("SI14"), lambda master: master.robot.machine.origin_running),
    "SI15": (_pulse("SI15"), lambda master: master.on("SO14")),
    "SI16": (_pulse("SI16"), lambda master: not master.on("SO03")),
    "SI17": (_pulse("SI17"), lambda master: master.robot.machine.origin_running),
}
#: For each input, a function that prepares the state it needs, without dedicated inputs.
_SERVO_ON, _RUN = (0x0042,), (0x0402,)
_BEFORE = {"SI06": (_RUN,), "SI14": (_SERVO_ON,), "SI17": (_SERVO_ON,)}


@pytest.mark.parametrize("name", sorted(_ALL))
@pytest.mark.parametrize("setting", _SETTINGS)
def test_which_dedicated_input_works_under_which_setting(setting: str, name: str) -> None:
    """An edge of a disabled input has no effect, even if the setting ends later.

    Rule: pendant-inputs, safety-inputs, parallel-reading, parallel-inputs, emergency-terminal.
    Source: manual chapter 1, 5 and 4.1; remote command guide chapter 3, restrictions
    """
    config, event = _SETTINGS[setting]
    master = powered_up(origin_time=5000, **config)
    for words in _BEFORE.get(name, ()):
        assert master.execute(*words)[0] == 0x0200
    if name == "SI16":
        master.robot.inject("alarm")
    if event:
        master.robot.inject(event)
    master.run(50)
    act, has_worked = _TRIES[name]
    assert not has_worked(master)
    act(master)
    works = name in _WORKS[setting]
    assert has_worked(master) is works
    if event and not works:
        # inputs that work by their level return to their former state
        if name in ("SI00", "SI06", "SI10"):
            master.turn_and_wait(name, name != "SI10")
        master.robot.inject(event.replace("_on", "_off"))
        master.run(200)
        assert not has_worked(master)
        act(master)
        assert has_worked(master)


@pytest.mark.parametrize("name", ["SI01", "SI12", "SI15"])
def test_an_input_that_is_on_when_a_safety_setting_ends_makes_no_edge(name: str) -> None:
    """An input that is ON when the setting ends has no edge.

    Only SI(10) has an effect, because it works by its level. Rule: safety-inputs.
    """
    master = powered_up()
    master.turn_and_wait("SI10", True)
    assert master.on("SO12")
    master.robot.inject("safety_on")
    master.run(10)
    assert not master.on("SO12")
    master.turn_and_wait(name, True)
    master.robot.inject("safety_off")
    master.run(300)
    assert master.on("SO12")
    assert not _TRIES[name][1](master)


@pytest.mark.parametrize(("keeps", "runs"), [(True, False), (False, True)])
def test_disabled_stops_count_as_on_without_a_connection(keeps: bool, runs: bool) -> None:
    """Disabled stop inputs count as ON when the connection is lost.

    In this test the loss is not a serious alarm.

    Rule: safety-inputs, link-lost.
    """
    master = servos_on(safety_keeps_stops=keeps, minor_alarms=("12.400", "12.552"))
    master.pulse("SI12")
    master.robot.inject("safety_on")
    master.run(10)
    master.connected = False
    master.run(200)
    assert master.on("SO00") is not runs
    assert master.on("SO13") is runs
