"""Movements of robot programs reach their targets, release the next statement, and stop."""

from __future__ import annotations

from itertools import pairwise

import pytest

from rcx_harness.robot import Axis
from robot_master import Master
from robot_programs import running, started

#: Two axes with 1000 pulses/mm, 1 000 000 pulses/s and 5 000 000 pulses/s^2.
XY = (Axis(), Axis())
#: From 0 to 100 mm the axis accelerates and brakes in 2 * sqrt(100 000 / 5 000 000) s. It is within
#: OUTPOS (2000 pulses) for the last sqrt(2 * 2000 / 5 000 000) s.
WAY_MS, OUT_MS = 282.8, 254.6


def when(master: Master, bit: int, within_ms: int = 3000) -> float:
    """Return the time [ms] at which a bit of SO2() turns ON."""
    for _ in range(within_ms // 5):
        if master.so[34] >> bit & 1:
            return master.now_us / 1000
        master.run(5)
    raise AssertionError(f"SO(2{bit}) stays OFF")


def timed(text: str, **config: object) -> tuple[float, float]:
    """Return the times [ms] from SO(20) ON until SO(21) and SO(22) turn ON."""
    master = started(f"WAIT SI(27)=1\nSO(20)=1\n{text}", axes=XY, **config)
    master.si[34] = 0x80
    begin = when(master, 0)
    return when(master, 1) - begin, when(master, 2) - begin


def test_the_next_statement_begins_in_the_out_position_range_and_wait_arm_waits_for_the_end() -> (
    None
):
    """The output turns ON 28 ms before the end of the movement.

    Rule: robot-language.
    Source: manual, remote command guide 4.2.1 (OUT valid position range)
    """
    out, end = timed("MOVE P,P1\nSO(21)=1\nWAIT ARM\nSO(22)=1")
    assert OUT_MS <= out <= OUT_MS + 15
    assert WAY_MS <= end <= WAY_MS + 15


def test_the_range_is_the_parameter_outpos() -> None:
    """With 50 000 pulses the next statement begins half way.

    Rule: robot-language.
    Source: manual, remote command guide 4.4.2 (OUTPOS)
    """
    out, _ = timed("OUTPOS(1)=50000\nOUTPOS(2)=50000\nMOVE P,P1\nSO(21)=1\nWAIT ARM\nSO(22)=1")
    assert WAY_MS / 2 <= out <= WAY_MS / 2 + 15


def test_the_next_movement_waits_for_the_end_of_the_one_before() -> None:
    """A movement there and back takes twice the time.

    With CONT the second movement begins in the OUT position range.

    Rule: robot-language.
    """
    there, back = "MOVE P,100.0 50.0 0 0 0 0", "MOVE P,0.0 0.0 0 0 0 0"
    plain, _ = timed(f"{there}\n{back}\nWAIT ARM\nSO(21)=1\nSO(22)=1")
    cont, _ = timed(f"{there},CONT\n{back}\nWAIT ARM\nSO(21)=1\nSO(22)=1")
    assert 2 * WAY_MS <= plain <= 2 * WAY_MS + 25
    assert OUT_MS + 2 * 130 <= cont < plain - 20


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("MOVE P,P1", (100_000, 50_000)),
        ("MOVE L,P1", (100_000, 50_000)),
        ("MOVE P,P1,P2", (20_000, 0)),
        ("MOVE P,P3", (5_000, 6_000)),
        ("MOVE P,10.0 -20.0 0.0 0.0 0.0 0.0", (10_000, -20_000)),
        ("MOVE P,P1,S=50,ACC=80,DEC=70", (100_000, 50_000)),
        ("MOVE L,P1,VEL=500", (100_000, 50_000)),
        ("MOVE C,10.0 10.0 0 0 0 0,20.0 0.0 0 0 0 0", (20_000, 0)),
        ("MOVEI P,P2\nMOVEI P,P2", (40_000, 0)),
        ("MOVEI L,P2", (20_000, 0)),
        ("MOVET P,P2", (20_000, 0)),
        ("DRIVE(2,P1)", (0, 50_000)),
        ("DRIVE(2,12.5)", (0, 12_500)),
        ("DRIVE(2,777)", (0, 777)),
        ("DRIVEI(1,5.0)\nDRIVEI(1,100)", (5_100, 0)),
        ("DRIVE(1,P1),(2,777)", (100_000, 777)),
        ("DRIVE(2,12.5),(1,P3),S=50", (5_000, 12_500)),
        ("DRIVEI(1,5.0),(2,P3)\nDRIVEI(1,P2),(2,1.0)", (25_000, 7_000)),
        ("PATH SET\nPATH L,P2\nPATH L,P1,S=50\nPATH END\nPATH START", (100_000, 50_000)),
        (
            "MOVE P,P2\nPATH SET P2\nPATH C,30.0 10.0 0 0 0 0,40.0 0.0 0 0 0 0\nPATH END\n"
            "PATH START",
            (40_000, 0),
        ),
        ("P10=P2\nP11=P2\nP12=P2\nP13=P2\nP14=P2\nPDEF(1)=1,1,1,P10\nPMOVE(1,1)", (20_000, 0)),
        ("PUSH(1,10.0)", (10_000, 0)),
        ("MOVE P,P1,A2=20.0{1.0,1.0}", (100_000, 50_000)),
        ("FOR I%=1 TO 2\nMOVE P,P[I%]\nNEXT", (20_000, 0)),
    ],
)
def test_a_movement_ends_at_its_target(text: str, places: tuple[int, int]) -> None:
    """The axes have 1000 pulses/mm. Each statement does what its remote command does.

    Rule: robot-language.
    Source: manual, remote command guide 4.2.1 to 4.2.5, 4.2.21, 4.2.23
    """
    master = running(text, 3000, axes=XY)
    assert tuple(master.robot.positions) == places
    assert master.robot.alarms.history == []


