"""`rcx compare --fit` finds the properties of virtual controllers from their recordings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from faulty_answers import WRONG, recorded_wrong
from fit_cases import CASES, judged
from rcx_harness.look.compare.delays import DELAYS
from rcx_harness.look.compare.fit import fit
from rcx_harness.look.compare.replay import Replay
from rcx_harness.look.compare.text import fit_lines
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.handshake import Handshake
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.signals import REQUESTS
from recorded_robot import RecordedMaster, busy_run, exercised, short_run

Patch = Callable[[pytest.MonkeyPatch], None]


def _with(target: Any, name: str, made: Callable[[Any], Any]) -> Patch:
    """Return a patch that replaces a method of the virtual controller by a faulty version."""
    return lambda broken: broken.setattr(target, name, made(getattr(target, name)))


def _exchanged(broken: pytest.MonkeyPatch) -> None:
    program, alarm = REQUESTS["SI15"], REQUESTS["SI16"]
    broken.setitem(REQUESTS, "SI15", alarm)
    broken.setitem(REQUESTS, "SI16", program)


#: Ten bugs of a controller by their symptoms. No key of a robot file can describe them.
BUGS: dict[str, Patch] = {
    "an emergency stop leaves the servos ON": _with(Machine, "switch_servos_off",
                                                    lambda _: lambda *args, **kwargs: None),
    "SO(03) stays OFF in an emergency stop": _with(Machine, "raise_alarm", lambda _: lambda *args,
                                                   **kwargs: None),
    "servo ON in the emergency stop": _with(Machine, "may_switch_servo_on",
                                            lambda _: lambda machine: True),
    "SO(04) is ON only while the servos are OFF": lambda broken: broken.setattr(
        Machine, "mp_ready", property(lambda machine: not machine.servo_on)
    ),
    "a stop does not stop the program": _with(Machine, "_stop", lambda _: lambda machine: None),
    "the response is all 0": _with(Handshake, "_end", lambda end: lambda self, status,
                                   _: end(self, status, (0,) * 15)),
    "a command whose status was not reset is followed by another": _with(
        Handshake,
        "_look_for_reset",
        lambda reset: lambda self, machine, _: reset(self, machine, (0,) * 16),
    ),
    "the end status has a bit too many": _with(Handshake, "_end", lambda end: lambda self, status,
                                               words: end(self, status | 1, words)),
    "the dedicated inputs SI(15) and SI(16) are taken for each other": _exchanged,
    "the release of an emergency stop resets its alarm": _with(
        Machine,
        "_on_emergency_release_delay",
        lambda release: lambda self: (release(self), self.alarms.active.clear())[0],
    ),
}  # fmt: skip


@pytest.mark.exhaustive(but=["values0", "values1"])
@pytest.mark.parametrize(
    "values",
    [
        {},
        {"servo_on_delay": (20.0, 120.0), "emergency_release_delay": 30.0, "command_delay": 25.0},
        {"reset_in_emergency_stop": True, "host_version": 0x0112, "skip_run_status": "always"},
        {"mp_ready_in_emergency_stop": False, "program_is_reset": True, "manual_speed": 35},
    ],
)
def test_fit_reports_the_keys_on_which_a_short_recording_depends(values: dict[str, Any]) -> None:
    """For a short recording, `--fit` reports the keys on which the recording depends.

    The recording has power-on, servo ON, a program start, three references and an emergency stop.
    """
    master = RecordedMaster(7, **values)
    short_run(master)
    replay = Replay(master.recording())
    found = fit(replay, RobotConfig())
    assert found.left == []
    assert replay.run(found.config).differences == []
    knobs = {one.key: one for one in found.knobs}
    for key, real in values.items():
        shown = getattr(found.config, key)
        if isinstance(real, tuple):
            low, high = shown if isinstance(shown, tuple) else (shown, shown)
            assert real[0] <= low <= high < real[1] + 5
        else:
            assert shown == real or real in knobs[key].others
        assert knobs[key].found
    assert not knobs["jog_limit"].found
    assert knobs["jog_limit"].why == "nothing in this recording depends on it"
    assert not knobs["auto_mode_delay"].found


@pytest.mark.exhaustive
def test_a_difference_that_no_key_explains_is_reported() -> None:
    """A difference that no key explains is reported: SO(12) is ON for 200 ms without SI(10).

    600 ms later, a servo ON takes 80 ms, which a key explains.
    """
    master = RecordedMaster(7, servo_on_delay=80.0)
    master.run(100)
    master.robot.force("SO12", 1)
    master.run(200)
    master.robot.release("SO12")
    master.run(300)
    short_run(master)
    found = fit(Replay(master.recording()), RobotConfig())
    assert [(one.channel, one.begin_us) for one in found.left] == [("SO12", 100_000)]
    assert found.config.servo_on_delay == 80.0


@pytest.mark.exhaustive
@pytest.mark.parametrize("number", range(len(CASES)))
def test_each_key_is_found_or_reported_as_undecided(number: int) -> None:
    """For each key, `--fit` finds the value, or reports that the recording does not decide it.

    Thirty robot files have values that differ from the defaults, in all sections.
    """
    _, wrong = judged(*CASES[number])
    assert wrong == []


@pytest.mark.exhaustive(but=["values1-others1", "values3-others3"])
@pytest.mark.parametrize(
    ("values", "others"),
    [
        ({"status_reset_delay": (5.0, 45.0)}, {}),  # code before the ready status
        ({"command_delay": (0.0, 20.0)}, {"changed_command_status": "ready"}),
        ({"command_delay": (5.0, 40.0), "command_accept_delay": (0.0, 30.0)}, {}),
        ({}, {"early_command_waits": True}),
        ({}, {"skip_run_status": "always", "strict_unused_words": False}),
    ],
)
def test_recorded_delays_also_explain_changed_commands(
    values: dict[str, Any], others: dict[str, Any]
) -> None:
    """If the delays of the recording are used, no difference remains, whatever the PLC has sent."""
    master = RecordedMaster(7, **values, **others)
    exercised(master)
    replay = Replay(master.recording(), master.happenings)
    assert replay.run(RobotConfig(**others), free=frozenset(DELAYS)).differences == []


@pytest.mark.exhaustive(but=["SO(04) is ON only while the servos are OFF"])
@pytest.mark.parametrize("bug", BUGS)
def test_no_robot_file_explains_a_controller_with_a_bug(
    bug: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If the recorded controller has a bug, some differences remain for all values of the keys."""
    with monkeypatch.context() as broken:
        BUGS[bug](broken)
        master = RecordedMaster(7)
        busy_run(master)
    replay = Replay(master.recording(), master.happenings)
    assert replay.run(RobotConfig()).differences, "the recording does not show the bug"
    assert fit(replay, RobotConfig()).left


