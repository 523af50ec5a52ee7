"""Questions about dedicated inputs. The servos stay off."""

from __future__ import annotations

from rcx_harness.look.probe.asker import Asker, telegram
from rcx_harness.look.probe.question import still
from rcx_harness.spec.wire import NORMAL_END

_SOON_US, _LATE_US = 60_000, 500_000


def _alarmed(ask: Asker) -> None:
    """Switch SI(00) ON, and leave the alarm of the emergency stop active."""
    ask.turn("SI00", True)
    ask.needs(ask.until(lambda: not ask.on("SO00")) is not None, "SO(00) did not turn OFF")
    ask.turn("SI00", False)
    ask.needs(ask.until(lambda: ask.on("SO03")) is not None, "SO(03) did not turn ON")
    ask.turn("SI00", True)
    ask.until(lambda: not ask.on("SO00"))


def reset(ask: Asker) -> None:
    """Switch SI(00) ON and reset the alarms."""
    ask.turn("SI00", True)
    ask.until(lambda: not ask.on("SO00"))
    ask.pulse("SI16")
    ask.needs(not ask.on("SO03"), "an alarm remains after an alarm reset")


@still(
    {
        "answers": ("emergency_stop_delay", "emergency_release_delay", "alarm_reset_delay"),
        "reset-after-release": ("reset_in_emergency_stop",),
    },
    does="SI(00) goes ON and OFF, SI(16) resets alarms.",
)
def emergency_stop(ask: Asker) -> None:
    """How long do emergency stop, release and reset take; does a reset work in a stop?"""
    reset(ask)
    ask.turn("SI00", False)
    us = ask.until(lambda: ask.on("SO00"))
    ask.needs(us is not None, "SO(00) did not turn ON")
    ask.delay("emergency_stop_delay", us or 0, f"SO(00) ON after {(us or 0) / 1000:g} ms")
    ask.until(lambda: ask.on("SO03"))
    ask.pulse("SI16")
    early = not ask.on("SO03")
    text = f"SO(03) is {'OFF' if early else 'ON'} after SI(16) during the stop"
    ask.knob("reset_in_emergency_stop", early, text=text)
    ask.turn("SI00", True)
    us = ask.until(lambda: not ask.on("SO00"))
    ask.needs(us is not None, "SO(00) did not turn OFF")
    ask.delay("emergency_release_delay", us or 0, f"SO(00) OFF after {(us or 0) / 1000:g} ms")
    ask.needs(ask.on("SO03"), "there is no alarm to reset")
    ask.turn("SI16", True)
    us = ask.until(lambda: not ask.on("SO03"))
    ask.turn("SI16", False)
    ask.needs(us is not None, "SO(03) did not turn OFF")
    ask.delay("alarm_reset_delay", us or 0, f"SO(03) OFF after {(us or 0) / 1000:g} ms")


@still(
    {"interval-strict": ("min_interval",)},
    does="SI(06) goes ON, and 60 ms later SI(16), an alarm reset.",
)
def interval(ask: Asker) -> None:
    """Is a change within 100 ms of the last one recognised?"""
    _alarmed(ask)
    ask.turn("SI06", True)
    ask.turn("SI16", True, after_us=_SOON_US)
    early = ask.until(lambda: not ask.on("SO03"), _LATE_US) is not None
    ask.turn("SI16", False)
    if early:
        ask.between("min_interval", -1, 60, "SI(16) 60 ms after SI(06) reset the alarm")
        return
    ask.turn("SI16", True)
    again = ask.until(lambda: not ask.on("SO03"), _LATE_US) is not None
    ask.turn("SI16", False)
    ask.needs(again, "the alarm is not reset 130 ms after a change either")
    text = "SI(16) did not reset the alarm 60 ms after SI(06), but 130 ms after another change"
    ask.between("min_interval", 60, 130, text)


@still(
    {"interval-levels": ("late_levels",)},
    does="SI(06) goes ON, and 60 ms later SI(00), which may release the emergency stop.",
)
def late_level(ask: Asker) -> None:
    """Is the level of an input that has changed too early recognised later?"""
    ask.turn("SI06", True)
    ask.turn("SI00", True, after_us=_SOON_US)
    us = ask.until(lambda: not ask.on("SO00"), _LATE_US)
    if us is not None:
        ask.needs(us > ask.line.tolerance_us + 25_000, "60 ms after another change is early enough")
    text = "SO(00) stays ON" if us is None else f"SO(00) OFF {us / 1000:g} ms after SI(00)"
    ask.knob("late_levels", us is not None, text=text)


@still({"interval-stops": ()}, does="SI(16) goes ON, and 60 ms later SI(00) goes OFF.")
def stop_at_once(ask: Asker) -> None:
    """Is a switch-off of SI(00) accepted at once, also directly after another change?"""
    reset(ask)
    ask.turn("SI16", True)
    ask.turn("SI00", False, after_us=_SOON_US)
    us = ask.until(lambda: ask.on("SO00"), _LATE_US)
    text = "SO(00) did not turn ON" if us is None else f"SO(00) ON after {us / 1000:g} ms"
    ask.rule("interval-stops", us is not None and us < _SOON_US, text)


@still(
    {"link-first-image": ("recovery_edges",)},
    does="The connection is cut and opened again with SI(16) ON.",
)
def first_image(ask: Asker) -> None:
    """Is an input that is ON in the first image of a connection an edge?"""
    _alarmed(ask)
    ask.drop(2_000_000)
    ask.open("SI00", "SI16")
    ask.needs(ask.until(lambda: not ask.on("SO00")) is not None, "SO(00) did not turn OFF")
    edge = not ask.on("SO03")
    text = f"SO(03) is {'OFF' if edge else 'ON'} with SI(16) in the first packet"
    ask.knob("recovery_edges", edge, text=text)