def test_the_speed_of_a_movement_is_a_part_of_the_automatic_speed() -> None:
    """At 10 % of 1000 mm/s the 100 mm take 1 s and the acceleration 0.02 s (100 000 / 5 000 000 s).

    Rule: robot-language.
    Source: manual, remote command guide 4.2.1 (speed)
    """
    for text in ("MOVE P,P1,S=10", "SPEED 10\nMOVE P,P1", "ASPEED 20\nMOVE P,P1,S=50",
                 "MOVE P,P1,DSPEED=10"):  # fmt: skip
        end, _ = timed(f"{text}\nWAIT ARM\nSO(21)=1\nSO(22)=1")
        assert 1020 <= end <= 1035, text


def test_stopon_ends_the_movement_and_the_program_continues() -> None:
    """The axis stops where it is when SI(20) turns ON.

    Rule: robot-language.
    """
    master = running("MOVE P,P1,S=10,STOPON SI(20)=1\nSO(20)=1", 500, axes=XY)
    assert master.so[34] == 0
    master.si[34] = 1
    master.run(20)
    assert master.so[34] == 1
    place = master.robot.positions[0]
    assert 0 < place < 100_000
    master.run(500)
    assert master.robot.positions[0] == place


def test_an_output_turns_on_when_the_tool_has_moved_a_distance() -> None:
    """The tool has moved 40 mm at 100 mm/s after about 0.41 s, and the line takes 1.02 s.

    Rule: robot-language.
    """
    text = "P5= 100.0 0.0 0.0 0.0 0.0 0.0\nMOVE L,P5,VEL=100,SO(21)=1@40.0\nSO(22)=1"
    way, end = timed(text)
    assert 405 <= way <= 430
    assert 980 <= end <= 1035


def test_a_stop_input_interrupts_a_movement_and_the_next_start_continues_it() -> None:
    """The program stays in the line of the movement, which restarts from the robot's position.

    Rule: robot-language.
    Source: manual, chapter 1, 4.2 (SI(06), SI(12)); chapter 5 (stop)
    """
    master = running("SO(21)=1\nMOVE P,P1,S=10\nSO(20)=1", 300, axes=XY)
    master.turn_and_wait("SI06", False, 300)
    place = master.robot.positions[0]
    assert 0 < place < 100_000
    assert not master.on("SO13")
    assert master.robot.program.tasks[0].line == 2
    master.turn_and_wait("SI06", True)
    assert master.robot.positions[0] == place
    master.pulse("SI12")
    master.run(1500)
    assert master.robot.positions[0] == 100_000
    assert master.so[34] == 3


