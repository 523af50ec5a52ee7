"""Remote commands are described in plain language."""

from __future__ import annotations

from rcx_harness.spec import commands
from rcx_harness.spec.plain import alarm_text, request_text, response_text


def _words(*first: int) -> tuple[int, ...]:
    return (*first, *(0,) * (16 - len(first)))


def test_a_request_names_the_command_its_robot_and_the_fields_that_say_something() -> None:
    assert request_text(_words(0x1001, 0x4000, 0, 0, 19)) == (
        "MovePtp (16#R001) robot 1: MOVE, PTP, point designation; "
        "position_pulses 1 (output in pulses), point 19"
    )


def test_a_request_without_a_robot_and_without_fields_is_the_command_alone() -> None:
    assert request_text(_words(0x0604)) == "AlarmReset (16#0604): Alarm reset"


def test_a_code_that_the_manual_does_not_have_is_said_to_be_none() -> None:
    assert request_text(_words(0x0FFF)) == "16#0FFF: no command of the manual"
    assert request_text(_words(0x0000)) == "16#0000: no command of the manual"


def test_a_field_that_can_have_one_value_only_is_not_worth_a_word() -> None:
    drive = commands()[0x010].encode({"point": 5, "axes": 1})
    assert request_text(drive) == (
        "DrivePoint (16#R010): DRIVE, point designation; axes 1, point 5"
    )


def test_a_normal_end_shows_what_was_answered() -> None:
    answer = _words(0x0200, 0, 0, 0, 0x86A0, 0x0001)
    assert response_text(0x0505, answer) == "normal end; positions 100000, 0, 0, 0, 0, 0 pulse"


def test_an_abnormal_end_names_its_alarm() -> None:
    answer = _words(0x4000, 12, 600)
    assert response_text(0x1001, answer) == "abnormal end, alarm 12.600 Emergency stop on"


def test_an_alarm_without_a_name_is_its_number() -> None:
    assert alarm_text("99.999") == "99.999"


def test_every_command_has_its_line_and_none_is_endless() -> None:
    for code in commands():
        for words in (_words(code), _words(code, *(0xFFFF,) * 15)):
            assert 5 < len(request_text(words)) <= 160
            assert len(response_text(code, (0x0200, *words[1:]))) <= 160
