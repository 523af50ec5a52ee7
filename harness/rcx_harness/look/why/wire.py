"""What the areas alone show: a remote command, a dedicated input without answer, an alarm."""

from __future__ import annotations

from collections.abc import Callable

from rcx_harness.look.why.causes import OF_ALARM, Step, alarm_name
from rcx_harness.look.why.conditions import (
    SHORT_US,
    Found,
    emergency,
    no_alarm,
    no_link,
    no_mode,
    no_origin,
    no_power,
    no_servos,
    no_stop,
    not_ready,
    of_moment,
)
from rcx_harness.look.why.facts import Change, Moment
from rcx_harness.spec import command_name, signals
from rcx_harness.spec.wire import ABNORMAL_END, ENDS, READY, RUN
from structured_text.output.units import format_word

__all__ = ["abnormal_end", "last_request", "of_alarm", "request", "running_command"]

_Look = Callable[[Moment], Found | None]
#: The answer to each dedicated input, and the conditions of its action (chapter 5, 2 and 3).
_REQUESTS: dict[str, tuple[str, tuple[_Look, ...]]] = {
    "SI(01)": ("SO(02)", ()),
    "SI(12)": ("SO(13)", (no_mode, no_stop)),
    "SI(14)": ("SO(11)", (no_stop, no_servos)),
    "SI(15)": ("SO(14)", (no_mode,)),
    "SI(17)": ("SO(11)", (no_stop, no_servos)),
}
#: Inputs without further conditions: if they have no effect, the box or a safety setting has it.
_SURE = ("SI(01)", "SI(15)")
#: Time after an edge of an input in which an answer can come [us].
_NEAR_US = 200_000
_CONDITIONS: dict[str, tuple[_Look, ...]] = {
    "manual-mode": (no_mode,),
    "main-power": (no_power, no_servos),
    "servos-off": (no_servos,),
    "origin": (no_origin,),
    "link": (no_link, not_ready),
    "emergency": (emergency, no_alarm),
}


def running_command(moment: Moment) -> Found | None:
    """Return the chain of the remote command that is out, or of a status that stays."""
    code, status = moment.own("code"), moment.own("status")
    if status is None or (code is None and status != RUN):
        return None
    if code is None:
        text = f"a remote command is out, the status is {format_word(status)}"
        return of_moment(moment, "executes", Step(text, "status", moment.own_since("status")))
    since = moment.own_since("code")
    name = command_name(code)
    shown = f"the status is {format_word(status)}"
    if code == 0:
        if status == 0 or _is_young(moment, "status"):
            return None
        text = f"no command is out, but {shown}"
        step = Step(text, "status", moment.own_since("status"), "guide, 1.2", moment.controller)
        return of_moment(moment, "never-ready", step)
    step = Step(f"{name} is out, {shown}", "code", since, "guide, 1.1", moment.controller)
    if status in ENDS and not _is_young(moment, "status"):
        return of_moment(moment, "no-reset", step)
    if status == 0 and not _is_young(moment, "code"):
        return of_moment(moment, "unknown", step)
    return of_moment(moment, "executes", step)


def request(moment: Moment, *, now: bool = True) -> Found | None:
    """Return the chain of a dedicated input that is ON and has no answer.

    Args:
        moment: The time, at which the input is ON.
        now: Whether this time is the present. If not, an answer could not come any more.
    """
    for name, (answer, needs) in _REQUESTS.items():
        if moment.own(name) is not True or moment.own(answer) is not False:
            continue
        title = signals().find(name).title
        since = moment.own_since(name)
        text = f"{name} {title} is ON, and {answer} does not answer"
        step = Step(text, name, since, "ch. 5, 3", moment.controller)
        for need in needs:
            if found := need(moment):
                return found.after(step)
        if moment.t_us is not None and since is not None:
            if rule := _broken(moment, name, since):
                return of_moment(moment, "interval", step, rule)
            if now and moment.t_us - since < SHORT_US:
                return of_moment(moment, "executes", step)
        if name not in _SURE:
            return of_moment(moment, "unknown", step)
        text = f"all conditions of {name} that the signals show are met"
        return of_moment(moment, "no-authority", step, Step(text, answer, since, "ch. 5, 3"))
    return None


def last_request(moment: Moment) -> Found | None:
    """Return the chain of the last dedicated input that was withdrawn without an answer."""
    last: tuple[int, Found] | None = None
    for name, (answer, _) in _REQUESTS.items():
        end = _withdrawn(moment, name)
        if end is None or (last and end <= last[0]):
            continue
        before = moment.earlier(end - 1)
        if moment.own(answer) is False and (found := request(before, now=False)):
            last = end, found
    return last[1] if last else None


def _withdrawn(moment: Moment, name: str) -> int | None:
    changes = moment.own_changes(name)
    if len(changes) > 1 and changes[-1].value is False and changes[-2].value is True:
        return changes[-1].t_us
    return None


def abnormal_end(moment: Moment, until_us: int | None = None) -> Found | None:
    """Return the chain of the last remote command if it has ended with an alarm.

    Args:
        moment: The time whose signals count.
        until_us: The command has ended up to this time; None for the time of the moment.
    """
    at = moment if until_us is None else moment.earlier(until_us)
    for change in reversed(at.own_changes("answer")):
        if change.value[0] != READY:
            return _ended(moment, change) if change.value[0] == ABNORMAL_END else None
    return None


def _ended(moment: Moment, change: Change) -> Found:
    _, group, category = change.value
    at = moment if change.t_us is None else moment.earlier(change.t_us)
    code = at.own("code")
    if not code and change.t_us is not None:  # the PLC may have answered at the same time
        code = moment.earlier(change.t_us - 1).own("code")
    alarm = f"{group}.{category}"
    name = alarm_name(alarm)
    text = f"{command_name(code) if code else 'the command'} ended with alarm {alarm}"
    text += f" {name}" if name else ""
    step = Step(text, "status", change.t_us, "guide, 1.2", moment.controller)
    return of_alarm(moment, alarm, change.t_us).after(step)


def of_alarm(moment: Moment, alarm: str, t_us: int | None) -> Found:
    """Return the chain of an alarm that has ended a command at a time."""
    condition = OF_ALARM.get(alarm)
    if condition is None:
        return of_moment(moment, "command-alarm")
    if condition == "no-authority":
        return of_moment(moment, "no-authority")
    if condition == "stop-input":
        return _stopped(moment, t_us)
    for look in (not_ready, *_CONDITIONS[condition]):
        if found := look(moment):
            return found
    return of_moment(moment, "acknowledge")


def _stopped(moment: Moment, t_us: int | None) -> Found:
    if found := not_ready(moment) or no_stop(moment):
        return found
    since = moment.own_since("SI(06)")
    if t_us is None or since is None or since < t_us - _NEAR_US:
        text = "SI(06) is ON, so the stop input of the parallel I/O board (DI06) is OFF"
        step = Step(text, "SI(06)", since, "ch. 1, 5.1", moment.controller)
        return of_moment(moment, "parallel-stop", step)
    return of_moment(moment, "acknowledge")


def _broken(moment: Moment, name: str, since: int) -> Step | None:
    for t_us, text in moment.facts.broken:
        if "interval" in text and name in text and abs(t_us - since) < _NEAR_US:
            return Step(f"broken rule: {text}", name, t_us, "ch. 5, 3")
    return None


def _is_young(moment: Moment, name: str) -> bool:
    since = moment.own_since(name)
    return moment.t_us is not None and since is not None and moment.t_us - since < SHORT_US