def test_an_interrupted_relative_movement_continues_to_its_first_target() -> None:
    """The parameter "MOVEI start position" is Keep.

    Rule: robot-language.
    Source: manual, remote command guide 4.2.2 (MOVEI start position)
    """
    master = running("MOVEI P,P2,S=2\nSO(20)=1", 300, axes=XY)
    master.turn_and_wait("SI06", False, 300)
    assert 0 < master.robot.positions[0] < 20_000
    master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    master.run(2000)
    assert master.robot.positions[0] == 20_000


def test_an_emergency_stop_ends_program_and_movement_and_switches_the_servos_off() -> None:
    """The program stays at its movement with the servos off, and a start is refused.

    Rule: robot-language.
    Source: manual, chapter 1, 4.2 (SI(00))
    """
    master = running("MOVE P,P1,S=10\nSO(20)=1", 300, axes=XY)
    master.turn_and_wait("SI00", False, 100)
    assert not master.on("SO13")
    assert not master.on("SO02")
    place = master.robot.positions[0]
    master.run(500)
    assert master.robot.positions[0] == place


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("MOVE P,2000.0 0 0 0 0 0", "2.334"),  # beyond the soft limit (guide: soft limit over)
        ("SERVO OFF\nMOVE P,P1", "6.301"),
        ("MOVE P,P1,S=101", "4.2"),
        ("SPEED 0", "4.2"),
        ("DRIVE(3,P1)", "4.205"),
        ("PMOVE(5,1)", "6.236"),
    ],
)
def test_a_movement_that_is_refused_stops_the_program_with_the_alarm(
    text: str, number: str
) -> None:
    """The alarm is that of the remote command.

    Rule: robot-language.
    """
    master = running(text, 200, axes=XY)
    assert [alarm.number for alarm in master.robot.alarms.history] == [number]
    assert not master.on("SO13")
    assert master.robot.positions[0] == 0


def test_settings_are_those_of_the_remote_commands() -> None:
    """The program sets shift 1, hand 2, left-handed, ACCEL of axis 2 only and DECEL of all axes.

    Rule: robot-language.
    Source: manual, remote command guide 4.2.15 to 4.2.19, 4.4.2
    """
    text = "SHIFT S1\nCHANGE H2\nLEFTY\nACCEL(2)=40\nDECEL 60\nWEIGHT 2"
    machine = running(text, axes=XY).robot.machine
    settings, parameters = machine.arm(1).settings, machine.memory.parameters
    assert (settings.shift, settings.hand, settings.arm) == (1, 2, 1)
    assert [parameters.get(1, "ACCEL", place) for place in (0, 1)] == [100, 40]
    assert [parameters.get(1, "DECEL", place) for place in (0, 1)] == [60, 60]
    assert parameters.get(1, "WEIGHTG") == 2000


def test_servos_motor_power_and_origin_are_statements() -> None:
    """The servo of axis 1 is free, then ON again; the return-to-origin takes 500 ms.

    Rule: robot-language.
    Source: manual, remote command guide 4.2.12, 4.2.13, 4.2.20
    """
    master = running("SERVO FREE(1)\nDELAY 300\nSERVO ON\nORIGIN\nSO(20)=1", 50, axes=XY)
    assert master.robot.machine.servos.states == [2, 1]
    master.run(300)
    assert master.robot.machine.servos.states == [1, 1]
    assert master.so[34] == 0
    master.run(500)
    assert master.so[34] == 1
    assert master.robot.alarms.history == []


