"""The conditions of a controller: link, emergency stop, alarm, power, mode, stop, servos, origin.

Each function returns the chain to the condition that is not met now, or None.
"""

from __future__ import annotations

from typing import NamedTuple

from rcx_harness.look.why.causes import Step
from rcx_harness.look.why.facts import Change, Moment

__all__ = [
    "SHORT_US",
    "Found",
    "emergency",
    "no_alarm",
    "no_link",
    "no_mode",
    "no_origin",
    "no_power",
    "no_servos",
    "no_stop",
    "not_ready",
    "of_moment",
    "reference",
]

#: A signal or a status that has changed in this time may still be answered [us].
SHORT_US = 1_000_000
#: Events in this time belong together [us].
_NEAR_US = 300_000


class Found(NamedTuple):
    """A chain: its steps, the key of the last link, and an ErrorID if the key is `error`."""

    steps: tuple[Step, ...]
    cause: str
    error: int = 0
    controller: int = 1

    def after(self, *steps: Step) -> Found:
        """Return the chain behind further steps."""
        return self._replace(steps=steps + self.steps)

    @property
    def since_us(self) -> int | None:
        """Return the time of the last step."""
        return self.steps[-1].since_us if self.steps else None


def of_moment(moment: Moment, cause: str, *steps: Step) -> Found:
    """Return a chain whose steps belong to the controller of a moment."""
    return Found(
        tuple(step._replace(controller=moment.controller) for step in steps),
        cause,
        controller=moment.controller,
    )


def _signal(moment: Moment, name: str, text: str, section: str) -> Step:
    return Step(text, name, moment.own_since(name), section)


def reference(moment: Moment) -> str:
    """Return the path of the controller's RCX_REF; empty if it is not known.

    If there are several, they belong to the controllers in the order of their names.
    """
    paths = {path[: -len(".StopOk")] for path, _ in moment.ends("StopOk")}
    found = sorted(path for path in paths if moment.value(f"{path}.Connected") is not None)
    if len(found) == max(len(moment.facts.controllers), 1):
        return found[moment.controller - 1]
    return ""


def not_ready(moment: Moment) -> Found | None:
    """Return the first condition without which nothing works."""
    for look in (_plc, no_link, _connected, _not_received, _cpu, emergency, no_alarm, no_power):
        if found := look(moment):
            return found
    return None


def _plc(moment: Moment) -> Found | None:
    if moment.value("0:plc") is not False:
        return None
    step = Step("the PLC makes no scans", "scan", moment.since("0:plc"), "ch. 1, 5")
    return of_moment(moment, "plc-stopped", step)


def no_link(moment: Moment) -> Found | None:
    """Return the chain to a missing connection, or to a controller without power."""
    if moment.own("link") is not False:
        return None
    if moment.own("SO(01)") is False and len(moment.own_changes("link")) != 1:
        text = "SO(01) is OFF and there is no connection: the controller has no power"
        return of_moment(moment, "controller-off", _signal(moment, "SO(01)", text, "ch. 5, 2"))
    since = moment.own_since("link")
    step = Step("the controller receives nothing from the PLC", "link", since, "ch. 1, 5.2")
    return of_moment(moment, "link", step)


def _connected(moment: Moment) -> Found | None:
    path = reference(moment)
    key = f"{path}.Connected"
    if not path or moment.value(key) is not False or moment.own("link") is False:
        return None
    since = moment.since(key)
    exchanged = "the cyclic exchange runs, but " if moment.own("link") else ""
    text = f"{exchanged}{key} is FALSE: the pin Connected of FB_ReadArea, or its area, is wrong"
    if moment.own("link") is None:
        text = f"{key} is FALSE: there is no link, or the pin Connected is not wired"
        return of_moment(moment, "link", Step(text, key, since, "ch. 1, 5.2"))
    return of_moment(moment, "connected-pin", Step(text, key, since, "scan-model.md"))


def _not_received(moment: Moment) -> Found | None:
    for name in ("SI(00)", "SI(06)"):
        sent, got = moment.own(name), moment.own(f"got {name}")
        since = moment.own_since(name)
        if not sent or got is not False or since is None or moment.t_us is None:
            continue
        if moment.t_us - max(since, moment.own_since(f"got {name}") or 0) > SHORT_US:
            text = f"the PLC writes {name} ON, but the controller receives it OFF"
            return of_moment(moment, "not-received", _signal(moment, name, text, "ch. 5, 4"))
    return None


