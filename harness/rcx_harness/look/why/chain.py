"""The chain of causes at a time: from what waits to who has to act."""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.look.why.blocks import Latched, busy_block, latched_error, of_error
from rcx_harness.look.why.causes import CAUSES, Cause, Step, error_entry
from rcx_harness.look.why.conditions import Found, no_mode, no_stop, not_ready, of_moment
from rcx_harness.look.why.facts import Facts, Moment
from rcx_harness.look.why.tasks import program_wait
from rcx_harness.look.why.wire import abnormal_end, last_request, request, running_command

__all__ = ["Chain", "chains"]

#: Mistakes in the program: they are the cause even if a controller was not ready later.
_PROGRAM = ("not-called", "called-twice", "out-of-place", "error", "command-alarm")


@dataclass(frozen=True)
class Chain:
    """A chain of one controller.

    Attributes:
        controller: Number of the controller at which something waits.
        steps: The links, from what waits to the last signal.
        cause: The last link.
        error: The ErrorID of the last link, if it is an error of the program.
    """

    controller: int
    steps: tuple[Step, ...]
    cause: Cause
    error: int = 0

    @property
    def to_go_on(self) -> str:
        """Return what to do."""
        return str(error_entry(self.error)["remedy"]) if self.error else self.cause.to_go_on


def chains(facts: Facts, t_us: int | None) -> list[Chain]:
    """Return the chain of each controller; chains with something that waits come first."""
    found = []
    for number in sorted(facts.controllers) or [1]:
        link = _explain(Moment(facts, t_us, number))
        cause = CAUSES[link.cause]
        found.append(Chain(number, link.steps, cause, link.error))
    return sorted(found, key=lambda chain: not chain.cause.stands)


def _explain(moment: Moment) -> Found:
    error = latched_error(moment)
    hard = not_ready(moment)
    if error is not None:
        found = of_error(moment, error)
        if hard is None or (found.cause in _PROGRAM and _before(error, hard)):
            return found
        return hard if hard.steps == found.steps else hard.after(*error.steps(moment.controller))
    waits = busy_block(moment)
    if waits is not None:
        return waits
    if hard is not None:
        return hard
    return _without_blocks(moment)


def _before(error: Latched, hard: Found) -> bool:
    since = hard.since_us
    return error.since_us is not None and since is not None and error.since_us <= since


def _without_blocks(moment: Moment) -> Found:
    """Return the chain from the areas and the robot program alone."""
    for look in (request, running_command, abnormal_end, last_request, no_stop, program_wait):
        if found := look(moment):
            return found
    mode = no_mode(moment)
    if mode is not None:
        changed = len(moment.own_changes("SO(10)")) > 1
        return mode if changed else mode._replace(cause="unknown")
    if moment.own("status") is None and moment.own("code") is None:
        return of_moment(moment, "unknown")
    since = moment.own_since("code")
    step = Step("no command is out and no dedicated input is requested", "code", since)
    recorded = any(True for _ in moment.ends("Busy", "ErrorID"))
    return of_moment(moment, "not-requested" if recorded else "not-recorded", step)
