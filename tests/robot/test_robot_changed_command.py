"""The master changes a command before its end, or sets a code too early, in every phase."""

from __future__ import annotations

from typing import Any

import pytest

from robot_master import Master, powered_up, servos_on

VERSION = (0x0501,)
MOVE = (0x0009, 0x0000, 0, 0, 0x0001)  # MOVEI by point 1, at the program speed
POINT_1 = (0x0100, 0, 1, 0, 0x86A0, 0x0001)  # axis 1 = 100000 pulses
CONTINUOUS = (0x0505, 0x0001)
ASSIGN_7_TO_1 = (0x0230, 0, 1, 7)
READY = (0,) * 16


def _mover(**config: Any) -> Master:
    master = servos_on(**config)
    assert master.execute(*POINT_1)[0] == 0x0200
    return master


def _rules(master: Master) -> list[str]:
    return [text.partition(":")[0] for text in master.texts()]


@pytest.mark.parametrize("second", [VERSION, (0x0505,)])
def test_a_command_after_a_changed_one_is_executed(second: tuple[int, ...]) -> None:
    """A key can set the status to 0x0000 at once, while the movement continues.

    Rule: changed-command, ready-first.
    Source: remote command guide chapter 1, 1.2, code 0x0000
    """
    master = _mover(changed_command_status="ready")
    master.send(*MOVE)
    master.run(50)
    master.send()
    master.run(5)
    assert master.words == READY
    assert _rules(master) == ["hold-command"]
    assert 0 < master.robot.positions[0] < 100_000
    assert master.execute(*second)[0] == 0x0200
    assert master.robot.positions[0] < 100_000
    master.run(2000)
    assert master.robot.positions[0] == 100_000
    assert master.words == READY
    assert master.texts() == []


def test_a_movement_beside_one_whose_status_is_not_shown_is_refused_as_busy() -> None:
    """Rule: changed-command, robots-move."""
    master = _mover(changed_command_status="ready", moving_alarm="6.280")
    master.send(*MOVE)
    master.run(50)
    master.send()
    master.run(10)
    assert master.execute(*MOVE)[:3] == (0x4000, 6, 280)
    master.run(2000)
    assert master.execute(*MOVE)[0] == 0x0200


@pytest.mark.parametrize("shown", ["run", "ready"])
def test_a_changed_command_that_acts_later_still_acts(shown: str) -> None:
    """A changed command is still executed, but its status is not shown.

    Rule: changed-command.
    Source: remote command guide chapter 1, 1.1, note
    """
    master = powered_up(command_delay=100, changed_command_status=shown)
    master.send(*POINT_1)
    master.run(20)
    master.send()
    master.run(50)
    assert 1 not in master.robot.points
    assert master.status == (0x0100 if shown == "run" else 0)
    master.run(60)
    assert master.robot.points[1].data[0] == 100_000
    assert master.words == READY
    assert master.execute(*VERSION)[0] == 0x0200


@pytest.mark.parametrize("shown", ["run", "ready"])
def test_the_alarm_of_a_changed_command_is_not_shown_and_not_entered(shown: str) -> None:
    """Rule: changed-command."""
    master = powered_up(command_delay=50, changed_command_status=shown)
    master.send(0x0101, 0, 7)  # point 7 is not defined
    master.run(20)
    master.send()
    for _ in range(40):
        master.run(5)
        assert master.status in (0, 0x0100)
    assert master.words == READY
    assert master.robot.alarms.history == []
    assert master.robot.alarms.latest_of_command is None


def test_a_code_set_before_the_end_of_a_changed_command_is_not_executed() -> None:
    """A code that is set while the status is still 0x0100 is not executed.

    A later code that comes in the ready status is executed.

    Rule: changed-command, early-command.
    Source: remote command guide chapter 1, 1.2, code 0x0000
    """
    master = _mover(changed_command_status="ready")
    master.send(*MOVE)
    master.run(50)
    master.send(*VERSION)
    master.run(200)
    assert master.words == READY
    master.send(0x0505)
    assert master.finish()[0] == 0x0200
    assert master.robot.commands_executed == 2


@pytest.mark.parametrize(
    ("belong", "status", "found"),
    [(True, 0x0000, ["hold-command"]), (False, 0x0200, [])],
)
def test_a_changed_data_word_is_a_changed_command_or_free(
    belong: bool, status: int, found: list[str]
) -> None:
    """Depending on the setting, a changed data word is a changed command or has no effect.

    The word may be one that the command does not use.

    Rule: changed-data, hold-command.
    Source: remote command guide chapter 1, 1.1, note
    """
    for at in (1, 4, 15):
        master = _mover(data_belong_to_command=belong)
        master.send(*MOVE)
        master.run(50)
        words = list(MOVE) + [0] * 11
        words[at] ^= 0x0100
        master.send(*words)
        master.run(2000)
        assert master.status == status
        assert _rules(master) == found
        assert master.robot.positions[0] == 100_000