def _cpu(moment: Moment) -> Found | None:
    if moment.own("SO(01)") is not False:
        return None
    text = "SO(01) CPU_OK is OFF: the controller is not in its normal state"
    return of_moment(moment, "cpu", _signal(moment, "SO(01)", text, "ch. 5, 2"))


def emergency(moment: Moment) -> Found | None:
    """Return the chain to the emergency stop that is active."""
    if moment.own("SO(00)") is not True:
        return None
    text = "the controller is in emergency stop, SO(00) is ON"
    shown = _signal(moment, "SO(00)", text, "ch. 5, 2")
    sent = moment.own("SI(00)")
    if sent is None:
        return of_moment(moment, "unknown", shown)
    if sent:
        text = "SI(00) is ON, so another emergency stop is active: SAFETY connector or box"
        found = of_moment(
            moment, "emergency-stop-robot", _signal(moment, "SI(00)", text, "ch. 5, 3.1")
        )
        return found.after(shown._replace(controller=moment.controller))
    text = "the PLC holds SI(00) OFF" + _pin(moment, "EmergencyStopOk", "FB_EmergencyStop")
    found = of_moment(moment, "emergency-stop-input", _signal(moment, "SI(00)", text, "ch. 5, 3.1"))
    return found.after(shown._replace(controller=moment.controller))


def _pin(moment: Moment, pin: str, block: str) -> str:
    """Return the end of a sentence: which pin or block holds an input OFF."""
    path = reference(moment)
    value = moment.value(f"{path}.{pin}") if path else None
    if value is False:
        return f": {pin} of FB_WriteArea is FALSE, or {block} holds it"
    if value is True:
        return f", although {path}.{pin} is TRUE"
    return f": {pin} is FALSE, {block} holds it, or Connected is FALSE (not recorded)"


def no_alarm(moment: Moment) -> Found | None:
    """Return the chain to the alarm that is active, with what happened when it came."""
    if moment.own("SO(03)") is not True or moment.own("SO(00)") is True:
        return None
    text = f"the controller has an alarm, SO(03) is ON{_origin_of_alarm(moment)}"
    return of_moment(moment, "alarm", _signal(moment, "SO(03)", text, "ch. 5, 2"))


def _origin_of_alarm(moment: Moment) -> str:
    since = moment.own_since("SO(03)")
    if since is None:
        return ""
    if _near(moment.own_changes("link"), since, value=False):
        return "; it came with the loss of the link (12.551, 12.552)"
    if _near(moment.own_changes("SO(00)"), since, value=True):
        return "; it came with an emergency stop (12.600), which has been released"
    return ""


def _near(changes: list[Change], t_us: int, *, value: bool) -> bool:
    return any(
        change.value is value and change.t_us is not None and abs(change.t_us - t_us) < _NEAR_US
        for change in changes[1:]
    )


def no_power(moment: Moment) -> Found | None:
    """Return the chain to missing main power."""
    if moment.own("SO(04)") is not False:
        return None
    text = "SO(04) MP RDY is OFF: the motors have no main power"
    return of_moment(moment, "main-power", _signal(moment, "SO(04)", text, "ch. 5, 2"))


def no_mode(moment: Moment) -> Found | None:
    """Return the chain to a mode that is not AUTO."""
    if moment.own("SO(10)") is not False:
        return None
    text = "the controller is not in AUTO mode, SO(10) is OFF"
    return of_moment(moment, "manual-mode", _signal(moment, "SO(10)", text, "ch. 5, 3.2"))


def no_stop(moment: Moment) -> Found | None:
    """Return the chain to a stop input that is held."""
    if moment.own("SI(06)") is not False:
        return None
    text = "the PLC holds the stop input SI(06) OFF" + _pin(moment, "StopOk", "FB_ProgramStop")
    return of_moment(moment, "stop-input", _signal(moment, "SI(06)", text, "ch. 5, 3.3"))


def no_servos(moment: Moment) -> Found | None:
    """Return the chain to servos that are off."""
    if moment.own("SO(02)") is not False:
        return None
    text = "the servos are off, SO(02) is OFF"
    return of_moment(moment, "servos-off", _signal(moment, "SO(02)", text, "ch. 5, 3.1"))


def no_origin(moment: Moment) -> Found | None:
    """Return the chain to a missing return-to-origin."""
    if moment.own("SO(11)") is not False:
        return None
    text = "the return-to-origin is not complete, SO(11) is OFF"
    return of_moment(moment, "origin", _signal(moment, "SO(11)", text, "ch. 5, 2"))
