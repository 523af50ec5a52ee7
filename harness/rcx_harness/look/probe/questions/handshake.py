"""Remote commands with deliberate handshake errors; they move nothing."""

from __future__ import annotations

from rcx_harness.look.probe.asker import Asker, telegram
from rcx_harness.look.probe.question import still
from rcx_harness.look.probe.questions.signals import reset
from rcx_harness.spec.wire import ENDS, READY, RUN

_LATE_US = 500_000
_NO_COMMAND = (0x0F00, *(0,) * 15)


@still({"other-alarms": ("undefined_code_alarm",)}, does="The code 0x0F00 is sent.")
def undefined_code(ask: Asker) -> None:
    """How does the controller answer a code that is not in the manual?"""
    answer = ask.telegram(_NO_COMMAND)
    ask.needs(bool(answer.alarm), "0x0F00 did not end in an alarm")
    ask.knob("undefined_code_alarm", answer.alarm, text=f"0x0F00 ended in {answer.alarm}")


@still(
    {
        "changed-command": ("changed_command_status",),
        "early-command": ("early_command_waits",),
    },
    does="The code of a running reference is replaced by the code of another reference.",
)
def changed_command(ask: Asker) -> None:
    """What happens to a command that changes before its end, and to a code set too early?"""
    ask.send(telegram("ReadVersion"))
    ask.until(lambda: ask.status != READY)
    ask.needs(ask.status == RUN, "the reference had ended before it could be changed")
    ask.send(telegram("ReadPositionMm", 1))
    ask.wait(ask.line.step_us)
    status = ask.status
    executed = ask.until(lambda: ask.status in ENDS, _LATE_US) is not None
    ask.send((0,) * 16)
    ask.needs(status in (RUN, READY), f"the status was 0x{status:04X} after the change")
    kind = "run" if status == RUN else "ready"
    ask.knob("changed_command_status", kind, text=f"0x{status:04X} after the change")
    text = f"the second code {'was executed' if executed else 'got no status'}"
    ask.knob("early_command_waits", executed, text=text)


@still(
    {"changed-data": ("data_belong_to_command",)},
    does="A word that a reference does not use changes while it runs.",
)
def changed_data(ask: Asker) -> None:
    """Do data belong to the command while it runs?"""
    words = telegram("ReadVersion")
    ask.send(words)
    ask.until(lambda: ask.status != READY)
    ask.needs(ask.status == RUN, "the reference had ended before it could be changed")
    ask.send((*words[:15], 7))
    ended = ask.until(lambda: ask.status in ENDS, _LATE_US) is not None
    ask.send((0,) * 16)
    text = f"the end status {'followed' if ended else 'did not follow'} after n+30 was changed"
    ask.knob("data_belong_to_command", not ended, text=text)


@still(
    {"other-alarms": ("servo_off_alarm",)},
    does="SI(00) and SI(06) go ON; inching of axis 1 is requested with the servos off.",
)
def servo_off(ask: Asker) -> None:
    """In which alarm does a movement end if the servos are off?"""
    reset(ask)
    ask.turn("SI06", True)
    ask.needs(not ask.on("SO02"), "SO(02) is ON")
    answer = ask.command("InchPulses", 1, axes=1)
    ask.needs(bool(answer.alarm), "the inching did not end in an alarm")
    ask.knob("servo_off_alarm", answer.alarm, text=f"the inching ended in {answer.alarm}")


@still(
    {"jog-refused": ()},
    does="SI(00) is ON, SI(06) OFF; a jog of axis 1 is requested with the servos off.",
)
def jog_refused(ask: Asker) -> None:
    """Does a jog in the stop status end with 12.400 without a position?"""
    reset(ask)
    ask.needs(not ask.on("SO02"), "SO(02) is ON")
    answer = ask.command("JogPulses", 1, axes=1, position_pulses=1)
    text = f"alarm {answer.alarm or 'none'}, words {answer.words[3:]}"
    ask.rule("jog-refused", answer.alarm == "12.400" and not any(answer.words[3:]), text)