@pytest.mark.exhaustive(but=["SO(02) ON 10 ms before it was asked"])
@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_answers_fit_no_legal_controller(wrong: str) -> None:
    master = RecordedMaster(7)
    busy_run(master)
    replay = Replay(recorded_wrong(master, wrong))
    found = fit(replay, RobotConfig())
    assert found.left
    assert "no key expresses" in fit_lines(found, replay)


@pytest.mark.exhaustive
def test_the_key_with_few_values_is_preferred() -> None:
    """If two keys explain a recording, `--fit` chooses the key with fewer possible values.

    Here these are `power_on_emergency_alarm` and `power_on_alarm`, which can be any text.
    """
    master = RecordedMaster(7, power_on_emergency_alarm=True)
    short_run(master)
    master.turn_and_wait("SI00", False)
    master.ask("MotorPowerOn")  # the recording names the alarm 12.600
    replay = Replay(master.recording())
    found = fit(replay, RobotConfig())
    assert found.left == []
    assert (found.config.power_on_emergency_alarm, found.config.power_on_alarm) == (True, "")
    knob = next(one for one in found.knobs if one.key == "power_on_emergency_alarm")
    assert knob.instead == (("power_on_alarm", "12.600"),)
    text = "\n".join(fit_lines(found, replay))
    assert 'has the same effect as power_on_alarm = "12.600"' in text


@pytest.mark.exhaustive
def test_a_reset_without_effect_does_not_change_the_fitted_delay() -> None:
    """A reset without effect does not change the fitted delay, although the alarm ends later.

    SI(16) turns ON in an emergency stop. A second later, the remote command resets the alarm.
    """
    master = RecordedMaster(7, alarm_reset_delay=45.0)
    short_run(master)
    master.turn_and_wait("SI00", False)
    master.pulse("SI16", 120)
    master.run(800)
    master.turn_and_wait("SI00", True)
    master.ask("AlarmReset")
    found = fit(Replay(master.recording()), RobotConfig())
    assert found.left == []
    assert found.config.alarm_reset_delay == 45.0


def test_without_a_bug_nothing_is_left() -> None:
    master = RecordedMaster(7)
    busy_run(master)
    assert Replay(master.recording(), master.happenings).run(RobotConfig()).differences == []


def test_an_exercised_controller_agrees_with_itself() -> None:
    master = RecordedMaster(7)
    exercised(master)
    assert Replay(master.recording(), master.happenings).run(RobotConfig()).differences == []
