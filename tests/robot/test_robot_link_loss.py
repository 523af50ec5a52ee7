"""A lost connection affects everything in progress; the next connection has a first image."""

from __future__ import annotations

from typing import Any

import pytest

from robot_master import Master, powered_up

VERSION = (0x0501,)
READY = (0,) * 16
LOST = (0x4000, 12, 552) + (0,) * 13


def _lose(master: Master, ms: float = 100) -> None:
    """Run without a connection, then with a connection again."""
    master.connected = False
    master.run(ms)
    master.connected = True
    master.run(5)


@pytest.mark.parametrize(
    ("words", "config", "status", "after"),
    [
        ((0x0505, 1), {}, 0x0100, READY),  # the loss is the regular end of continuous output
        ((0x0506, 1), {}, 0x0100, READY),
        (VERSION, {"command_delay": 500}, 0x0100, LOST),
        (VERSION, {}, 0x0200, None),  # the end status is shown until the reset
        (VERSION, {"command_accept_delay": 500}, 0x0000, READY),  # not begun
    ],
)
def test_the_status_after_a_loss_depends_on_the_state_of_the_command(
    words: tuple[int, ...],
    config: dict[str, Any],
    status: int,
    after: tuple[int, ...] | None,
) -> None:
    """A loss ends a running command. An end status stays until it is reset.

    Rule: link-command, continuous.
    """
    master = powered_up(**config)
    master.send(*words)
    master.run(100)
    assert master.status == status
    shown = master.words
    master.connected = False
    master.run(5)
    assert master.words == (shown if after is None else after)
    master.run(100)
    master.send()
    master.connected = True
    master.run(50)
    assert master.words == READY
    assert master.execute(*VERSION)[0] == 0x0200
    assert master.texts() == []


@pytest.mark.parametrize("shown", ["run", "ready"])
def test_a_changed_command_is_forgotten_with_the_connection(shown: str) -> None:
    """After a loss of the connection, the changed command is not executed.

    Rule: link-command, changed-command.
    """
    master = powered_up(command_delay=200, changed_command_status=shown)
    master.send(0x0100, 0, 1, 0, 5)
    master.run(50)
    master.send()
    master.run(10)
    _lose(master)
    master.run(500)
    assert master.words == READY
    assert 1 not in master.robot.points
    assert master.execute(*VERSION)[0] == 0x0200


def test_a_status_that_is_being_reset_is_ready_after_the_loss() -> None:
    """Rule: link-command, status-reset."""
    master = powered_up(status_reset_delay=500)
    master.send(*VERSION)
    master.finish()
    master.send()
    master.run(50)
    assert master.status == 0x0200
    master.connected = False
    master.run(5)
    assert master.words == READY


@pytest.mark.parametrize(("taken", "count"), [(True, 1), (False, 0)])
@pytest.mark.parametrize("power", [False, True])
def test_a_key_decides_whether_a_code_in_the_first_image_is_executed(
    taken: bool, count: int, power: bool
) -> None:
    """A key decides whether a code in the first image, after a loss or power-on, is a command.

    The next code is a command with either setting.

    Rule: first-image-command.
    """
    master = powered_up(first_image_commands=taken)
    master.connected = False
    master.run(50)
    if power:
        master.robot.inject("power_cycle")
        master.run(500)
    master.send(*VERSION)
    before = 0 if power else master.robot.commands_executed
    master.connected = True
    master.run(100)
    assert master.robot.commands_executed - before == count
    assert master.status == (0x0200 if taken else 0)
    if not taken:
        master.send(0x0505)
        assert master.finish()[0] == 0x0200
    assert master.texts() == []


def test_the_sequence_program_stops_with_the_connection_and_runs_again_with_it() -> None:
    """SI(10) is a level, so it needs no new edge.

    Rule: sequence, sequence-program, link-lost.
    Source: manual chapter 5, 2, SI(10): "executed when this signal is in the ON state"
    """
    master = powered_up(sequence_delay=20)
    master.turn_and_wait("SI10", True)
    assert master.on("SO12")
    master.connected = False
    master.run(5)
    assert not master.on("SO12")
    master.run(200)
    assert not master.on("SO12")
    master.connected = True
    master.run(20)
    assert not master.on("SO12")
    master.run(10)
    assert master.on("SO12")


def test_a_sequence_program_that_is_about_to_start_does_not_start_without_connection() -> None:
    """Rule: sequence-program."""
    master = powered_up(sequence_delay=200)
    master.turn_and_wait("SI10", True, 100)
    master.connected = False
    master.run(500)
    assert not master.on("SO12")


@pytest.mark.parametrize(("latches", "serious"), [(False, False), (True, True)])
def test_the_alarm_of_a_missing_connection_may_latch(latches: bool, serious: bool) -> None:
    """A latched alarm is serious and ends by an alarm reset. SO(04) stays ON in both cases.

    Rule: link-error-at-power-on, mp-ready.
    """
    master = Master(link_error_latches=latches, link_error_delay=100)
    master.connected = False
    master.run(300)
    assert [alarm.number for alarm in master.robot.alarms.active] == ["12.551"]
    assert master.on("SO03") is serious
    assert master.on("SO04")
    master.connected = True
    master.turn_and_wait("SI00", True)
    assert master.on("SO03") is serious
    assert not master.on("SO00")
    assert master.on("SO04")
    master.pulse("SI01")
    assert master.on("SO02") is not serious
    if latches:
        master.pulse("SI16")
        assert not master.on("SO03")
        master.pulse("SI01")
    assert master.on("SO02")
    assert [alarm.number for alarm in master.robot.alarms.history] == ["12.551"]


def test_a_connection_that_comes_in_time_leaves_no_alarm() -> None:
    """Rule: link-error-at-power-on."""
    master = Master(link_error_latches=True, link_error_delay=100)
    master.connected = False
    master.run(90)
    master.connected = True
    master.run(300)
    assert master.robot.alarms.history == []


def test_general_inputs_without_a_connection_are_off_or_as_they_were() -> None:
    """A key decides whether bits and words become 0 or keep their values.

    When the connection returns, the master's values count again.

    Rule: inputs-on-loss.
    """
    for clears in (True, False):
        master = powered_up(loss_clears_inputs=clears)
        master.si[34] = 0x81
        master.send(0, 0, 0x1234)
        master.run(10)
        master.connected = False
        master.run(10)
        kept = (0, 0, 0) if clears else (1, 0x81, 0x1234)
        assert [master.robot.read_port(name) for name in ("SI(20)", "SI2()", "SIW(2)")] == [*kept]
        master.connected = True
        master.run(5)
        assert master.robot.read_port("SI2()") == 0x81
