"""Robot programs read inputs, write outputs and wait for conditions."""

from __future__ import annotations

import pytest

from robot_programs import running, started


@pytest.mark.parametrize(
    ("text", "byte", "value"),
    [
        ("SO(20)=1", 34, 1),
        ("SO(21)=1\nSO(20)=1\nSO(21)=0", 34, 1),
        ("SET SO(23)", 34, 8),
        ("SO2()=&HFF\nRESET SO(20)", 34, 0xFE),
        ("SO2(3,1)=2", 34, 8),  # the leftmost bit of the list is the most significant
        ("SO(23,21)=1", 34, 2),
        ("SOW(2)=258", 4, 2),
        ("SOW(2)=258", 5, 1),
        ("DO(20)=1\nSO(20)=DO(20)", 34, 1),
        ("MO2()=5\nSO2()=MO2()", 34, 5),
        ("SO(20)=~SO(20)", 34, 1),
        ("SO(20)=NOT SO(21)", 34, 1),
    ],
)
def test_an_output_is_written(text: str, byte: int, value: int) -> None:
    """SO2() is byte m+34, SOW(2) the bytes m+4 and m+5.

    Rule: robot-language.
    Source: manual, chapter 3, 2 (ports); chapter 1, 4.1 (areas)
    """
    assert running(text).so[byte] == value


def test_out_turns_an_output_on_for_a_time_and_the_program_continues() -> None:
    """OUT turns the output ON for 200 ms. The next statement, SO(21)=1, is executed at once.

    Rule: robot-language.
    """
    master = running("OUT SO(20),200\nSO(21)=1", 20)
    assert master.so[34] == 3
    master.run(200)
    assert master.so[34] == 2


def test_wait_ends_with_its_condition() -> None:
    """SI(20) is bit 0 of byte n+34.

    Rule: robot-language.
    """
    master = running("WAIT SI(20)=1 AND SI(21)=0\nSO(20)=1")
    assert master.so[34] == 0
    master.si[34] = 3
    master.run(20)
    assert master.so[34] == 0
    master.si[34] = 1
    master.run(20)
    assert master.so[34] == 1


def test_wait_ends_with_its_time() -> None:
    """The condition never holds; after 100 ms the program continues.

    Rule: robot-language.
    """
    master = started("WAIT SI(20)=1,100\nSO(20)=1")
    before = master.now_us
    while not master.so[34] & 1:
        master.run(5)
    assert master.now_us - before <= 100_000 + 5_000
    waiting = started("WAIT SI(20)=1,500\nSO(20)=1")
    waiting.run(300)
    assert waiting.so[34] == 0
    waiting.run(250)
    assert waiting.so[34] == 1


def test_a_wait_for_words_compares_signed_and_unsigned_values() -> None:
    """SIW is unsigned, SID signed (manual chapter 1, 4.1).

    Rule: robot-language.
    """
    master = running("WAIT SIW(2)=65535\nSO(20)=1\nWAIT SID(4)=-2\nSO(21)=1")
    master.si[4:6] = b"\xff\xff"
    master.run(20)
    assert master.so[34] == 1
    master.si[8:12] = b"\xfe\xff\xff\xff"
    master.run(20)
    assert master.so[34] == 3


def test_a_stop_does_not_count_for_a_delay() -> None:
    """SI(06) stops the program after 300 of 500 ms.

    The remaining 200 ms pass after the next start.

    Rule: tasks.
    """
    master = started("DELAY 600\nSO(20)=1")
    master.run(180)  # the start pulse took 120 ms, so at most 300 ms of the delay have passed
    master.turn_and_wait("SI06", False, 1000)
    assert master.so[34] == 0
    master.turn_and_wait("SI06", True)
    master.turn("SI12", True)
    master.run(200)
    assert master.so[34] == 0
    master.run(300)
    assert master.so[34] == 1
