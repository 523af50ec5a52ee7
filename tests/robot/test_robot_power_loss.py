"""Effects of motor power, main power and power cycles on programs, movements, data and outputs."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rcx_harness.robot.config import RobotProgram
from robot_master import Master, powered_up, servos_on

BRAKE, SERVO, FREE = 0, 1, 2  # guide, 4.7.3
MOVE = (0x0009, 0x0000, 0, 0, 0x0001)
POINT_1 = (0x0100, 0, 1, 0, 0x86A0, 0x0001)


def _states(master: Master) -> tuple[int, ...]:
    """Return the servo states of axes 1 to 4, as the servo status command reads them."""
    return master.execute(0x1503)[2:6]


_OFF: dict[str, Callable[[Master], None]] = {
    "main power": lambda master: master.robot.inject("main_power_off"),
    "0x0041": lambda master: _send(master, 0x0041),
}


def _send(master: Master, *words: int) -> None:
    assert master.execute(*words)[0] == 0x0200


@pytest.mark.parametrize(("knob", "runs"), [(True, False), (False, True)])
@pytest.mark.parametrize("off", _OFF)
def test_without_motor_power_the_program_stops_or_goes_on(off: str, knob: bool, runs: bool) -> None:
    """The program does not start by itself when power returns.

    Rule: main-power, servo-off-command.
    """
    master = servos_on(motor_power_stops_program=knob)
    master.pulse("SI12")
    assert master.on("SO13")
    _OFF[off](master)
    master.run(20)
    assert not master.on("SO02")
    assert master.on("SO13") is runs
    assert not master.on("SO03")
    master.robot.inject("main_power_on")
    master.pulse("SI01")
    assert master.on("SO02")
    assert master.on("SO13") is runs
    if not runs:
        master.pulse("SI12")
        assert master.on("SO13")


@pytest.mark.parametrize("programs", [True, False])
def test_a_movement_ends_with_the_main_power(programs: bool) -> None:
    """A loss of main power ends a movement, whether programs continue or not. Rule: main-power."""
    master = servos_on(motor_power_stops_program=programs, servo_off_alarm="6.301")
    _send(master, *POINT_1)
    master.send(*MOVE)
    master.run(50)
    master.robot.inject("main_power_off")
    master.run(5)
    assert master.words[:3] == (0x4000, 6, 301)
    assert 0 < master.robot.positions[0] < 100_000


@pytest.mark.parametrize(("alarm", "expected"), [("", []), ("17.1", ["17.1"])])
def test_the_loss_of_main_power_may_be_an_alarm(alarm: str, expected: list[str]) -> None:
    """A loss of main power is a single alarm, even if the event is repeated. Rule: main-power."""
    master = powered_up(main_power_alarm=alarm)
    for event in ("main_power_off", "main_power_off", "main_power_on"):
        master.robot.inject(event)
        master.run(10)
    assert [one.number for one in master.robot.alarms.history] == expected
    assert master.on("SO03") is bool(alarm)
    assert master.on("SO04") is not bool(alarm)


_SERVOS_OFF: dict[str, Callable[[Master], None]] = {
    "terminal": lambda master: master.robot.inject("emergency_stop"),
    "SI00": lambda master: master.turn("SI00", False),
    "alarm": lambda master: master.robot.inject("alarm"),
    "main power": lambda master: master.robot.inject("main_power_off"),
}


@pytest.mark.parametrize(("knob", "state"), [(True, BRAKE), (False, FREE)])
@pytest.mark.parametrize("off", _SERVOS_OFF)
def test_a_key_decides_whether_a_free_axis_is_braked_when_all_servos_go_off(
    off: str, knob: bool, state: int
) -> None:
    """A free axis stays free or is braked.

    All other axes are braked in both cases. Rule: free-axes.
    """
    master = servos_on(servo_off_brakes_free_axes=knob)
    _send(master, 0x0036, 0, 0x0008)  # servo free of axis 4, as in the guide's example of 4.2.13
    assert _states(master) == (SERVO, SERVO, SERVO, FREE)
    _SERVOS_OFF[off](master)
    master.run(20)
    assert _states(master) == (BRAKE, BRAKE, BRAKE, state)


@pytest.mark.parametrize("knob", [True, False])
def test_motor_power_off_and_power_off_lock_every_brake(knob: bool) -> None:
    """Rule: free-axes, motor-power.

    Source: remote command guide 4.2.20: the dynamic brake is applied and locked
    """
    master = servos_on(servo_off_brakes_free_axes=knob)
    _send(master, 0x0036)
    assert _states(master) == (FREE,) * 4
    _send(master, 0x0041)
    assert _states(master) == (BRAKE,) * 4
    _send(master, 0x0036)
    master.robot.inject("power_cycle")
    master.run(300)
    assert _states(master) == (BRAKE,) * 4


def _pattern(master: Master, kind: int, port: int) -> int:
    """Return the value of an I/O port, as the port command reads it (guide, 4.5.1).

    The kinds are DI 0, DO 1, MO 2, LO 3, TO 4 and SO 6.
    """
    return master.execute(0x0304, 0, kind << 12 | port << 4)[3]


@pytest.mark.parametrize(("clears", "kept"), [(True, 0x00), (False, 0x01)])
def test_a_key_decides_which_outputs_survive_power_on(clears: bool, kept: int) -> None:
    """DO and SO are always OFF after power-on.

    A key decides whether MO, LO and TO keep their states.

    Rule: internal-outputs, outputs-kept.
    """
    master = powered_up(power_clears_internal_outputs=clears)
    ports = [(1, 2), (2, 2), (2, 0x27), (3, 0), (3, 1), (4, 0), (6, 2)]
    for kind, port in ports:
        _send(master, 0x0300, 0, kind << 12 | port << 4, 0x01)
        assert _pattern(master, kind, port) == 0x01
    master.robot.inject("power_cycle")
    master.run(300)
    found = [_pattern(master, kind, port) for kind, port in ports]
    assert found == [0, kept, kept, kept, kept, kept, 0]


@pytest.mark.parametrize(
    ("clears", "integer", "real"),
    [(False, (7, 0), (0x0000, 0x40E0)), (True, (0, 0), (0, 0))],
)
def test_a_key_decides_whether_static_variables_survive_power_on(
    clears: bool, integer: tuple[int, int], real: tuple[int, int]
) -> None:
    """The test writes 7 to SGI30 and 7.0 to SGR2 (16#40E00000), which are variables 30 and 258.

    Rule: static-variables. Source: remote command guide 4.4.1.
    """
    values = {"SGI30": 7, "SGR2": 7.0}
    master = powered_up(variables=values, power_clears_variables=clears)
    assert master.execute(0x0214, 0, 30)[4:6] == (7, 0)
    master.robot.inject("power_cycle")
    master.run(300)
    _send(master, 0x0041)
    assert master.execute(0x0214, 0, 30)[4:6] == integer
    assert master.execute(0x0214, 0, 258)[4:6] == real


def test_inputs_of_the_parallel_board_stay_through_a_power_cycle() -> None:
    """A power cycle does not change them, because external devices set these inputs.

    Rule: power-on-state.
    """
    master = powered_up(parallel_io="valid")
    master.robot.inject("parallel_input", port=20, on=1)
    master.robot.inject("parallel_stop")
    master.robot.inject("manual_mode")
    master.robot.inject("pendant_on")
    master.robot.inject("main_power_off")
    master.robot.inject("power_cycle")
    master.run(300)
    assert _pattern(master, 0, 2) == 0x01
    assert master.robot.machine.stopped
    assert not master.on("SO10")
    assert not master.on("SO04")
    master.pulse("SI15")
    assert not master.on("SO14")
    for event in ("auto_mode", "main_power_on"):
        master.robot.inject(event)
    master.pulse("SI15")
    assert not master.on("SO14")  # the programming box has authority
    master.robot.inject("pendant_off")
    master.pulse("SI15")
    assert master.on("SO14")


def test_a_power_cycle_ends_alarms_and_warning_and_keeps_the_history() -> None:
    """The alarm history stays. Programs are at their first line, and their variables are 0.

    Rule: power-cycle.
    """
    steps = ("A=7", "WAIT SI(20)=1")
    master = powered_up(programs=(RobotProgram(steps=steps, loop=False),))
    assert master.execute(0x0101, 0, 7)[:3] == (0x4000, 6, 204)
    master.pulse("SI12")
    master.robot.inject("warning")
    master.robot.inject("alarm", group=12, category=762)
    master.run(10)
    assert (master.on("SO03"), master.on("SO15")) == (True, True)
    assert (master.robot.program.main.line, master.robot.program.variables) == (2, {"A": 7})
    master.robot.inject("power_cycle")
    master.run(300)
    assert (master.on("SO03"), master.on("SO15")) == (False, False)
    assert master.execute(0x0509, 0, 1)[1:3] == (12, 762)
    assert master.execute(0x0515)[1:3] == (6, 204)
    assert (master.robot.program.main.line, master.robot.program.variables) == (1, {})


@pytest.mark.parametrize(("knob", "warning"), [(False, True), (True, False)])
@pytest.mark.parametrize("by_command", [False, True])
def test_a_key_decides_whether_an_alarm_reset_clears_a_warning(
    knob: bool, warning: bool, by_command: bool
) -> None:
    """Rule: warning-reset."""
    master = powered_up(reset_clears_warning=knob)
    master.robot.inject("warning")
    if by_command:
        _send(master, 0x0604)
    else:
        master.pulse("SI16")
    assert master.on("SO15") is warning


@pytest.mark.parametrize(("alarms", "ok"), [((), True), (("12.900",), False)])
def test_only_alarms_of_cpu_fault_alarms_switch_cpu_ok_off(
    alarms: tuple[str, ...], ok: bool
) -> None:
    """Rule: cpu-ok."""
    master = powered_up(cpu_fault_alarms=alarms)
    master.robot.inject("alarm")
    master.run(5)
    assert master.on("SO01")
    master.robot.inject("alarm", group=12, category=900)
    master.run(5)
    assert master.on("SO01") is ok


def test_a_serious_alarm_that_leaves_the_servos_on_keeps_everything_from_starting() -> None:
    """A running program continues. Rule: alarm-stops."""
    master = servos_on(alarm_stops_servo=False)
    _send(master, *POINT_1)
    master.pulse("SI12")
    master.robot.inject("alarm", group=17, category=5)
    master.run(50)
    assert (master.on("SO02"), master.on("SO13")) == (True, True)
    assert master.execute(*MOVE)[:3] == (0x4000, 17, 5)
    assert master.execute(0x0032)[:3] == (0x4000, 17, 5)
    master.pulse("SI17")
    assert master.on("SO11")
    assert not master.robot.machine.origin_running
    master.drop("SI06")
    master.pulse("SI12")
    assert not master.on("SO13")
    assert master.execute(0x0402)[:3] == (0x4000, 17, 5)
    master.pulse("SI16")
    assert master.execute(*MOVE)[0] == 0x0200


@pytest.mark.parametrize("event", ["pendant_on", "safety_on"])
def test_a_command_that_runs_when_commands_are_disabled_goes_on_to_its_end(event: str) -> None:
    """Rule: disabled-while-running. Source: remote command guide chapter 3, restrictions."""
    master = servos_on()
    _send(master, *POINT_1)
    master.send(*MOVE)
    master.run(50)
    master.robot.inject(event)
    assert master.finish()[0] == 0x0200
    master.send()
    master.run(10)
    assert master.status == 0
    master.send(*MOVE)
    master.run(100)
    assert master.status == (0x4000 if event == "pendant_on" else 0)
