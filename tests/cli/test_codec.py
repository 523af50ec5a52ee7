"""`rcx encode` and `rcx decode` agree with the telegrams that the manual prints."""

from __future__ import annotations

import pytest

from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]


def test_the_ptp_example_is_encoded_as_the_manual_prints_it(capsys: Captured) -> None:
    """Moving all axes to point 19 at 50 % gives n+2 = 0x0004, n+6 = 0x0032 and n+8 = 0x0013.

    Source: guide chapter 2, example, step 1.
    """
    assert main(["encode", "MovePtp", "speed_mode=2", "speed=50", "point=19"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:6] == ["n     16#0001", "n+2   16#0004", "n+4   16#0000", "n+6   16#0032",
                         "n+8   16#0013", "then to n+30 16#0000"]  # fmt: skip
    assert lines[6].startswith("MovePtp (16#R001)")
    assert "  point = 19" in lines


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        # Guide 4.2.1, R: the upper digit is the robot number.
        ("encode 0x001 point=1 --robot 2", ["n     16#2001\n", "  robot 2\n"]),
        ("encode 16#2001 point=1", ["n     16#2001\n"]),
        # Guide chapter 2, example, step 1.
        ("decode 0x0001 0x0004 0 50 19",
         ["  speed_mode = 2  (in %)\n", "  speed = 50 ", "  point = 19\n"]),
        ("decode 0x7001 0", ["  not allowed: robot 7 cannot be designated\n"]),
        ("decode 0x0001 0x0008", ["  not allowed: n+2 has bits 16#0008 set"]),
        # Guide chapter 1, 1.2, code 0x4000: 0x000C and 0x0258 mean the emergency stop.
        ("decode --response MovePtp 0x4000 0x000C 0x0258",
         ["  status 16#4000: abnormal end\n", "  alarm 12.600"]),
        # Guide 4.7.4, normal end: the axis data are 32 bits, the lower word first.
        ("decode --response 0x505 0x0200 0 0 0 0xFFFF 0xFFFF 0x0001 0x0001",
         ["  positions = -1, 65537, 0, 0, 0, 0 pulse\n"]),
    ],
)  # fmt: skip
def test_a_telegram_is_shown_in_plain_words(capsys: Captured, words: str, shown: list[str]) -> None:
    """The output contains the given texts. Source: guide 1.2, chapter 2, 4.2.1 and 4.7.4."""
    assert main(words.split()) == 0
    out = capsys.readouterr().out
    assert all(text in out for text in shown)
    assert ("not allowed" in out) == ("not allowed" in shown[0])


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["encode", "MovePtpp"], "no remote command is called 'MovePtpp'"),
        (["encode", "MovePtp", "points=1"], "has no field 'points'"),
        (["encode", "MovePtp", "point"], "'point' is not a field; write name=value"),
        (["encode", "MovePtp", "point=many"], "point = 'many' is not a number"),
        (["encode", "MovePtp", "point=30000"], "point is 30000, not 0 to 29999"),
        (["encode", "MovePtp", "--robot", "5"], "cannot designate robot 5"),
        (["encode", "MovePtp", "point=99999"], "point is 99999, not 0 to 29999\n"),
        (["encode", "MovePtp", "point=-1"], "16#R001 MovePtp: point is -1, not 0 to 29999\n"),
        (["encode", "MovePtp", "point=1.5"], "point is 1.5, not a whole number\n"),
        (["encode", "MovePtp", "point=1,2"], "no room for (1, 2); it takes 1 number(s)\n"),
        (["encode", "MovePtp", "speed_mode=1.5"], "speed_mode is 1.5, not a whole number\n"),
        (["encode", "MovePtp", "speed_mode=9"], "speed_mode is 9, which has no meaning\n"),
        (["encode", "MovePtp", "speed_mode=2", "speed=99999"], "speed is 99999, not 1 to 100\n"),
        (["encode", "MovePtp", "speed=99999"], "speed is 99999, not 0 to 65535\n"),
        (["encode", "MovePtp", "speed_mode=2", "speed=101"], "guide 4.2.1: 16#R001 MovePtp: speed"),
        (["encode", "MovePtp", "speed_mode=2", "speed=101"], "is 101, not 1 to 100\n"),
        (["encode", "MovePtp", "speed=101"], "speed has no effect while speed_mode is 0; set"),
        (
            ["encode", "MovePtp", "speed=101"],
            "speed_mode=1 (1 to 10000) or speed_mode=2 (1 to 100)",
        ),
        (["encode", "MovePtp", "speed=-1"], "speed is -1, not 0 to 65535"),
        (["encode", "MovePtp", "acceleration=5"], "set acceleration_flag=1 (1 to 100)\n"),
        (["encode", "MovePtp", "point=1", "point=2"], "point is given twice; leave one"),
        (["encode", "16#12001"], "no remote command is called '16#12001'"),
        (["encode", "--", "-4095"], "no remote command is called '-4095'"),
        (["encode", "16#7001"], "cannot designate robot 7"),
        (
            ["encode", "16#2001", "--robot", "3"],
            "16#2001 is for robot 2, but --robot is 3; leave one",
        ),
        (["encode", "MoveDirectMm", "targets=1,0x80000000"], "targets is 2147483648, not "),
        (["encode", "MoveDirectMm", "targets=1,nan"], "targets = '1,nan' is not a number\n"),
        (["encode", "MovePtpp"], "; did you mean MovePtp"),
        (["encode", "Foo"], "called 'Foo'; docs/reference/commands.md lists all names and codes\n"),
        (["decode", "0x0FFF"], "no remote command is called '0x0FFF'"),
        (
            ["decode", "0xFFFF"],
            "called '0xFFFF'; docs/reference/commands.md lists all names and codes\n",
        ),
        (["decode", "4095,7"], "no remote command is called '4095'; docs/reference/commands.md"),
        (["decode", "0x10000"], "'0x10000' is not a word"),
        (["decode", *["0"] * 17], "17 words are given; give 1 to 16"),
    ],
)
def test_a_wrong_telegram_is_refused(capsys: Captured, args: list[str], message: str) -> None:
    assert main(args) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert printed.out == ""
