"""Commands assign values to I/O ports and read them."""

from __future__ import annotations

import pytest

from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.robot.ports import port
from robot_master import NORMAL_END, Master, abnormal_end, powered_up
from structured_text.errors import InputError

WRITE, WRITE_BIT, READ = 0x300, 0x301, 0x304
DI, DO, MO, LO, TO, SI, SO = range(7)


def _word(kind: int, port: int, bit: int = 0) -> int:
    """Return word n+4 for a port by its name: 12 for DO12()."""
    return kind << 12 | port // 10 << 8 | port % 10 << 4 | bit


def _value(master: Master, kind: int, port: int) -> int:
    word = _word(kind, port)
    answer = master.execute(READ, 0, word)
    assert answer == (0x0200, 0, word, answer[3], *(0,) * 12)
    return answer[3]


def test_the_printed_example_switches_bit_1_of_do2() -> None:
    """DO(21) = 1 is the word 0x1021.

    The other bits do not change.

    Source: remote command guide 4.5.1.
    """
    master = powered_up()
    master.execute(WRITE, 0, _word(DO, 2), 0b1000_0000)
    assert master.execute(0x0301, 0, 0x1021, 1) == NORMAL_END
    assert _value(master, DO, 2) == 0b1000_0010
    assert master.execute(0x0301, 0, 0x1021, 0) == NORMAL_END
    assert _value(master, DO, 2) == 0b1000_0000


def test_the_stop_signal_of_the_parallel_board_is_di06() -> None:
    """Source: manual chapter 1, 4.1; remote command guide 4.5.1."""
    master = powered_up(parallel_io="valid")
    assert _value(master, DI, 0) == 0x40
    master.robot.inject("parallel_stop")
    assert _value(master, DI, 0) == 0
    assert _value(powered_up(), DI, 0) == 0


@pytest.mark.parametrize("kind", [DO, MO, SO])
def test_output_ports_2_to_7_10_to_17_and_20_to_27_can_be_assigned(kind: int) -> None:
    """Each port keeps its own value while other ports have other values.

    Rule: port-commands, other-ports.
    Source: remote command guide 4.5.1
    """
    master = powered_up()
    ports = [*range(2, 8), *range(10, 18), *range(20, 28)]
    for number in ports:
        assert master.execute(WRITE, 0, _word(kind, number), 100 + number) == NORMAL_END
    assert [_value(master, kind, number) for number in ports] == [100 + one for one in ports]


@pytest.mark.parametrize(("kind", "ports"), [(LO, (0, 1)), (TO, (0,))])
def test_arm_lock_and_timer_outputs_can_be_assigned(kind: int, ports: tuple[int, ...]) -> None:
    """Source: remote command guide 4.5.1."""
    master = powered_up()
    for number in ports:
        master.execute(WRITE, 0, _word(kind, number), 0xA0 + number)
        master.execute(WRITE_BIT, 0, _word(kind, number, 3), 1)
    assert [_value(master, kind, number) for number in ports] == [0xA8 + one for one in ports]
    after = _word(kind, ports[-1] + 1)
    assert master.execute(WRITE, 0, after, 1) == abnormal_end("4.2")
    assert master.execute(READ, 0, after) == abnormal_end("4.2")


@pytest.mark.parametrize("kind", [DO, MO, SO])
@pytest.mark.parametrize("number", [0, 1, 8, 9, 18, 19, 28, 30])
def test_other_output_ports_cannot_be_assigned(kind: int, number: int) -> None:
    """Source: remote command guide 4.5.1."""
    master = powered_up()
    assert master.execute(WRITE, 0, _word(kind, number), 1) == abnormal_end("4.2")
    assert master.execute(WRITE_BIT, 0, _word(kind, number), 1) == abnormal_end("4.2")


@pytest.mark.parametrize("code", [WRITE, WRITE_BIT])
@pytest.mark.parametrize("kind", [DI, SI, 7, 15])
def test_inputs_and_unknown_port_types_cannot_be_assigned(code: int, kind: int) -> None:
    """Source: remote command guide 4.5.1."""
    assert powered_up().execute(code, 0, _word(kind, 2), 1) == abnormal_end("4.2")


@pytest.mark.parametrize("kind", [DI, DO, MO, SI, SO])
def test_ports_0_to_7_10_to_17_and_20_to_27_can_be_read(kind: int) -> None:
    """Source: remote command guide 4.5.1."""
    master = powered_up()
    for number in (0, 7, 10, 17, 20, 27):
        assert master.execute(READ, 0, _word(kind, number))[0] == 0x0200
    for number in (8, 18, 28, 30):
        assert master.execute(READ, 0, _word(kind, number)) == abnormal_end("4.2")


