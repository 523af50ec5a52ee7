"""Motion: servos ON, a few pulses at 1 % of the manual speed, and the user's own programs."""

from __future__ import annotations

from rcx_harness.look.probe.asker import Asker, telegram
from rcx_harness.look.probe.question import moving
from rcx_harness.look.probe.questions.signals import reset
from rcx_harness.spec.wire import ENDS, NORMAL_END, READY, RUN

_LATE_US = 500_000
_SLOW, _LITTLE = 1, 10


def _servos_on(ask: Asker) -> None:
    reset(ask)
    ask.turn("SI06", True)
    ask.turn("SI01", True)
    ask.needs(ask.until(lambda: ask.on("SO02")) is not None, "the servos did not turn ON")
    ask.turn("SI01", False)


def _servos_off(ask: Asker) -> None:
    """Switch the servos off by an emergency stop, the most reliable way."""
    ask.turn("SI00", False)
    ask.until(lambda: not ask.on("SO02"))


@moving(
    {"answers": ("servo_on_delay",), "servo-needs-reset": ("servo_on_with_alarm",)},
    does="SI(01) switches the servos ON; no axis is moved.",
)
def servo_on(ask: Asker) -> None:
    """How long does servo ON take, and does it work before the alarm reset?"""
    reset(ask)
    ask.turn("SI00", False)
    ask.needs(ask.until(lambda: ask.on("SO03")) is not None, "SO(03) did not turn ON")
    ask.turn("SI00", True)
    ask.until(lambda: not ask.on("SO00"))
    ask.turn("SI01", True)
    early = ask.until(lambda: ask.on("SO02"), 2 * _LATE_US) is not None
    ask.turn("SI01", False)
    text = f"SO(02) {'turned ON' if early else 'stayed OFF'} with SI(01) while SO(03) was ON"
    ask.knob("servo_on_with_alarm", early, text=text)
    if early:
        _servos_off(ask)
    reset(ask)
    ask.turn("SI01", True)
    us = ask.until(lambda: ask.on("SO02"))
    ask.turn("SI01", False)
    _servos_off(ask)
    ask.needs(us is not None, "SO(02) did not turn ON")
    ask.delay("servo_on_delay", us or 0, f"SO(02) ON after {(us or 0) / 1000:g} ms")


@moving(
    {"servo-on-command": ("servo_needs_motor_power", "motor_power_alarm")},
    does="The motor power is switched OFF, then servo ON of axis 1 is requested.",
)
def motor_power(ask: Asker) -> None:
    """Does a servo go ON by command without motor power?"""
    reset(ask)
    ask.command("MotorPowerOff")
    ask.needs(not ask.on("SO02"), "SO(02) stays ON")
    answer = ask.command("ServoOn", 1, axes=1)
    _servos_off(ask)
    needs = bool(answer.alarm)
    text = f"servo ON without motor power ended {'in ' + answer.alarm if needs else 'normally'}"
    ask.knob("servo_needs_motor_power", needs, text=text)
    if needs:
        ask.knob("motor_power_alarm", answer.alarm, text=text)


@moving(
    {"unasked-positions": ("unasked_positions_zero",)},
    does="Axis 1 of robot 1 inches 10 pulses forth and back at 1 % of the manual speed.",
)
def unasked_positions(ask: Asker) -> None:
    """What is in the response of a movement if no position was requested?"""
    speed = ask.command("ReadSpeeds", 1).fields.get("manual_speed", 20)
    amount = ask.command("ReadInchingAmount", 1).fields.get("amount", 100)
    ask.command("SetManualSpeed", 1, speed=_SLOW)
    ask.command("SetInchingAmount", 1, amount=_LITTLE)
    try:
        _servos_on(ask)
        answers = [ask.command("InchPulses", 1, axes=1, direction=way) for way in (0, 1)]
    finally:
        _servos_off(ask)
        ask.command("SetManualSpeed", 1, speed=speed)
        ask.command("SetInchingAmount", 1, amount=amount)
    ask.needs(all(one.status == NORMAL_END for one in answers), "the inching ended in an alarm")
    zero = not any(answers[0].words[4:])  # after an inching at least one axis is not at 0
    text = f"m+8 to m+30 {'are 0' if zero else 'have positions'}"
    ask.knob("unasked_positions_zero", zero, text=text)


@moving(
    {"jog-cleared": ()},
    does="Axis 1 of robot 1 jogs for half a second at 1 % of the manual speed.",
)
def jog_cleared(ask: Asker) -> None:
    """Does a jog whose command is cleared continue until SI(06) is OFF?"""
    speed = ask.command("ReadSpeeds", 1).fields.get("manual_speed", 20)
    ask.command("SetManualSpeed", 1, speed=_SLOW)
    try:
        _servos_on(ask)
        ask.send(telegram("JogPulses", 1, axes=1))
        began = ask.until(lambda: ask.status == RUN) is not None
        ask.send((0,) * 16)
        ask.wait(_LATE_US)
        goes_on = ask.status == RUN
        ask.turn("SI06", False)
        ended = ask.until(lambda: ask.status == READY) is not None
    finally:
        ask.turn("SI06", False)
        _servos_off(ask)
        ask.send((0,) * 16)
        ask.until(lambda: ask.status not in ENDS)
        ask.command("SetManualSpeed", 1, speed=speed)
    ask.needs(began, "the jog did not begin")
    text = f"0x0100 {'stayed' if goes_on else 'did not stay'} after the code was cleared"
    ask.rule("jog-cleared", goes_on and ended, text)