def test_a_command_uses_the_data_that_came_with_its_code() -> None:
    """Rule: changed-data."""
    master = powered_up(command_accept_delay=50, command_delay=50, data_belong_to_command=False)
    master.send(*POINT_1)
    master.run(20)
    master.send(*POINT_1[:4], 0x0007)
    assert master.finish()[0] == 0x0200
    assert master.robot.points[1].data[0] == 100_000


@pytest.mark.parametrize("waits", [False, True])
@pytest.mark.parametrize("phase", ["changed", "resetting"])
def test_a_code_that_comes_too_early_is_found_in_every_phase(phase: str, waits: bool) -> None:
    """A code that is set in another status than 0x0000 is a violation.

    Examples are a changed command with status 0x0100, and a status reset.

    Rule: ready-first, early-command.
    Source: remote command guide chapter 1, 1.2, code 0x0000
    """
    master = _mover(status_reset_delay=40, early_command_waits=waits)
    if phase == "changed":
        master.send(*MOVE)
        master.run(50)
        status = 0x0100
    else:
        master.send(*VERSION)
        master.finish()
        status = 0x0200
    master.send()
    master.run(10)
    assert _rules(master) == (["hold-command"] if phase == "changed" else [])
    before = master.robot.commands_executed
    master.send(0x0505)
    master.run(10)
    assert master.status == status
    end = "it waits" if waits else "not executed"
    assert master.texts() == [
        f"ready-first: command 16#0505 is set while the status is 16#{status:04X}; "
        f"a command may be set only in status 16#0000; {end}"
    ]
    master.run(2000)
    assert master.status == (0x0200 if waits else 0)
    assert master.robot.commands_executed == before + waits
    assert master.texts() == []


def test_each_early_code_is_reported_as_a_violation() -> None:
    """Rule: ready-first."""
    master = powered_up(status_reset_delay=100)
    master.send(*VERSION)
    master.finish()
    master.send()
    master.run(10)
    for words in (VERSION, (), VERSION):
        master.send(*words)
        master.run(10)
    assert _rules(master) == ["ready-first", "ready-first"]


def test_a_code_that_replaces_one_whose_end_is_shown_never_waits() -> None:
    """A new code directly replaces the old one, without the code 0x0000.

    The status is never reset, so the new code is never executed.

    Rule: early-command.
    """
    master = powered_up(early_command_waits=True)
    master.send(*VERSION)
    master.finish()
    master.send(0x0505)
    master.run(100)
    assert master.status == 0x0200
    assert master.texts()[0].endswith("not executed")
    assert master.robot.commands_executed == 1


def test_continuous_output_that_changes_its_data_only_ends_with_the_change() -> None:
    """Rule: changed-data, hold-command."""
    master = powered_up()
    master.send(*CONTINUOUS)
    master.run(50)
    assert master.status == 0x0100
    master.send(CONTINUOUS[0], 0x0000)
    master.run(10)
    assert master.words == READY
    assert _rules(master) == ["hold-command"]


def test_a_changed_command_goes_on_without_a_change_of_the_inputs() -> None:
    """A changed command is executed even if the master's words do not change after it.

    Rule: changed-command.
    """
    master = powered_up(command_delay=100, changed_command_status="ready")
    master.send(*POINT_1)
    master.run(20)
    master.send()
    image = bytes(master.si)
    for k in range(40):
        master.robot.cycle(master.now_us + k * 5000, image)
    assert master.robot.points[1].data[0] == 100_000


@pytest.mark.parametrize("waits", [True, False])
def test_a_code_that_waits_needs_no_change_of_the_inputs(waits: bool) -> None:
    """A waiting code is executed even if the master's words do not change after it.

    Rule: early-command.
    """
    master = powered_up(command_delay=20, early_command_waits=waits)
    master.send(*POINT_1)
    master.run(10)
    master.send(*VERSION)
    image = bytes(master.si)
    for k in range(40):
        shown = master.robot.cycle(master.now_us + k * 5000, image)
    assert int.from_bytes(shown[:2], "little") == (0x0200 if waits else 0)


def test_a_command_that_failed_unseen_is_not_tried_again() -> None:
    """The assignment fails because point 7 is not defined.

    It is not repeated when the point is defined later.

    Rule: changed-command.
    """
    master = powered_up(command_delay=50, changed_command_status="ready")
    master.send(*ASSIGN_7_TO_1)
    master.run(20)
    master.send()
    master.run(100)
    assert master.execute(0x0100, 0, 7, 0, 0x86A0, 0x0001)[0] == 0x0200
    master.run(100)
    assert sorted(master.robot.points) == [7, 19, 50, 100]
