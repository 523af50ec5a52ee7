"""What watched variables of the program show: errors, busy blocks, turns, shared areas."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rcx_harness.look.why.causes import OF_ERROR, Step, error_entry
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
    reference,
)
from rcx_harness.look.why.facts import Moment
from rcx_harness.look.why.tasks import program_wait
from rcx_harness.look.why.wire import abnormal_end, last_request, request, running_command
from rcx_harness.spec import command_name
from structured_text.output.units import format_word

__all__ = ["Latched", "busy_block", "latched_error", "of_error"]

#: Last names of variables that contain an ErrorID.
_NAMES = ("error", "fault")
#: Members of an RCX_REF and of blocks of this library that are not for users.
_INNER = ".Inner."
_LOOKS = {
    "link": (no_link,),
    "cpu": (),
    "emergency": (emergency,),
    "alarm": (no_alarm,),
    "main-power": (no_power,),
    "manual-mode": (no_mode,),
    "stop-input": (no_stop,),
    "servos-off": (no_servos,),
    "origin": (no_origin,),
}
#: Conditions that are the last link, whatever the signals show now.
_OWN = ("not-called", "called-twice", "out-of-place", "orphan", "never-ready")


@dataclass(frozen=True)
class Latched:
    """A variable with an ErrorID, and the block that has reported it first if it is known."""

    path: str
    value: int
    since_us: int | None
    block: str = ""

    def steps(self, controller: int) -> Iterator[Step]:
        """Yield the steps from the variable to the block."""
        name = error_entry(self.value)["name"]
        shown = f"{format_word(self.value)} {name}"
        if self.block:
            text = f"{self.path} keeps {shown}, the error of {self.block}"
            yield Step(text, self.path, self.since_us, "errors.md", controller)
        else:
            text = f"{self.path} is {shown}"
            yield Step(text, self.path, self.since_us, "errors.md", controller)


def latched_error(moment: Moment) -> Latched | None:
    """Return the earliest ErrorID that the program shows now."""
    found = []
    for path in moment.facts.paths():
        last = path.rpartition(".")[2].lower()
        if not any(name in last for name in _NAMES) or not moment.is_own(path):
            continue
        if _is_inside(moment, path):
            continue
        value = moment.value(path)
        if type(value) is int and error_entry(value)["name"]:
            found.append(Latched(path, value, moment.since(path)))
    if not found:
        return None
    first = min(found, key=lambda error: (error.since_us or 0, -len(error.path)))
    if first.path.endswith(".ErrorID"):
        return first
    return Latched(first.path, first.value, first.since_us, _source(moment, first))


def _source(moment: Moment, error: Latched) -> str:
    """Return the block whose ErrorID came at the same time as a latched error."""
    for path in moment.facts.paths():
        if path.endswith(".ErrorID") and path != error.path:
            for change in moment.until(path):
                if change.value == error.value and change.t_us == error.since_us:
                    return path[: -len(".ErrorID")]
    return ""


def of_error(moment: Moment, error: Latched) -> Found:
    """Return the chain of an error: the condition if it is not met now, or who acknowledges."""
    found = _condition(moment, error)
    return found.after(*error.steps(moment.controller))


def _condition(moment: Moment, error: Latched) -> Found:
    kind = OF_ERROR.get(error.value, "")
    if kind in _OWN:
        return of_moment(moment, kind)
    if kind == "abnormal-end":
        found = abnormal_end(moment, error.since_us)
        return found or of_moment(moment, "error")._replace(error=error.value)
    if kind in _LOOKS:
        for look in (*_LOOKS[kind], not_ready):
            if found := look(moment):
                return found
        return of_moment(moment, "acknowledge")
    if kind in ("request", "servo-request"):
        found = not_ready(moment) or request(moment) or last_request(moment)
        return found or of_moment(moment, "unknown")
    if kind == "program-not-running":
        found = not_ready(moment)
        if found is None and moment.own("SO(13)") is False:
            text = "the robot program is not running, SO(13) is OFF"
            step = Step(text, "SO(13)", moment.own_since("SO(13)"), "ch. 5, 2")
            found = (no_stop(moment) or no_mode(moment)) or of_moment(moment, kind, step)
        return found or of_moment(moment, "acknowledge")
    if kind == "robot-program" and (found := program_wait(moment)):
        return found
    if kind.startswith("area"):
        return _area(moment, error.path.rpartition(".")[0]) or of_moment(moment, kind)
    return of_moment(moment, "error")._replace(error=error.value)


def busy_block(moment: Moment) -> Found | None:
    """Return the chain of the block that waits, or that works; None if none is Busy."""
    busy = sorted(path.rpartition(".")[0] for path, value in moment.ends("Busy") if value is True)
    busy = [path for path in busy if moment.is_own(path) and not _is_inside(moment, path)]
    leaves = [path for path in busy if not any(one.startswith(f"{path}.") for one in busy)]
    waits = [path for path in leaves if moment.value(f"{path}.Active") is False]
    for path in (*waits, *leaves):
        if moment.value(f"{path}.Holds") is not None:
            if found := _area(moment, path):
                return found
        elif path in waits and (found := _turn(moment, path)):
            return found
    for path in leaves:
        since = moment.since(f"{path}.Busy")
        active = moment.value(f"{path}.Active") is True
        text = f"{path} is Busy" + (" and has the turn" if active else "")
        step = Step(text, f"{path}.Busy", since, "guide, 1.1", moment.controller)
        found = not_ready(moment) or request(moment) or running_command(moment)
        found = found or program_wait(moment) or _stands(moment, path)
        if found is None:
            found = of_moment(moment, "executes" if _is_young(moment, since) else "unknown")
        return found.after(step)
    return None


def _is_young(moment: Moment, since: int | None) -> bool:
    return moment.t_us is not None and since is not None and moment.t_us - since < SHORT_US


def _is_inside(moment: Moment, path: str) -> bool:
    """Return whether a variable belongs to the inside of a block of the library."""
    names = path.split(".")
    heads = (".".join(names[:number]) for number in range(2, len(names) + 1))
    kinds = moment.facts.blocks
    return _INNER in f"{path}." or any(kinds.get(head, "").startswith("FB_Rcx") for head in heads)


def _stands(moment: Moment, path: str) -> Found | None:
    """Return the chain of a block that waits for a robot program that does not run."""
    known = moment.facts.blocks.get(path, "").startswith("FB_ProgramCall")
    if moment.own("SO(13)") is not False or not (known or moment.own("tasks")):
        return None
    text = "the robot program is not running, SO(13) is OFF"
    step = Step(text, "SO(13)", moment.own_since("SO(13)"), "ch. 5, 2")
    found = no_stop(moment) or no_mode(moment)
    return found or of_moment(moment, "program-not-running", step)


def _turn(moment: Moment, path: str) -> Found | None:
    """Return the chain of a block that waits for its turn; None if no other block has it."""
    head = reference(moment)
    if not head:
        return None
    since = moment.since(f"{path}.Busy")
    first = Step(f"{path} waits for its turn", f"{path}.Active", since, "guide, 1.1")
    first = first._replace(controller=moment.controller)
    for channel in ("Command", "Sequence"):
        key = f"{head}.Inner.{channel}"
        serving, following = moment.value(f"{key}.Serving"), moment.value(f"{key}.NextTicket")
        holder = moment.value(f"{key}.Holder") or 0
        if not all(type(number) is int for number in (serving, following, holder)):
            continue
        if (following - serving) % 65536 < 2:
            continue
        held = moment.since(f"{key}.Serving")
        name = command_name(holder) if channel == "Command" else f"SI({holder:02X})"
        if moment.value(f"{key}.Orphan") is True:
            text = f"{name} holds the channel, but its block is not called any more"
            step = Step(text, f"{key}.Orphan", moment.since(f"{key}.Orphan"), "guide, 1.1")
            return (not_ready(moment) or of_moment(moment, "orphan", step)).after(first)
        block = _holder(moment, path)
        text = f"{block or name} holds the channel" + (f" ({name})" if block else "")
        step = Step(text, f"{key}.Holder", held, "guide, 1.1", moment.controller)
        found = not_ready(moment) or request(moment) or running_command(moment)
        if found is None or found.cause == "executes":
            held_long = moment.t_us is None or held is None or moment.t_us - held > SHORT_US
            steps = found.steps if found else ()
            cause = "channel-held" if held_long else "executes"
            found = of_moment(moment, cause, *steps)
        return found.after(first, step)
    return None


def _holder(moment: Moment, waiting: str) -> str:
    """Return the block that has the turn: the innermost with Active, if there is only one."""
    paths = [path.rpartition(".")[0] for path, value in moment.ends("Active") if value is True]
    paths = [path for path in paths if not any(one.startswith(f"{path}.") for one in paths)]
    return paths[0] if len(paths) == 1 and paths[0] != waiting else ""


def _area(moment: Moment, path: str) -> Found | None:
    """Return the chain of an interlock that waits for a shared area."""
    step = Step(
        f"{path} waits for the shared area",
        f"{path}.Valid",
        moment.since(f"{path}.Busy"),
        "errors.md",
        moment.controller,
    )
    every = sorted(one.rpartition(".")[0] for one, value in moment.ends("Holds"))
    for number, other in enumerate(every, 1):
        if other == path or moment.value(f"{other}.Holds") is not True:
            continue
        since = moment.since(f"{other}.Holds")
        held = Step(f"{other} holds the area", f"{other}.Holds", since, "errors.md")
        there = moment.of(number) if len(every) == len(moment.facts.controllers) else moment
        held = held._replace(controller=there.controller)
        if there is not moment and (found := not_ready(there)):
            return found.after(step, held)
        cause = "area-kept" if moment.value(f"{other}.Kept") is True else "area-held"
        return of_moment(there, cause).after(step, held)
    return None
