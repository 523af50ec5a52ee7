"""Steps of robot programs read and write the ports (chapter 3, 2)."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import RobotConfig, RobotProgram
from robot_master import Master, powered_up
from structured_text.errors import InputError


def run_steps(*steps: str, **config: Any) -> Master:
    """Return a robot that has just been started with a program of these steps, which runs once."""
    program = RobotProgram(steps=steps, loop=False)
    master = powered_up(programs=(program,), program_start_delay=0, **config)
    master.turn_and_wait("SI12", True, 20)
    return master


@pytest.mark.parametrize(
    ("step", "at", "raw"),
    [
        ("SO(20)=1", 34, b"\x01"),
        ("SET SO(27)", 34, b"\x80"),
        ("SO(157) = 1", 45, b"\x80"),
        ("so2()=127", 34, b"\x7f"),
        ("SO10()=&HA5", 40, b"\xa5"),
        ("SOW(2)=256", 4, b"\x00\x01"),
        ("SOW(15)=65535", 30, b"\xff\xff"),
        ("SOD(2)=69905", 4, b"\x11\x11\x01\x00"),
        ("SOD(14)=-2", 28, b"\xfe\xff\xff\xff"),
        ("SOW(127)=4660", 254, b"\x34\x12"),
        ("SOD(126)=&H12345678", 252, b"\x78\x56\x34\x12"),
        ("SO2()=511", 34, b"\xff"),
    ],
)
def test_a_program_writes_outputs(step: str, at: int, raw: bytes) -> None:
    """Rule: ports. Source: manual chapter 1, 4.1 and 4.2; chapter 3, 2.2."""
    master = run_steps(step, size=256)
    assert master.so[at : at + len(raw)] == raw
    assert not any(master.so[:at]) or at > 31
    assert not master.on("SO13")


@pytest.mark.parametrize(
    ("source", "at", "raw", "value"),
    [
        ("SI2()", 34, b"\x7f", 127),
        ("SI(21)", 34, b"\x7f", 1),
        ("SI0()", 32, b"", 0x41),
        ("SIW(2)", 4, b"\xff\x01", 511),
        ("SIW(2)", 4, b"\xff\xff", 65535),
        ("SID(2)", 4, b"\x10\x00\x01\x00", 65552),
        ("SID(2)", 4, b"\xff\xff\xff\xff", -1),
        ("SID(126)", 252, b"\x00\x00\x00\x80", -(2**31)),
    ],
)
def test_a_program_reads_inputs(source: str, at: int, raw: bytes, value: int) -> None:
    """Rule: ports. Source: manual chapter 3, 2.1."""
    program = RobotProgram(steps=(f"A%={source}",), loop=False)
    master = powered_up(programs=(program,), size=256)
    if raw:
        master.si[at : at + len(raw)] = raw
    master.turn_and_wait("SI12", True, 50)
    assert master.robot.program.variables["A%"] == value
    assert master.robot.read_port(source) == value


def test_a_program_waits_for_an_input_then_goes_on() -> None:
    """Rule: ports, program-length. Source: manual chapter 1, 2; chapter 3, 2.1."""
    master = run_steps("WAIT SI(20)=1", "SO(20)=1", "WAIT SIW(2)=&H1FF", "SO(21)=1")
    master.run(200)
    assert master.so[34] == 0
    master.si[34] |= 1
    master.run(5)
    assert master.so[34] == 1
    master.si[4:6] = b"\xff\x01"
    master.run(5)
    assert master.so[34] == 3
    assert not master.on("SO13")


def test_delays_and_pulses_take_their_time() -> None:
    """OUT with a time turns its output OFF after this time, while the program continues.

    Rule: program-length.
    """
    master = run_steps("OUT SO(20),100", "DELAY 300", "OUT SO(21)", "RESET SO(21)", "SO(22)=1")
    assert master.so[34] == 0b001
    master.run(80)  # 95 ms after the program's first cycle
    assert master.so[34] == 0b001
    master.run(5)
    assert master.so[34] == 0b000
    master.run(190)
    assert master.so[34] == 0b000
    master.run(20)
    assert master.so[34] == 0b100


def test_a_program_that_never_waits_leaves_time_for_the_others() -> None:
    """Rule: program-length."""
    endless = RobotProgram(steps=("A=SIW(2)", "SOW(3)=A"))
    master = powered_up(programs=(endless,))
    master.turn_and_wait("SI12", True)
    master.si[4:6] = b"\x34\x12"
    master.run(10)
    assert master.so[6:8] == b"\x34\x12"
    assert master.on("SO13")


@pytest.mark.parametrize(("knob", "at_rest"), [(True, 5), (False, 0)])
def test_words_of_the_program_are_shared_with_the_response(knob: bool, at_rest: int) -> None:
    """While a status is shown, SOW(2) is the response. Otherwise it is the program's word.

    Rule: shared-words.
    """
    master = powered_up(program_words_between_commands=knob)
    master.robot.write_port("SOW(2)", 5)
    master.run(10)
    assert master.words[2] == at_rest
    assert master.execute(0x0501)[2] == 0x0108
    assert master.words[2] == at_rest


def test_outputs_can_be_written_from_outside_as_a_program_writes_them() -> None:
    """Rule: ports."""
    master = powered_up()
    master.robot.write_port("SO(35)", 1)
    master.robot.write_port("SOD(6)", -5)
    master.run(5)
    assert master.so[35] == 0x20
    assert master.so[12:16] == b"\xfb\xff\xff\xff"
    assert master.robot.read_port("SOD(6)") == -5
    master.robot.write_port("SO(35)", 0)
    master.run(5)
    assert master.so[35] == 0


_NO_OUTPUTS = "SO(00) SO0() SO1() SO16() SO(160) SO8() SO(28) SOW(0) SOW(1) SOW(16) SOW(23) SOW(24)"
_NO_OUTPUTS += " SOD(3) SOD(15) SOX(2) SI(20) SO"


@pytest.mark.parametrize("name", _NO_OUTPUTS.split())
def test_a_name_that_is_not_an_output_of_this_board_is_refused(name: str) -> None:
    """Dedicated ports, ports beyond 15, reserved words and words beyond a short area are refused.

    Rule: ports.
    Source: manual chapter 1, 4.1; chapter 3, 2.2 (ports 2 to 15)
    """
    master = Master()
    with pytest.raises(InputError):
        master.robot.write_port(name, 1)


def test_the_last_word_of_the_extended_area_is_word_127() -> None:
    """Rule: ports."""
    master = Master(size=256)
    master.robot.write_port("SOW(127)", 1)
    with pytest.raises(InputError, match="not a general-purpose word"):
        master.robot.write_port("SOW(128)", 1)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (("SO(20)==1",), "'SO(20)==1'"),
        (("SI(20)=1",), "SI(20) is an input of the robot"),
        (("SOW(24)=1",), "extended area"),
        (("A=SIW(30)",), "extended area"),
        (("START 2",), "there is no program 2"),
        ("SO(20)=1", "cannot be 'SO(20)=1'"),
        ((3,), "cannot be (3,)"),
    ],
)
def test_steps_that_cannot_be_done_are_refused_at_once(steps: Any, message: str) -> None:
    """Rule: program-length."""
    with pytest.raises(InputError) as caught:
        RobotConfig(programs=(RobotProgram(steps=steps),))
    assert message in caught.value.message