@pytest.mark.parametrize(
    "words",
    [
        (WRITE, 0, _word(DO, 2, 1), 1),  # a bit number in port units
        (WRITE, 0, _word(DO, 2), 0x100),
        (WRITE_BIT, 0, _word(DO, 2, 8), 1),
        (WRITE_BIT, 0, _word(DO, 2), 2),
        (READ, 0, _word(DO, 2, 1)),
        (READ, 0, _word(7, 2)),
        (READ, 0, _word(DO, 2), 1),
    ],
)
def test_bit_number_and_pattern_have_their_limits(words: tuple[int, ...]) -> None:
    """Source: remote command guide 4.5.1."""
    assert powered_up().execute(*words) == abnormal_end("4.2")


def test_serial_outputs_are_what_the_master_reads() -> None:
    """SO15() is byte m+45. SO16() lies beyond the board, so its value is only stored.

    Rule: port-commands, other-ports.
    Source: remote command guide 4.5.1; manual chapter 1, 4.1
    """
    master = powered_up()
    master.execute(WRITE, 0, _word(SO, 2), 0x81)
    master.execute(WRITE_BIT, 0, _word(SO, 15, 6), 1)
    master.execute(WRITE, 0, _word(SO, 16), 0xFF)
    assert (master.so[34], master.so[45], master.so[46]) == (0x81, 0x40, 0)


def test_serial_inputs_are_what_the_master_sends() -> None:
    """SI13() is byte n+43. SI0() has the dedicated inputs: here SI(00) and SI(06) are ON.

    Source: remote command guide 4.5.1; manual chapter 1, 4.1
    """
    master = powered_up()
    master.si[43] = 0xC3
    assert _value(master, SI, 13) == 0xC3
    assert _value(master, SI, 0) == 0b0100_0001
    assert _value(master, SI, 16) == 0


def test_dedicated_outputs_are_read_as_so0_and_so1() -> None:
    """SO(01), SO(02), SO(04), SO(10) and SO(11) are ON in AUTO mode with the servos on.

    No program is running.

    Rule: other-ports.
    Source: remote command guide 4.5.1
    """
    master = powered_up()
    master.pulse("SI01")
    assert (_value(master, SO, 0), _value(master, SO, 1)) == (0b0001_0110, 0b0000_0011)
    assert (master.so[32], master.so[33]) == (0b0001_0110, 0b0000_0011)
    assert (_value(master, DO, 0), _value(master, DO, 1)) == (0, 0)


def test_robot_programs_and_the_commands_use_the_same_ports() -> None:
    """When DI(20) turns ON, the program copies MO2(), which a command has set, to SO3().

    Source: remote command guide 4.5.1
    """
    steps = ("WAIT DI(20)=1", "A=MO2()", "SO3()=A", "DO(30)=1", "LO(01)=1")
    master = powered_up(programs=(RobotProgram(steps=steps, loop=False),))
    master.execute(WRITE, 0, _word(MO, 2), 0x5A)
    master.pulse("SI12")
    assert master.so[35] == 0
    master.robot.inject("parallel_input", port=20, on=1)
    master.run(10)
    assert master.so[35] == 0x5A
    assert (_value(master, DO, 3), _value(master, LO, 0)) == (1, 2)


@pytest.mark.parametrize(
    "name", ["DO1()", "MO(17)", "LO2()", "TO1()", "DO30()", "DI(300)", "DI(8)"]
)
def test_robot_programs_have_the_same_ports_as_the_commands(name: str) -> None:
    """Source: remote command guide 4.5.1."""
    with pytest.raises(InputError, match=r"is not a port|cannot have"):
        RobotConfig(programs=(RobotProgram(steps=(f"SO(20)={name}",)),))
    with pytest.raises(InputError, match="is not a port"):
        port(name)


@pytest.mark.parametrize("name", ["SI(20)", "SO(20)", "DO(20)"])
def test_only_inputs_of_the_parallel_board_are_set_from_outside(name: str) -> None:
    ports = powered_up().robot.machine.ports
    with pytest.raises(InputError, match="not an input of the parallel I/O board"):
        ports.set_input(port(name), 1)


def test_power_on_clears_the_ports() -> None:
    """Rule: outputs-kept."""
    master = powered_up()
    for kind in (DO, MO, SO):
        master.execute(WRITE, 0, _word(kind, 2), 1)
    master.robot.inject("power_cycle")
    master.run(500)
    assert [_value(master, kind, 2) for kind in (DO, MO, SO)] == [0, 0, 0]


def test_a_program_reset_clears_all_outputs_where_the_controller_is_set_so() -> None:
    """Rule: outputs-kept."""
    for clears in (False, True):
        master = powered_up(reset_clears_outputs=clears)
        for kind in (DO, MO, SO):
            master.execute(WRITE, 0, _word(kind, 2), 1)
        master.pulse("SI15")
        assert [_value(master, kind, 2) for kind in (DO, MO, SO)] == [int(not clears)] * 3