@moving(
    {
        "program-servo": ("program_needs_servo",),
        "program-reset-running": ("reset_while_running",),
        "program-info-details": ("program_info_while_running",),
        "servo-off-command": ("motor_power_stops_program",),
        "busy-programs": (),
        "other-alarms": ("busy_alarm",),
        "answers": ("program_start_delay", "program_stop_delay"),
    },
    does="SI(12) starts YOUR robot program with the servos OFF or, if necessary, ON.",
)
def program(ask: Asker) -> None:
    """What starts and stops a robot program?"""
    reset(ask)
    ask.needs(ask.on("SO10") and not ask.on("SO13"), "not in AUTO mode, or a program runs")
    ask.turn("SI06", True)
    us = _start(ask)
    text = (
        f"SO(13) {'turned ON' if us is not None else 'stayed OFF'} with SI(12) and the servos OFF"
    )
    ask.knob("program_needs_servo", us is None, text=text)
    if us is None:
        _servos_on(ask)
        us = _start(ask)
    ask.needs(us is not None, "the program did not start")
    ask.delay("program_start_delay", us or 0, f"SO(13) ON after {(us or 0) / 1000:g} ms")
    try:
        answer = ask.command("ReadProgramInfo", method=1, program=1)
        if ask.on("SO13"):
            text = f"0x0408 ended {'in ' + answer.alarm if answer.alarm else 'normally'}"
            ask.knob("program_info_while_running", not answer.alarm, text=f"{text} during the run")
        answer = ask.command("StepProgram", method=1, program=1)
        if ask.on("SO13"):
            text = f"a step of the running program: alarm {answer.alarm or 'none'}"
            ask.rule("busy-programs", bool(answer.alarm), text)
            if answer.alarm:
                ask.knob("busy_alarm", answer.alarm, text=text)
        ask.pulse("SI15")
        if ask.on("SO13") or ask.on("SO14"):
            was_reset = ask.on("SO14")
            text = f"SO(14) is {'ON' if was_reset else 'OFF'} after SI(15) during the run"
            ask.knob("reset_while_running", was_reset, text=text)
        if not ask.on("SO13"):
            _start(ask)
        ask.needs(ask.on("SO13"), "the program has ended too soon")
        ask.turn("SI06", False)
        us = ask.until(lambda: not ask.on("SO13"))
        ask.needs(us is not None, "SO(13) did not turn OFF")
        ask.delay("program_stop_delay", us or 0, f"SO(13) OFF after {(us or 0) / 1000:g} ms")
        ask.turn("SI06", True)
        ask.needs(_start(ask) is not None, "the program did not start again")
        ask.command("MotorPowerOff")
        stopped = not ask.on("SO13")
        text = f"SO(13) is {'OFF' if stopped else 'ON'} after the motor power went OFF"
        ask.knob("motor_power_stops_program", stopped, text=text)
    finally:
        ask.turn("SI06", False)
        _servos_off(ask)


def _start(ask: Asker) -> int | None:
    ask.turn("SI12", True)
    us = ask.until(lambda: ask.on("SO13"), 2 * _LATE_US)
    ask.turn("SI12", False)
    return us


@moving(
    {"manual-mode": ("manual_mode_stops_program",)},
    does="SI(12) starts YOUR robot program, with the servos ON.",
    person="select MANUAL mode while the program runs, and AUTO mode again",
)
def program_in_manual_mode(ask: Asker) -> None:
    """Does a change to MANUAL mode stop a program?"""
    _servos_on(ask)
    try:
        ask.needs(_start(ask) is not None, "the program did not start")
        ask.person("Select MANUAL mode.", "manual_mode")
        stopped = not ask.on("SO13")
    finally:
        ask.turn("SI06", False)
        _servos_off(ask)
        ask.person("Select AUTO mode again.", "auto_mode")
    text = f"SO(13) is {'OFF' if stopped else 'ON'} in MANUAL mode"
    ask.knob("manual_mode_stops_program", stopped, text=text)


@moving(
    {
        "sequence-program": ("sequence_program", "emergency_stops_sequence"),
        "answers": ("sequence_delay",),
    },
    does="SI(10) starts YOUR sequence program; the servos stay OFF.",
)
def sequence(ask: Asker) -> None:
    """Is there a sequence program, and does an emergency stop end it?"""
    reset(ask)
    ask.turn("SI10", True)
    us = ask.until(lambda: ask.on("SO12"), 2 * _LATE_US)
    there = us is not None
    text = f"SO(12) {'turned ON' if there else 'stayed OFF'} with SI(10)"
    ask.knob("sequence_program", there, text=text)
    ask.needs(there, "there is no sequence program")
    ask.delay("sequence_delay", us or 0, f"SO(12) ON after {(us or 0) / 1000:g} ms")
    ask.turn("SI00", False)
    ask.wait(_LATE_US)
    ended = not ask.on("SO12")
    ask.turn("SI10", False)
    text = f"SO(12) is {'OFF' if ended else 'ON'} in the emergency stop"
    ask.knob("emergency_stops_sequence", ended, text=text)
