"""Proofs about the turns on a channel: one block at a time, and the oldest ticket first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.tickets import model, writers
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path

__all__ = ["PROPERTIES", "Step", "call", "parts", "shown", "write"]

CHANNELS = ("COMMAND", "SEQUENCE")
WRITERS = ("FB_WRITEAREA", "FB_WRITEAREAWORDS")
_READERS = ("FB_READAREA", "FB_READAREAWORDS")
#: End values of the remote status: normal end and abnormal end (guide chapter 2).
ENDS = (0x0200, 0x4000)


@dataclass(frozen=True)
class Step:
    """A call, with its assumptions and with the scenes before and after the call."""

    machine: Machine
    before: model.Scene
    after: model.Scene
    assumed: tuple[Any, ...]
    old: dict[Path, Any]

    def was(self, path: Path) -> Any:
        """Return the value of a scalar before the call, as a term."""
        return self.machine.term(path, self.old)

    def now(self, path: Path) -> Any:
        """Return the value of a scalar after the call, as a term."""
        return self.machine.term(path)

    def goal(self, name: str, claim: Any) -> Goal:
        """Return a goal with a name and a claim about this call."""
        return Goal(name, self.assumed, claim, shown(self))


def shown(step: Step) -> dict[str, Any]:
    """Return the terms that explain a counterexample to people."""
    values: dict[str, Any] = {}
    for when, scene in (("before", step.before), ("after", step.after)):
        channel = scene.channel
        values |= {
            f"{when}: {name}": getattr(channel, name)
            for name in (
                "inside",
                "tickets",
                "turns",
                "scan",
                "next",
                "serving",
                "lowest",
                "orphan",
            )
        }
        for number, job in enumerate(scene.jobs, 1):
            values |= {
                f"{when}: job {number} {name}": getattr(job, name)
                for name in ("busy", "active", "waits", "ticket", "mine", "seen", "error")
            }
    return values


def call(library: Library, channel: str, count: int = 3) -> Step:
    """Return a step in which one job is called. All other jobs are in arbitrary states."""
    machine = library.machine()
    paths = model.jobs(machine, library, count)
    kind = library.pou("FB_RCXJOB").symbols["CHANNEL"].type
    machine.havoc(("CHANNEL",), kind)
    places = model.Places(machine, ("CHANNEL",), paths)
    number, inside = z3.BitVec("number", 16), z3.Bool("inside")
    remote = channel == "COMMAND"
    before = places.any(remote, number, inside)
    pins: dict[Path, Any] = {(*paths[0], "SCAN"): number, (*paths[0], "REMOTE"): remote}
    for pin, value in pins.items():
        machine[pin] = value
    old = machine.snapshot()
    machine.call_block(paths[0], "FB_RcxJob", {"CHANNEL": ("CHANNEL",)})
    assumed = (
        *machine.assumptions,
        *before.holds().values(),
        before.channel.counted(),
        *model.assumed(before),
    )
    return Step(machine, before, model.after_call(places, before), assumed, old)


def write(library: Library, channel: str, block: str) -> Step:
    """Return the step of FB_WriteArea or its twin for words. Jobs are in arbitrary states."""
    machine = model.machine(library)
    # FB_WriteArea runs first, because `step` chooses the memory. Then the old memory is restored
    # and gets jobs, and the scene before the call is read. Finally the memory after the call is
    # restored, and the scene after the call is read.
    called = library.step(block, machine)
    inside = called.was((*ROBOT, "INNER", "INSCAN"))
    number = called.was((*ROBOT, "INNER", "SCAN"))
    after = machine.snapshot()
    machine.restore(called.before)
    places = model.Places(machine, (*ROBOT, "INNER", channel), model.jobs(machine, library, 2))
    before = places.any(channel == "COMMAND", number, inside)
    machine.restore(machine.snapshot() | after)
    error = called.now((*BLOCK, "ERRORID"))
    assumed = (
        *machine.assumptions,
        *before.holds().values(),
        before.channel.counted(),
        before.channel.written == z3.Or(error == 0, error == 0x8037),
    )
    return Step(machine, before, model.after_write(places, before), assumed, called.before)


def _read(library: Library, channel: str, block: str) -> Step:
    machine = model.machine(library)
    called = library.step(block, machine)
    after = machine.snapshot()
    machine.restore(called.before)
    places = model.Places(machine, (*ROBOT, "INNER", channel), model.jobs(machine, library, 2))
    inside = called.was((*ROBOT, "INNER", "INSCAN"))
    before = places.any(channel == "COMMAND", called.was((*ROBOT, "INNER", "SCAN")), inside)
    machine.restore(machine.snapshot() | after)
    assumed = (
        *machine.assumptions,
        *before.holds().values(),
        before.channel.counted(),
        called.was((*BLOCK, "TAKEHEAD", "BEGUN")),
    )
    number = called.now((*ROBOT, "INNER", "SCAN"))
    return Step(machine, before, model.after_read(places, before, number), assumed, called.before)


def _power_up(library: Library, channel: str) -> Iterator[Goal]:
    """Yield the goals that the invariant holds after the first FB_ReadArea.

    No other block has been called. The number of the scan is arbitrary.
    """
    machine = library.machine()
    job = library.pou("FB_RCXJOB")
    assert job.block is not None
    paths: tuple[Path, ...] = (("JOB1",), ("JOB2",))
    for path in paths:
        machine.create(path, job.block)
    robot = library.pou("FB_READAREA").symbols["ROBOT"]
    machine.create(ROBOT, robot.type, robot.initial)
    places = model.Places(machine, (*ROBOT, "INNER", channel), paths)
    number = z3.BitVec("number", 16)
    scene = places.any(channel == "COMMAND", number, z3.BoolVal(True))
    started = [
        scene.channel.tickets == 1 << 16,
        scene.channel.turns == 1 << 16,
        scene.channel.unseen,
        model.low(scene.channel.scan) == number,
        *(z3.And(job.seen == 0, z3.Not(job.waits)) for job in scene.jobs),
        scene.channel.counted(),
    ]
    for name, claim in scene.holds().items():
        yield Goal(f"{channel}: power-up: {name}", tuple(started), claim)


def _kept(step: Step, told: str) -> Iterator[Goal]:
    """Yield the goals that a call preserves the invariants of the channel and of all jobs.

    Two jobs that are not called represent all others, because these are interchangeable.
    """
    alike = f"job {len(step.after.jobs)}:"
    for name, claim in step.after.holds().items():
        if not name.startswith(alike):
            yield step.goal(f"{told}: {name}", claim)


def _once(library: Library, part: str) -> Iterator[Goal]:
    channel, block = part.split()
    if block == "POWER-UP":
        yield from _power_up(library, channel)
    elif block in WRITERS:
        yield from _kept(write(library, channel, block), part)
    elif block in _READERS:
        yield from _kept(_read(library, channel, block), part)
    else:
        step = call(library, channel)
        yield from _kept(step, part)
        one, two, _ = step.after.jobs
        where = step.after.channel
        both = [job.lives(where) for job in (one, two)]
        yield step.goal(
            f"{part}: two jobs are never both active",
            z3.Not(z3.And(*both, one.active, two.active)),
        )
        yield Goal(
            f"{part}: in any order of calls, an active job has the served ticket",
            tuple(step.machine.assumptions),
            z3.Implies(
                z3.And(
                    one.active, z3.Or(step.before.jobs[0].busy, z3.Not(step.before.jobs[0].active))
                ),
                z3.And(one.busy, one.mine == where.serving),
            ),
            shown(step),
        )
        was, job = step.before.channel, step.before.jobs[0]
        own = job.mine == was.serving
        yield step.goal(
            f"{part}: a job that keeps its turn has the served ticket",
            model.keeps_turn(job.busy, job.active, job.last, was.number, own),
        )
        yield step.goal(
            f"{part}: a job makes a request only in its turn",
            z3.Implies(
                step.now(("JOB1", "REQUEST")),
                z3.And(one.active, one.mine == step.after.channel.serving),
            ),
        )


def _order(library: Library, part: str) -> Iterator[Goal]:
    channel, block = part.split()
    step = write(library, channel, block) if block in WRITERS else call(library, channel, 2)
    before, after = step.before, step.after
    other = after.jobs[1]
    waits = z3.And(other.lives(after.channel), other.waits)
    yield step.goal(
        f"{part}: no waiting job is skipped",
        z3.Implies(waits, after.channel.turns <= other.ticket),
    )
    yield step.goal(
        f"{part}: turns go forward, at most to the next ticket",
        z3.And(
            before.channel.turns <= after.channel.turns,
            after.channel.turns <= after.channel.tickets,
        ),
    )
    if block in WRITERS:
        return
    job, was = after.jobs[0], before.jobs[0]
    yield step.goal(
        f"{part}: a job that begins a turn has the oldest ticket",
        z3.Implies(
            z3.And(job.active, z3.Not(was.active), waits),
            z3.And(job.ticket == after.channel.turns, job.ticket < other.ticket),
        ),
    )
    took = after.channel.tickets != before.channel.tickets
    yield step.goal(
        f"{part}: a new ticket comes after all waiting tickets",
        z3.Implies(z3.And(took, waits), job.ticket > other.ticket),
    )
    yield step.goal(
        f"{part}: a waiting job keeps its ticket",
        z3.Implies(
            z3.And(was.lives(before.channel), was.waits, job.busy),
            z3.And(z3.Not(took), job.mine == was.mine),
        ),
    )


def _back(library: Library, part: str) -> Iterator[Goal]:
    channel, block = part.split()
    if block in WRITERS:
        yield from _taken_back(write(library, channel, block), part)
        return
    step = call(library, channel, 1)
    before, after = step.before.channel, step.after.channel
    was, job = step.before.jobs[0], step.after.jobs[0]
    on_wire = step.was(("JOB1", "APPLIED"))
    ended = z3.And(was.lives(before), z3.Not(job.busy))
    placed = step.was(("JOB1", "INSCAN"))
    holder = z3.And(
        ended, placed, was.ticket == before.turns, was.waits, was.seen == before.scan - 1
    )
    held = z3.And(z3.BoolVal(channel == "COMMAND"), on_wire, after.orphan)
    stays = z3.And(after.turns == before.turns, after.lowest == before.lowest)
    yield step.goal(
        f"{part}: a job that ends in its turn passes it on, unless its command is held",
        z3.Implies(
            holder,
            z3.Or(
                z3.And(after.turns == before.turns + 1, z3.Not(after.orphan)),
                z3.And(stays, held),
            ),
        ),
    )
    yield step.goal(
        f"{part}: a command is held to its end only while it is on the wire",
        z3.Implies(z3.And(after.orphan, z3.Not(before.orphan)), z3.And(holder, held)),
    )
    yield step.goal(
        f"{part}: a job without the turn does not pass it on",
        z3.Implies(z3.Not(holder), after.turns == before.turns),
    )
    yield step.goal(
        f"{part}: Lowest is always the ticket of a job that continues",
        z3.Or(
            after.lowest == before.lowest,
            z3.And(job.busy, job.waits, after.lowest == job.mine),
        ),
    )
    yield step.goal(
        f"{part}: a job that was not called, or was called twice or out of place, ends",
        z3.Implies(
            z3.And(was.busy, z3.Or(was.seen != before.scan - 1, z3.Not(placed))),
            z3.And(z3.Not(job.busy), z3.Not(job.active), job.error != 0, stays),
        ),
    )


def _taken_back(step: Step, part: str) -> Iterator[Goal]:
    """Yield the goals that FB_WriteArea takes the turn only from a block that is not called."""
    before, after = step.before.channel, step.after.channel
    works = z3.And(before.inside, before.written)
    gone = z3.And(works, before.serving != before.lowest)
    moved = z3.And(after.serving == before.lowest, z3.Not(after.orphan))
    yield step.goal(
        f"{part}: a job that was called in its turn keeps it",
        z3.Implies(
            z3.Or(z3.Not(works), before.serving == before.lowest),
            z3.And(after.turns == before.turns, after.orphan == before.orphan),
        ),
    )
    if not before.remote:
        yield step.goal(
            f"{part}: the turn of a job that is gone passes on", z3.Implies(gone, moved)
        )
        return
    run = 3
    phase = (*ROBOT, "INNER", "PHASE")
    status = step.was((*ROBOT, "STATUS"))
    out = step.was(phase) == run
    over = z3.Or(
        z3.Not(step.was((*ROBOT, "CONNECTED"))),
        z3.Not(step.was((*ROBOT, "SO", "SO01_CPUOK"))),
        z3.And(
            out,
            z3.Or(
                *(status == end for end in ENDS),
                z3.And(status == 0, step.was((*ROBOT, "INNER", "RUNNING"))),
            ),
        ),
        z3.And(z3.Not(out), z3.Not(step.was((*ROBOT, "INNER", "CODEREQUEST")))),
    )
    yield step.goal(
        f"{part}: the turn of a job that is gone passes on at the end of its command",
        z3.Implies(z3.And(gone, over), moved),
    )
    yield step.goal(
        f"{part}: until then the turn stays",
        z3.Implies(
            gone,
            z3.If(
                step.now(phase) == run,
                z3.And(after.turns == before.turns, after.orphan),
                moved,
            ),
        ),
    )


def parts(*blocks: str) -> list[str]:
    """Return the names of the parts of a property: each combination of block and channel."""
    return [f"{channel} {block}" for channel in CHANNELS for block in blocks]


def _rests_on(part: str) -> list[str]:
    block = part.split()[1]
    return ["FB_RCXJOB", "FB_READAREA"] if block == "POWER-UP" else ["FB_RCXJOB", block]


PROPERTIES = (
    Property(
        "turn-hands",
        "The order in which blocks use a channel depends on a few variables of RCX_REF. Only "
        "FB_RcxJob, FB_ReadArea and FB_WriteArea write these variables. Every block passes the "
        "inputs to its FB_RcxJob that the proofs of the other turn properties assume.",
        "docs/explanation/scan-model.md",
        ("inner",),
        writers.goals,
    ),
    Property(
        "turn-once",
        "A block that waits for a channel has a ticket, and the block with the served ticket has "
        "the turn. Two blocks never have the turn at the same time, and never have tickets that "
        "the PLC cannot distinguish. A block that keeps the turn from one scan to the next has "
        "the served ticket. This holds for any number of blocks.",
        "docs/explanation/scan-model.md",
        ("inner", "calls", "missed", "waiters", "counts"),
        _once,
        lambda _: parts("FB_RCXJOB", *WRITERS, *_READERS, "POWER-UP"),
        _rests_on,
    ),
    Property(
        "turn-order",
        "Blocks get a channel in the order of their requests: a block never gets its turn while a "
        "block with an older ticket is still called and waits.",
        "docs/explanation/scan-model.md",
        ("inner", "calls", "missed", "waiters", "counts"),
        _order,
        lambda _: parts("FB_RCXJOB", *WRITERS),
        _rests_on,
    ),
    Property(
        "turn-back",
        "If a block ends during its turn, the next block gets the turn. If its command is still "
        "being sent, the turn ends later: when the command ends or the link or CPU_OK is lost. If "
        "a block with the turn is not called any more, or is called outside of FB_ReadArea and "
        "FB_WriteArea, the next block that is still called gets the turn.",
        "docs/explanation/scan-model.md",
        ("inner", "calls", "missed", "waiters", "counts"),
        _back,
        lambda _: parts("FB_RCXJOB", *WRITERS),
        _rests_on,
    ),
)