def test_a_second_robot_moves_beside_the_first() -> None:
    """MOVE[2] moves robot 2, which has only the third axis of the controller.

    Rule: robot-language.
    """
    axes = (Axis(), Axis(), Axis(robot=2))
    master = running("MOVE[2] P,3.0 0 0 0 0 0\nWAIT ARM[2]\nSO(20)=1", 1000, axes=axes)
    assert master.robot.positions == [0, 0, 3_000]
    assert master.so[34] == 1


def test_a_stop_input_is_not_an_error_of_the_program() -> None:
    """ON ERROR does not run, and 12.400 is in the history once.

    Rule: robot-language, stop-alarm.
    Source: manual, chapter 1, 4.2 (SI(06))
    """
    text = "ON ERROR GOTO *E\nMOVE P,P1,S=10\nSO(20)=1\nEND\n*E: SO(21)=1"
    master = running(text, 300, axes=XY)
    master.turn_and_wait("SI06", False, 300)
    assert master.so[34] == 0
    assert [alarm.number for alarm in master.robot.alarms.history] == ["12.400"]
    assert master.robot.program.errors == []
    master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    master.run(1500)
    assert master.so[34] == 1
    assert master.robot.positions[0] == 100_000


def test_several_axes_of_drive_start_and_end_together() -> None:
    """The axes move 100 mm and 20 mm in the same time.

    After half of it they are at 50 mm and 10 mm.

    Rule: robot-language.
    """
    master = started("WAIT SI(27)=1\nDRIVE(1,100.0),(2,20.0)", axes=XY)
    master.si[34] = 0x80
    ways = []
    for _ in range(100):
        master.run(5)
        ways.append(tuple(master.robot.positions))
    assert ways[-1] == (100_000, 20_000)
    assert all(abs(x - 5 * y) <= 5 for x, y in ways)
    assert len(set(ways)) > 20


#: A path of two lines: from (0, 0) to (100, 0), then to (200, 0) mm.
STRAIGHT = "PATH SET\nPATH L,100.0 0.0 0 0 0 0{0}\nPATH L,200.0 0.0 0 0 0 0{0}\nPATH END"


def test_a_path_does_not_stop_between_its_parts() -> None:
    """200 mm at 500 mm/s take 0.4 s, plus 0.1 s for the acceleration.

    Two separate lines accelerate twice.

    Rule: robot-language.
    """
    path = STRAIGHT.format(",VEL=500")
    _, end = timed(f"{path}\nPATH START\nSO(21)=1\nWAIT ARM\nSO(22)=1")
    assert 500 <= end <= 525
    lines = "MOVE L,100.0 0.0 0 0 0 0,VEL=500\nMOVE L,200.0 0.0 0 0 0 0,VEL=500"
    _, twice = timed(f"{lines}\nSO(21)=1\nWAIT ARM\nSO(22)=1")
    assert twice > end + 80


def test_each_part_of_a_path_has_its_own_speed() -> None:
    """100 mm at 500 mm/s and 100 mm at 100 mm/s take more than 1.2 s and less than 1.35 s.

    Rule: robot-language.
    """
    path = "PATH SET\nPATH L,100.0 0.0 0 0 0 0,VEL=500\nPATH L,200.0 0.0 0 0 0 0,VEL=100\nPATH END"
    _, end = timed(f"{path}\nPATH START\nSO(21)=1\nWAIT ARM\nSO(22)=1")
    assert 1200 <= end <= 1350


def test_an_axis_does_not_exceed_its_acceleration_at_a_corner() -> None:
    """At the corner (100, 0) the tool turns by 90 degrees to (100, 100) mm.

    Rule: robot-language.
    """
    path = "PATH SET\nPATH L,100.0 0.0 0 0 0 0\nPATH L,100.0 100.0 0 0 0 0\nPATH END\nPATH START"
    master = started(f"WAIT SI(27)=1\n{path}", axes=XY)
    master.si[34] = 0x80
    ways = []
    for _ in range(180):
        master.run(5)
        ways.append(tuple(master.robot.positions))
    assert ways[-1] == (100_000, 100_000)
    assert all(100_000 - x <= 5_000 or y == 0 for x, y in ways)  # cycles within 5 mm of the corner
    for k in (0, 1):
        speeds = [b[k] - a[k] for a, b in pairwise(ways)]
        changes = [abs(b - a) for a, b in pairwise(speeds)]
        assert max(changes) <= 5_000_000 * 0.005**2 + 3  # in pulses per cycle squared


