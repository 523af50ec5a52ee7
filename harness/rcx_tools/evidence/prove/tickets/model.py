"""The model of tickets and turns on a channel, with invariants of the channel and of the jobs.

The PLC counts scans, tickets and turns in 16 bits, which wrap. The proof adds ghost counters with
48 bits, which never wrap. The proof is an induction over the calls of any block. Each call keeps
the invariant of the channel, of any job, and of any two jobs. The number of jobs does not occur in
the proof, so the proof holds for any number.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import z3

from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.summaries import SUMMARIES
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Alternatives, Path
from structured_text.prove.values import TIME_BITS

__all__ = [
    "Channel",
    "Clockless",
    "Job",
    "Places",
    "Scene",
    "after_call",
    "after_read",
    "after_write",
    "assumed",
    "jobs",
    "machine",
]

_WIDE = 48
#: Greatest distance of two tickets in use that FC_RcxTickets compares correctly.
FARTHEST = 32767


def low(wide: Any) -> Any:
    """Return a counter as the PLC stores it, modulo 65536."""
    return z3.Extract(15, 0, wide)


def until(first: Any, last: Any) -> Any:
    """Return the number of tickets from `first` to `last`, as a wide number (48 bits)."""
    return z3.ZeroExt(_WIDE - 16, last - first)


@dataclass(frozen=True)
class Channel:
    """A channel at a point in time: the ghost counters, and the variables of the PLC.

    Attributes:
        tickets: Number of tickets taken so far.
        turns: Ticket that has the turn, as a wide number (48 bits).
        scan: Number of the scan, as a wide number.
        inside: FB_ReadArea has been called in this scan, and FB_WriteArea has not been called yet.
        unseen: No block with a ticket was called since the last FB_WriteArea.
        written: The area is legal, so FB_WriteArea works.
        next, serving, lowest, orphan, number: The variables of the PLC.
        remote: Whether this is the channel of the remote commands.
    """

    tickets: Any
    turns: Any
    scan: Any
    inside: Any
    unseen: Any
    written: Any
    next: Any
    serving: Any
    lowest: Any
    orphan: Any
    number: Any
    remote: bool

    def holds(self) -> dict[str, Any]:
        """Return the invariant of the channel between any two calls, by name."""
        waiting = self.tickets - self.turns
        return {
            "the counters of the PLC agree with the ghost counters": z3.And(
                self.next == low(self.tickets),
                self.serving == low(self.turns),
                self.number == low(self.scan),
            ),
            "at most 32767 tickets were taken since the turn": z3.And(
                self.turns >= 1 << 16,
                self.turns <= self.tickets,
                waiting <= FARTHEST,
            ),
            "Lowest is a ticket that was taken, and not before the turn": z3.Implies(
                self.written, z3.ULE(until(self.serving, self.lowest), waiting)
            ),
            "if no block was called, Lowest is NextTicket": z3.And(
                z3.Implies(z3.And(self.written, self.unseen), self.lowest == self.next),
                z3.Implies(z3.Not(self.inside), z3.Or(self.unseen, z3.Not(self.written))),
            ),
            "an orphan holds a turn of the remote commands": z3.Implies(
                self.orphan,
                z3.And(
                    z3.BoolVal(self.remote),
                    self.turns < self.tickets,
                    z3.Implies(self.written, self.lowest != self.serving),
                ),
            ),
        }

    def counted(self) -> Any:
        """Return the claim that the wide counts are within bounds, so that they never overflow."""
        return z3.And(
            self.tickets < 1 << 46,
            self.scan >= 1 << 16,
            self.scan < 1 << 46,
        )


@dataclass(frozen=True)
class Job:
    """A job at a point in time: ghost variables, and variables of the PLC.

    Attributes:
        ticket: The last ticket of the job as a wide number. A job without a ticket has a number
            that was already served.
        waits: The job has taken this ticket and has not ended.
        seen: Number of the scan of the last call, as a wide number. busy, active, mine, last,
            error: The variables Busy, Active, Ticket, Seen and ErrorID.
    """

    ticket: Any
    waits: Any
    seen: Any
    busy: Any
    active: Any
    mine: Any
    last: Any
    error: Any

    def lives(self, channel: Channel) -> Any:
        """Return the claim that the job is busy and was called in every scan.

        In the present scan the call may still be missing.
        """
        early = z3.And(channel.inside, self.seen == channel.scan - 1)
        return z3.And(self.busy, z3.Or(self.seen == channel.scan, early))

    def holds(self, channel: Channel) -> dict[str, Any]:
        """Return the invariant of the job between any two calls, by name."""
        lives = self.lives(channel)
        return {
            "an active job is busy; a busy job has no error": z3.And(
                z3.Implies(self.active, self.busy),
                z3.Implies(self.busy, z3.And(self.error == 0, self.last == low(self.seen))),
                self.seen <= channel.scan,
                self.seen >= 0,
            ),
            "its ticket was taken, and has not been passed": z3.Implies(
                lives,
                z3.And(
                    self.mine == low(self.ticket),
                    self.ticket >= 0,
                    self.ticket < channel.tickets,
                    self.waits == (self.ticket >= channel.turns),
                ),
            ),
            "it is active only in its own turn, without an orphan": z3.And(
                z3.Implies(
                    z3.And(lives, self.active), z3.And(self.waits, self.ticket == channel.turns)
                ),
                z3.Implies(
                    z3.And(lives, self.waits, self.ticket == channel.turns),
                    z3.Not(channel.orphan),
                ),
            ),
            "Lowest is at most its ticket after its call, and differs before": z3.Implies(
                z3.And(lives, self.waits, channel.written, channel.inside),
                z3.And(
                    z3.Implies(
                        self.seen == channel.scan,
                        z3.ULE(until(channel.serving, channel.lowest), self.ticket - channel.turns),
                    ),
                    z3.Implies(self.seen == channel.scan - 1, channel.lowest != self.mine),
                ),
            ),
        }


@dataclass(frozen=True)
class Scene:
    """A channel and its jobs at a point in time."""

    channel: Channel
    jobs: tuple[Job, ...]

    def holds(self) -> dict[str, Any]:
        """Return the invariants of the channel, of each job, and of each pair of jobs, by name."""
        claims = {f"channel: {name}": claim for name, claim in self.channel.holds().items()}
        for number, job in enumerate(self.jobs, 1):
            claims |= {
                f"job {number}: {name}": claim for name, claim in job.holds(self.channel).items()
            }
            for other_number, other in enumerate(self.jobs[: number - 1], 1):
                claims[f"jobs {other_number} and {number}: they have different tickets"] = (
                    different(self.channel, other, job)
                )
        return claims


def different(channel: Channel, one: Job, other: Job) -> Any:
    """Return the claim that two waiting jobs have different tickets, even modulo 65536."""
    both = z3.And(one.lives(channel), one.waits, other.lives(channel), other.waits)
    return z3.Implies(both, z3.And(one.ticket != other.ticket, one.mine != other.mine))


def keeps_turn(busy: Any, active: Any, seen: Any, number: Any, own: Any) -> Any:
    """Return the claim that a job with the turn is served if it was called in the last scan.

    A job is served if its ticket is the present turn.

    Args:
        busy: Busy of the job.
        active: Active of the job.
        seen: Seen of the job, 16 bits.
        number: The number of this scan, 16 bits.
        own: Whether the ticket of the job is the served ticket.
    """
    return z3.Implies(z3.And(busy, active, seen + 1 == number), own)


class Clockless(Machine):
    """A machine that does not run FB_RcxScanTime, so the time since the last scan is arbitrary."""

    def call_block(
        self, instance: Path, block: str, in_outs: Mapping[str, Path | Alternatives]
    ) -> None:
        """Call a block like `Machine.call_block`, but skip FB_RcxScanTime."""
        if block.upper() == "FB_RCXSCANTIME":
            kind = self.project.pous["FB_RCXSCANTIME"].block
            assert kind is not None
            self.havoc(instance, kind)
        else:
            super().call_block(instance, block, in_outs)


def machine(library: Library) -> Machine:
    """Return a machine at any time of operation, for goals that do not depend on time."""
    made = Clockless(library.project, SUMMARIES)
    made.now = z3.BitVec("now", TIME_BITS)
    made.assume(z3.And(made.now >= 0, made.now < 1 << 62))
    return made


@dataclass(frozen=True)
class Places:
    """The paths of a channel and of its jobs in a machine."""

    machine: Machine
    channel: Path
    jobs: tuple[Path, ...]

    def scene(self, channel: Channel, jobs: tuple[Job, ...]) -> Scene:
        """Return the present scene with the given ghost variables."""

        def at(path: Path, *names: str) -> list[Any]:
            return [self.machine.term((*path, name)) for name in names]

        after, serving, lowest, orphan = at(
            self.channel, "NEXTTICKET", "SERVING", "LOWEST", "ORPHAN"
        )
        found = []
        for path, job in zip(self.jobs, jobs, strict=True):
            busy, active, mine, last, error = at(
                path, "BUSY", "ACTIVE", "TICKET", "SEEN", "ERRORID"
            )
            found.append(replace(job, busy=busy, active=active, mine=mine, last=last, error=error))
        return Scene(
            replace(channel, next=after, serving=serving, lowest=lowest, orphan=orphan),
            tuple(found),
        )

    def any(self, remote: bool, number: Any, inside: Any) -> Scene:
        """Return the present scene with arbitrary ghost counters."""
        nothing, no = z3.BitVecVal(0, 16), z3.BoolVal(False)
        wide = {name: z3.BitVec(name, _WIDE) for name in ("tickets", "turns", "scan")}
        logic = {name: z3.Bool(name) for name in ("unseen", "written")}
        plc = dict.fromkeys(("next", "serving", "lowest"), nothing)
        channel = Channel(
            **wide, **logic, **plc, orphan=no, number=number, inside=inside, remote=remote
        )
        rest = {"busy": no, "active": no, "mine": nothing, "last": nothing, "error": nothing}
        jobs = tuple(
            Job(
                ticket=z3.BitVec(f"ticket of {index}", _WIDE),
                waits=z3.Bool(f"{index} waits"),
                seen=z3.BitVec(f"scan of the last call of {index}", _WIDE),
                **rest,
            )
            for index in range(1, len(self.jobs) + 1)
        )
        return self.scene(channel, jobs)


def jobs(machine: Machine, library: Library, count: int) -> tuple[Path, ...]:
    """Create jobs in arbitrary states, and return their paths."""
    kind = library.pou("FB_RCXJOB").block
    assert kind is not None
    paths = tuple((f"JOB{number}",) for number in range(1, count + 1))
    for path in paths:
        machine.havoc(path, kind)
    return paths


def assumed(before: Scene) -> list[Any]:
    """Return the assumptions `calls`, `missed` and `waiters` for a call of the first job."""
    channel, job = before.channel, before.jobs[0]
    between = channel.scan - job.seen
    return [
        channel.inside,
        z3.Implies(z3.And(job.busy, low(between) == 1), between == 1),
        z3.Implies(
            z3.And(job.lives(channel), z3.Not(job.waits)),
            channel.turns - job.ticket <= FARTHEST + 1,
        ),
    ]


def after_call(places: Places, before: Scene) -> Scene:
    """Return the scene after a call of the first job, which the machine has made."""
    was, job = before.channel, before.jobs[0]
    after = places.scene(was, before.jobs)
    # The ghost variables follow the variables of the PLC. A changed NextTicket means that a ticket
    # was taken. A changed Serving means that turns have passed. A job that starts without a ticket
    # gets the ticket before the present turn, which has passed already.
    took = after.channel.next != was.next
    waits = z3.And(after.jobs[0].busy, z3.Or(took, z3.And(job.busy, job.waits)))
    passed = z3.If(job.busy, job.ticket, was.turns - 1)
    channel = replace(
        after.channel,
        tickets=was.tickets + z3.If(took, z3.BitVecVal(1, _WIDE), z3.BitVecVal(0, _WIDE)),
        turns=was.turns + until(was.serving, after.channel.serving),
        unseen=z3.And(was.unseen, z3.Not(waits)),
    )
    ticket = z3.If(took, was.tickets, passed)
    caller = replace(after.jobs[0], ticket=ticket, waits=waits, seen=was.scan)
    return Scene(channel, (caller, *after.jobs[1:]))


def after_write(places: Places, before: Scene) -> Scene:
    """Return the scene after a call of FB_WriteArea, which the machine has made."""
    was = before.channel
    after = places.scene(was, before.jobs)
    channel = replace(
        after.channel,
        turns=was.turns + until(was.serving, after.channel.serving),
        unseen=z3.Or(was.unseen, z3.And(was.written, was.inside)),
        inside=z3.BoolVal(False),
    )
    return Scene(channel, after.jobs)


def after_read(places: Places, before: Scene, number: Any) -> Scene:
    """Return the scene after a call of FB_ReadArea, which the machine has made."""
    was = before.channel
    after = places.scene(was, before.jobs)
    one = z3.If(was.inside, z3.BitVecVal(0, _WIDE), z3.BitVecVal(1, _WIDE))
    channel = replace(after.channel, scan=was.scan + one, number=number, inside=z3.BoolVal(True))
    return Scene(channel, after.jobs)