@still(
    {"link-loss-alarm": ("link_loss_alarm",)},
    does="SI(00) goes ON, then the connection is cut and opened again.",
)
def link_loss(ask: Asker) -> None:
    """Which alarm does a loss of the connection raise?"""
    reset(ask)
    before = ask.history()
    ask.drop(2_000_000)
    ask.open()
    new = ask.history().new_since(before) - {"12.600"}
    ask.needs(len(new) == 1, f"new messages: {', '.join(sorted(new)) or 'none but 12.600'}")
    ask.knob("link_loss_alarm", *new, text=f"the new message is {', '.join(new)}")


@still(
    {"idle-header": ("idle_header",)},
    does="SI(00) goes ON, then packets have the idle header for half a second.",
)
def idle_header(ask: Asker) -> None:
    """Does the controller treat the idle header as a loss of its master?"""
    reset(ask)
    ask.idle(True)
    lost = ask.until(lambda: ask.on("SO00"), _LATE_US) is not None
    ask.idle(False)
    text = f"SO(00) {'turned ON' if lost else 'stayed OFF'} with the idle header"
    ask.knob("idle_header", "loss" if lost else "hold", text=text)


@still(
    {"minor-alarms": ("minor_alarms",)},
    does="SI(12) goes ON while SI(06) is OFF: nothing can start, 12.400 is raised.",
)
def minor_alarms(ask: Asker) -> None:
    """Is 12.400 an alarm that has to be reset?"""
    reset(ask)
    before = ask.history()
    ask.pulse("SI12")
    serious = ask.on("SO03")
    new = ask.history().new_since(before)
    ask.needs("12.400" in new, "12.400 was not raised")
    text = f"SO(03) is {'ON' if serious else 'OFF'} after 12.400"
    ask.knob("minor_alarms", () if serious else ("12.400",), text=text)


@still(
    {"command-alarms": ("command_alarm_is_serious",)},
    does="SI(00) goes ON, alarms are reset, a reference with a wrong number is sent.",
)
def command_alarms(ask: Asker) -> None:
    """Does an alarm that ends a command turn SO(03) ON?"""
    reset(ask)
    answer = ask.command("ReadMessage", message=0)
    ask.needs(bool(answer.alarm), "the wrong number was accepted")
    serious = ask.on("SO03")
    text = f"SO(03) is {'ON' if serious else 'OFF'} after alarm {answer.alarm}"
    ask.knob("command_alarm_is_serious", serious, text=text)


@still({"reset-command": ()}, does="SI(00) goes ON and OFF; 0x0604 is sent in the emergency stop.")
def reset_command(ask: Asker) -> None:
    """Does the alarm reset command return the number of a remaining alarm?"""
    reset(ask)
    ask.turn("SI00", False)
    ask.until(lambda: ask.on("SO03"))
    answer = ask.command("AlarmReset")
    ask.needs(ask.on("SO03"), "the alarm was reset in the emergency stop")
    text = f"0x0604 ended {'in ' + answer.alarm if answer.alarm else 'normally'}"
    ask.rule("reset-command", answer.alarm == "12.600", text)


@still(
    {"messages": ("newest_message_first",)},
    does="SI(00) goes ON and OFF, a reference has a wrong number: two alarms follow.",
)
def message_order(ask: Asker) -> None:
    """Is message 1 the newest?"""
    reset(ask)
    before, latest = ask.history(), ""
    for _ in range(2):
        ask.turn("SI00", False)
        ask.until(lambda: ask.on("SO03"))
        ask.turn("SI00", True)
        ask.until(lambda: not ask.on("SO00"))
        ask.pulse("SI16")
        latest = ask.command("ReadMessage", message=0).alarm
    first = ask.history().newest_first(before, latest)
    ask.needs(first is not None, "the messages do not show their order")
    ask.knob("newest_message_first", first, text="position of two new alarms in the history")


@still(
    {"outputs-kept": ("reset_clears_outputs",), "answers": ("program_reset_delay",)},
    does="SO(20) is set ON, then SI(15) resets the robot programs: they begin at line 1.",
)
def program_reset(ask: Asker) -> None:
    """Does an output stay ON at a program reset, and how long does that take?"""
    reset(ask)
    ask.needs(ask.on("SO10") and not ask.on("SO13"), "not in AUTO mode, or a program runs")
    before = ask.byte(34)
    answer = ask.telegram(telegram("WriteIoPort", port_type=6, port=2, pattern=before | 1))
    ask.needs(answer.status == NORMAL_END and ask.byte(34) & 1 == 1, "SO(20) cannot be set")
    was = ask.on("SO14")
    ask.turn("SI15", True)
    us = ask.until(lambda: ask.on("SO14"))
    ask.wait(_LATE_US)
    ask.turn("SI15", False)
    kept = bool(ask.byte(34) & 1)
    ask.telegram(telegram("WriteIoPort", port_type=6, port=2, pattern=before))
    if not was and us is not None:
        ask.delay("program_reset_delay", us, f"SO(14) ON after {us / 1000:g} ms")
    ask.needs(us is not None, "SO(14) did not turn ON")
    text = f"SO(20) is {'ON' if kept else 'OFF'} after the reset"
    ask.knob("reset_clears_outputs", not kept, text=text)


@still(
    {"warning-reset": ("reset_clears_warning",)},
    does="SI(16) goes ON; asked only while SO(15) is ON.",
)
def warning(ask: Asker) -> None:
    """Does an alarm reset clear a warning?"""
    ask.needs(ask.on("SO15"), "there is no warning")
    reset(ask)
    kept = ask.on("SO15")
    text = f"SO(15) is {'ON' if kept else 'OFF'} after SI(16)"
    ask.knob("reset_clears_warning", not kept, text=text)