def test_an_interrupted_path_continues_from_where_the_robot_stands() -> None:
    """A stop comes while the robot is on the second line of the path.

    It does not go back to the first line.

    Rule: robot-language.
    Source: manual, chapter 1, 4.2 (SI(06), SI(12))
    """
    path = "PATH SET\nPATH L,50.0 0.0 0 0 0 0,VEL=100\nPATH L,50.0 50.0 0 0 0 0,VEL=100\nPATH END"
    master = running(f"{path}\nPATH START\nWAIT ARM\nSO(20)=1", 700, axes=XY)
    master.turn_and_wait("SI06", False, 100)
    x, y = master.robot.positions
    assert x == 50_000
    assert 0 < y < 50_000
    master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    seen = []
    for _ in range(200):
        master.run(5)
        seen.append(tuple(master.robot.positions))
    assert seen[-1] == (50_000, 50_000)
    assert all(abs(one[0] - 50_000) <= 1 and one[1] >= y for one in seen)
    assert master.so[34] & 1


@pytest.mark.parametrize(
    "text",
    [
        "PATH START",
        "PATH SET\nPATH END\nPATH START",
        "PATH SET\nPATH L,P1\nPATH START",
        "PATH L,P1",
        "PATH END",
        "PATH SET P1\nPATH L,P2\nPATH END\nPATH START",  # the robot is not at P1
    ],
)
def test_a_path_that_is_not_defined_or_begins_elsewhere_gets_an_alarm(text: str) -> None:
    """Rule: robot-language."""
    master = running(text, 200, axes=XY)
    assert [alarm.number for alarm in master.robot.alarms.history] == ["5.997"]


def test_wait_arm_waits_for_the_given_axes() -> None:
    """Axis 2 does not move, so WAIT ARM(2) ends at once. WAIT ARM(1) ends with the movement.

    Rule: robot-language.
    """
    text = "OUTPOS(1)=90000\nMOVE P,P2\nWAIT ARM(2)\nSO(21)=1\nWAIT ARM(1)\nSO(22)=1"
    one, other = timed(text)
    assert one <= 30
    assert other > 100


def test_wait_arm_ends_when_the_given_axis_is_within_its_tolerance() -> None:
    """Axis 2 moves 50 mm and has a tolerance of 12.5 mm, so it arrives early.

    Axis 1 is then 25 mm before its target, which it needs sqrt(2 * 25 000 / 5 000 000) s to reach.

    Rule: robot-language.
    """
    text = (
        "OUTPOS(1)=50000\nOUTPOS(2)=50000\nTOLE(2)=12500\n"
        "MOVE P,P1\nWAIT ARM(2)\nSO(21)=1\nWAIT ARM\nSO(22)=1"
    )
    near, end = timed(text, end_in_tolerance=True)
    assert WAY_MS - 100 <= near <= WAY_MS - 100 + 15
    assert WAY_MS <= end <= WAY_MS + 15


def test_the_heights_of_an_arch_are_in_millimetres_if_they_have_a_decimal_point() -> None:
    """Axis 2 goes to 20 mm, which is 20 000 pulses, and ends at its target at 0.

    The position is read every 5 ms, so the highest position that is read may be slightly lower.

    Rule: robot-language.
    Source: manual, remote command guide 4.2.1 (arch option)
    """
    highest = []
    for height in ("20.0{1.0,1.0}", "20000{1000,1000}"):
        master = started(f"MOVE P,P2,A2={height}", axes=XY)
        places = []
        for _ in range(300):
            master.run(5)
            places.append(master.robot.positions[1])
        highest.append(max(places))
        assert tuple(master.robot.positions) == (20_000, 0)
    assert all(19_950 <= place <= 20_000 for place in highest)
