"""The controller follows the remote-command handshake of the guide's chapters 1 and 2."""

from __future__ import annotations

from typing import Any

from robot_master import Master, powered_up, servos_on

VERSION = 0x0501
MOVE_TO_19 = (0x0001, 0x0004, 0x0000, 0x0032, 0x0013)  # guide, chapter 2: at 50 % to point 19
POINT_19 = (0x0100, 0x0000, 0x0013, 0x0000, 0x86A0, 0x0001)  # axis 1 = 100000 pulses


def _mover(**config: Any) -> Master:
    master = servos_on(**config)
    assert master.execute(*POINT_19)[0] == 0x0200
    return master


def test_a_command_goes_from_ready_over_run_to_normal_end_and_back() -> None:
    """Rule: status-reset, response-with-status, command-times.

    Source: remote command guide chapter 2, steps 1 to 6
    """
    master = _mover()
    master.send(*MOVE_TO_19)
    seen: list[int] = []
    for _ in range(200):
        master.run(5)
        if master.status not in seen:
            seen.append(master.status)
    assert seen == [0x0100, 0x0200]
    master.send()
    master.run(5)
    assert master.words == (0,) * 16
    assert master.texts() == []
    assert master.robot.positions == [100000, 0, 0, 0]


def test_response_and_end_status_change_in_the_same_cycle() -> None:
    """Rule: response-with-status. Source: remote command guide chapter 2, step 4."""
    master = powered_up()
    master.send(VERSION)
    while master.status != 0x0200:
        assert master.words[1:] == (0,) * 15
        master.run(5)
    assert master.words[2] == 0x0108


def test_the_end_status_stays_until_the_status_reset_command() -> None:
    """Rule: status-reset. Source: remote command guide chapter 4, 4.1."""
    master = powered_up(status_reset_delay=20)
    master.send(VERSION)
    master.run(1000)
    assert master.status == 0x0200
    master.send()
    master.run(20)
    assert master.status == 0x0200
    master.run(10)
    assert master.words == (0,) * 16


def test_the_command_is_accepted_after_a_delay() -> None:
    """Rule: command-times."""
    master = powered_up(command_accept_delay=30)
    master.send(VERSION)
    master.run(30)
    assert master.status == 0x0000
    master.run(5)
    assert master.status == 0x0100


def test_a_command_code_changed_before_its_end_gets_no_status() -> None:
    """The movement of the changed command continues to its end.

    Rule: hold-command, changed-command.
    Source: remote command guide chapter 1, 1.1, note
    """
    master = _mover()
    master.send(*MOVE_TO_19)
    master.run(50)
    master.send()
    master.run(5)
    assert master.texts() == [
        "hold-command: command 16#0001 was changed before its end status (n 16#0001 to 16#0000, "
        "n+2 16#0004 to 16#0000, n+6 16#0032 to 16#0000, n+8 16#0013 to 16#0000; status 16#0100); "
        "its status is not reflected any more"
    ]
    assert master.status == 0x0100
    for _ in range(200):
        master.run(5)
        assert master.status in (0x0000, 0x0100)
    assert master.status == 0x0000
    assert master.robot.positions[0] == 100000
    assert master.execute(VERSION)[0] == 0x0200


def test_a_code_that_is_already_set_after_a_changed_command_is_not_executed() -> None:
    """Rule: changed-command."""
    master = _mover()
    master.send(*MOVE_TO_19)
    master.run(50)
    master.send(VERSION)
    master.run(2000)
    assert master.status == 0x0000
    assert master.robot.commands_executed == 1


def test_a_command_withdrawn_before_it_is_accepted_is_not_executed() -> None:
    """Rule: hold-command. Source: remote command guide chapter 1, 1.1, note."""
    master = powered_up(command_accept_delay=50)
    master.send(VERSION)
    master.run(10)
    master.send()
    master.run(200)
    assert len(master.texts()) == 1
    assert master.robot.commands_executed == 0


def test_a_command_set_before_the_ready_status_is_not_executed() -> None:
    """Rule: ready-first, early-command.

    Source: remote command guide chapter 1, 1.2, code 0x0000
    """
    master = powered_up()
    master.send(VERSION)
    master.run(100)
    master.send(0x0604)
    master.run(100)
    assert master.status == 0x0200
    assert master.texts() == [
        "ready-first: command 16#0604 is set while the status is 16#0200; "
        "a command may be set only in status 16#0000; not executed"
    ]
    assert master.robot.commands_executed == 1


def test_the_same_command_again_needs_a_status_reset() -> None:
    """A code that stays after its end is not executed again.

    Source: remote command guide chapter 4, 4.1
    """
    master = powered_up()
    master.send(VERSION)
    master.run(500)
    assert master.robot.commands_executed == 1


def test_data_may_change_after_the_end_status() -> None:
    """A command must be held until its end, but not longer.

    Source: remote command guide chapter 1, 1.1, note
    """
    master = powered_up()
    master.send(VERSION)
    master.run(100)
    master.send(VERSION, 1, 2, 3)
    master.run(100)
    assert master.status == 0x0200
    assert master.texts() == []


def test_data_words_are_free_while_the_code_is_0x0000() -> None:
    """While the code is 0x0000, SIW(2) to SIW(15) are general-purpose inputs.

    Source: manual chapter 5, 2, word input
    """
    master = powered_up()
    for value in (1, 2, 0xFFFF):
        master.send(0, 0, value, value)
        master.run(10)
    assert master.texts() == []


def test_continuous_output_follows_the_position_until_the_status_reset_command() -> None:
    """The words follow the position.

    The command ends only when the master sends the status reset command.

    Rule: continuous.
    Source: remote command guide 4.7.4
    """
    master = powered_up(skip_run_status="always", status_reset_delay=20)
    master.send(0x0505, 0x0001)
    for position in (0, -1, 70000):
        master.robot.positions[2] = position
        master.run(50)
        low, high = position & 0xFFFF, position >> 16 & 0xFFFF
        assert (master.status, *master.words[8:10]) == (0x0100, low, high)
    master.send()
    master.run(20)
    assert master.status == 0x0100
    master.run(5)
    assert master.words == (0,) * 16
    assert master.texts() == []


def test_continuous_output_ends_with_a_changed_command() -> None:
    """Rule: hold-command. Source: remote command guide chapter 1, 1.1, note."""
    master = powered_up()
    master.send(0x0505, 0x0001)
    master.run(50)
    master.send(0x0506, 0x0001)
    master.run(50)
    assert master.words == (0,) * 16
    assert len(master.texts()) == 1
