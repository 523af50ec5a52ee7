"""Proofs that a channel becomes free: after a loss, after an answer, or by a time limit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import z3

from rcx_tools.evidence.prove.library import ROBOT, Library
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.summaries import LONGEST_MS
from rcx_tools.evidence.prove.tickets import model, turns
from structured_text.prove.symbolic_memory import Path

__all__ = ["PROPERTIES"]

#: Members of RCX_PHASE, in their order.
_RESET, _DATA, _RUN = 0, 2, 3
#: ErrorIDs of docs/reference/errors.md: not connected, controller not ready, then the time limits.
_LOSS = (0x8001, 0x8002)
_LIMIT = (0x8010, 0x8011, 0x8012, 0x8015)
_RUNNING_STATUS = 0x0100
_READ, _HOLDER, _WRITE = (("READ",), ("HOLDER",), ("WRITE",))
_HEADS = ("FB_RCXTAKEHEAD", "FB_REMOTECOMMAND", "FB_RCXMAKEHEAD")


def _one_of(value: Any, wanted: tuple[int, ...]) -> Any:
    return z3.Or(*(value == one for one in wanted))


def _call_goals(library: Library, channel: str) -> Iterator[Goal]:
    """Yield the goals about a block with the turn, and about any block when the link is lost."""
    step = turns.call(library, channel, 1)
    part = f"{channel} FB_RCXJOB"
    was, job = step.before.jobs[0], step.after.jobs[0]
    before, after = step.before.channel, step.after.channel
    in_time = z3.And(was.lives(before), was.seen == before.scan - 1)
    turn = z3.And(in_time, was.waits, was.ticket == before.turns)
    answer, applied = (step.was(("JOB1", name)) for name in ("ANSWER", "APPLIED"))
    trouble, armed = (step.was(("JOB1", name)) for name in ("TROUBLE", "ARMED"))
    loss = _one_of(answer, _LOSS)
    goes_on = z3.And(job.busy, job.active)
    yield step.goal(
        f"{part}: a loss ends every block that has a ticket",
        z3.Implies(z3.And(in_time, was.waits, loss), z3.Not(job.busy)),
    )
    yield step.goal(
        f"{part}: a loss ends a block without a ticket, except if it takes one in this scan",
        z3.Implies(z3.And(in_time, loss, job.busy), after.tickets == before.tickets + 1),
    )
    yield step.goal(
        f"{part}: a block with the turn is active in its next call, or ends in it",
        z3.Implies(turn, z3.Or(goes_on, z3.Not(job.busy))),
    )
    yield step.goal(
        f"{part}: in its turn it makes its request until that is on the wire",
        z3.Implies(
            z3.And(turn, z3.Not(applied), trouble == 0, z3.Not(loss), job.busy),
            z3.And(step.now(("JOB1", "REQUEST")), step.now(("JOB1", "ARMED"))),
        ),
    )
    yield step.goal(
        f"{part}: the answer to what is on the wire ends the turn",
        z3.Implies(
            z3.And(turn, was.active, armed, applied, answer != 0),
            z3.Not(job.busy),
        ),
    )
    yield step.goal(
        f"{part}: a valid error ends the turn, too",
        z3.Implies(
            z3.And(turn, was.active, trouble != 0, step.was(("JOB1", "SETTLED"))),
            z3.Not(job.busy),
        ),
    )


def _write_goals(library: Library, channel: str, block: str) -> Iterator[Goal]:
    """Yield the goals that FB_WriteArea frees a channel."""
    step = turns.write(library, channel, block)
    part = f"{channel} {block}"
    before, after = step.before.channel, step.after.channel
    works = z3.And(before.inside, before.written)
    free = z3.And(after.turns == after.tickets, z3.Not(after.orphan))
    nobody = z3.And(works, before.unseen)
    if not before.remote:
        yield step.goal(
            f"{part}: if no block has a ticket, the channel is free", z3.Implies(nobody, free)
        )
        return
    phase = step.now((*ROBOT, "INNER", "PHASE"))
    link = z3.And(step.was((*ROBOT, "CONNECTED")), step.was((*ROBOT, "SO", "SO01_CPUOK")))
    yield step.goal(
        f"{part}: without a ticket and without a sent command the channel is free",
        z3.Implies(z3.And(nobody, phase != _RUN), free),
    )
    yield step.goal(
        f"{part}: a loss clears the command on the wire, and no block is awaited",
        z3.Implies(
            z3.And(works, z3.Not(link)),
            z3.And(
                phase == _RESET,
                z3.Not(after.orphan),
                z3.Implies(before.unseen, free),
            ),
        ),
    )
    yield step.goal(
        f"{part}: no request remains from one scan to the next",
        z3.Implies(works, z3.Not(step.now((*ROBOT, "INNER", "CODEREQUEST")))),
    )


class _Scan:
    """One scan of the channel of remote commands, with a controller that answers in time.

    Either an FB_RemoteCommand has the turn, or an orphan: a command whose block is not called any
    more. All other blocks do not have the turn, so they change neither phase nor request.
    """

    def __init__(self, library: Library, holder: bool) -> None:
        self.machine = machine = model.machine(library)
        for path, name in zip((_READ, _HOLDER, _WRITE), _HEADS, strict=True):
            block = library.pou(name).block
            assert block is not None
            machine.havoc(path, block)
        machine.havoc(ROBOT, library.pou("FB_REMOTECOMMAND").symbols["ROBOT"].type)
        connected: Path = (*_READ, "CONNECTED")
        machine[connected] = True
        self.before = machine.snapshot()
        inner = (*ROBOT, "INNER")
        places = model.Places(machine, (*inner, "COMMAND"), ((*_HOLDER, "JOB"),) if holder else ())
        scene = places.any(True, machine.term((*inner, "SCAN")), z3.BoolVal(False))
        self.channel = scene.channel
        self.assumed = [
            *scene.holds().values(),
            scene.channel.counted(),
            scene.channel.written,
            z3.Not(machine.term((*inner, "INSCAN"))),
            z3.Not(machine.term((*inner, "CODEREQUEST"))),
            machine.term((*_READ, "BEGUN")),
            machine.term((*_READ, "BITS")) & 2 == 2,  # CPU_OK
        ]
        for job in scene.jobs:
            self.assumed += [
                job.lives(scene.channel),
                job.waits,
                job.ticket == scene.channel.turns,
                machine.term((*_HOLDER, "BUSY")),
            ]
        self.was = self._stage(holder)
        self._controller()
        robot = {"ROBOT": ROBOT}
        machine.call_block(_READ, _HEADS[0], robot)
        if holder:
            machine.call_block(_HOLDER, _HEADS[1], robot)
        machine.call_block(_WRITE, _HEADS[2], robot)
        self.now = self._stage(holder)
        self.assumed += machine.assumptions

    def _stage(self, holder: bool) -> Any:
        """Return the greatest number of remaining stages of the turn (a ranking function)."""
        machine = self.machine
        phase = machine.term((*ROBOT, "INNER", "PHASE"))
        status = machine.term((*ROBOT, "STATUS"))
        handshake = (*_WRITE, "HANDSHAKE")

        def number(value: int) -> Any:
            return z3.BitVecVal(value, 32)

        out = z3.If(status == 0, number(3), number(2))
        if not holder:
            return z3.If(phase == _RUN, out, number(1))
        own = z3.And(
            phase == _DATA,
            machine.term((*handshake, "OWNER"))
            == machine.term((*ROBOT, "INNER", "COMMAND", "SERVING")),
            machine.term((*handshake, "ASKED")) == machine.term((*_HOLDER, "HELDCODE")),
            *(
                machine.term((*_WRITE, "WORDS", place))
                == machine.term((*_HOLDER, "HELDDATA", place))
                for place in range(15)
            ),
        )
        armed = machine.term((*_HOLDER, "JOB", "ARMED"))
        before = z3.If(status != 0, number(6), z3.If(own, number(4), number(5)))
        return z3.If(phase == _RUN, z3.If(armed, out, out + 5), before)

    def _controller(self) -> None:
        """Restrict the next status of the controller and its answer time (guide chapter 2)."""
        machine = self.machine
        status, code_out = (
            machine.term((*ROBOT, "STATUS")),
            machine.term((*ROBOT, "INNER", "PHASE")) == _RUN,
        )
        following = machine.term((*_READ, "STATUS"))
        end = _one_of(status, turns.ENDS)
        still = following == status
        waits = z3.If(code_out, z3.Not(end), status != 0)
        answered = z3.Or(
            z3.And(status == 0, following == _RUNNING_STATUS), _one_of(following, turns.ENDS)
        )
        self.longest, self.left = z3.BitVec("scans at most", 32), z3.BitVec("scans left", 32)
        self.assumed += [
            z3.Or(status == 0, status == _RUNNING_STATUS, end),
            self.longest >= 1,
            self.longest < 1 << 24,
            self.left >= 1,
            self.left <= self.longest,
            z3.If(
                waits,
                z3.Or(
                    z3.And(still, self.left > 1),
                    z3.If(code_out, answered, following == 0),
                ),
                still,
            ),
        ]
        self.left_now = z3.If(z3.And(waits, still), self.left - 1, self.longest)

    def nearer(self) -> Any:
        """Return the claim that the end of the turn is nearer after the scan.

        The turn ends after at most 5 * `longest` + 2 scans.
        """
        return z3.ULT(self._scans(self.now, self.left_now), self._scans(self.was, self.left))

    def _scans(self, stage: Any, left: Any) -> Any:
        """Return the greatest number of scans up to the end of the turn.

        In the stages 2, 3, 6, 7 and 8 the controller must answer. The other stages take one scan.
        """
        least = {2: left, 3: left + self.longest}
        # Waiting times of the controller add up: the present wait counts `left`, and each later
        # wait counts `longest`. Every other stage before the end adds one scan.
        least |= {4: 2 * self.longest + 1, 5: 2 * self.longest + 2}
        least |= {number: left + (number - 4) * self.longest + 2 for number in (6, 7, 8)}
        result = z3.BitVecVal(1, 32)
        for number, scans in least.items():
            result = z3.If(stage == number, scans, result)
        return result

    def term(self, path: Path) -> Any:
        """Return the value of a scalar after the scan, as a term."""
        return self.machine.term(path)

    def goal(self, name: str, assumed: tuple[Any, ...], claim: Any) -> Goal:
        """Return a goal with a name and a claim about this scan."""
        show = {
            "stage before": self.was,
            "stage after": self.now,
            "phase before": self.machine.term((*ROBOT, "INNER", "PHASE"), self.before),
            "phase after": self.term((*ROBOT, "INNER", "PHASE")),
            "status before": self.machine.term((*ROBOT, "STATUS"), self.before),
            "status after": self.term((*ROBOT, "STATUS")),
        }
        return Goal(name, (*self.assumed, *assumed), claim, show)


def _scan_goals(library: Library, who: str) -> Iterator[Goal]:
    scan = _Scan(library, holder=who == "HOLDER")
    turn = scan.term((*ROBOT, "INNER", "COMMAND", "SERVING"))
    if who == "HOLDER":
        ready = (
            scan.term((*_WRITE, "HANDSHAKE", "RECOVERY", "Q")),
            z3.Not(scan.term((*_WRITE, "JOGHOLD"))),
        )
        job = (*_HOLDER, "JOB")
        yield scan.goal(
            "COMMAND: in each scan of a turn its end comes nearer",
            ready,
            z3.Or(z3.Not(scan.term((*job, "BUSY"))), scan.nearer()),
        )
        yield scan.goal(
            "COMMAND: a block with the turn keeps it to the end",
            (scan.term((*job, "BUSY")),),
            z3.And(scan.term((*job, "ACTIVE")), turn == scan.channel.serving),
        )
        return
    orphan = scan.term((*ROBOT, "INNER", "COMMAND", "ORPHAN"))
    yield scan.goal(
        "COMMAND: in each scan the end of a command whose block has gone comes nearer",
        (scan.channel.orphan,),
        z3.Or(
            z3.And(z3.Not(orphan), turn == scan.channel.lowest),
            z3.And(orphan, turn == scan.channel.serving, scan.nearer()),
        ),
    )


def _free(library: Library, part: str) -> Iterator[Goal]:
    channel, block = part.split()
    if block in turns.WRITERS:
        yield from _write_goals(library, channel, block)
    elif block == "FB_RCXJOB":
        yield from _call_goals(library, channel)
    else:
        yield from _scan_goals(library, block)


def _limit(library: Library, channel: str) -> Iterator[Goal]:
    step = turns.call(library, channel, 1)
    was, job = step.before.jobs[0], step.after.jobs[0]
    pins = {name: step.was(("JOB1", name)) for name in ("LONGEST", "WAITED", "ELAPSED", "ANSWER")}
    longest, waited = pins["LONGEST"], pins["WAITED"]
    after = step.now(("JOB1", "WAITED"))
    limited = z3.And(longest > 0, longest <= LONGEST_MS)
    elapsed = z3.ZeroExt(16, pins["ELAPSED"])
    counted = z3.If(waited < 0, z3.BitVecVal(0, 32), waited + elapsed)
    took = step.after.channel.tickets != step.before.channel.tickets
    more = z3.And(limited, was.busy, job.busy)
    in_bounds = z3.And(waited >= -1, waited < longest)
    yield step.goal(
        f"{channel}: a block that continues is below its limit, except in the scan of its ticket",
        z3.Implies(
            z3.And(limited, job.busy, z3.Or(z3.Not(took), z3.Not(was.busy))), after < longest
        ),
    )
    yield step.goal(
        f"{channel}: a block that had reached its limit ends, or its turn begins",
        z3.Implies(
            z3.And(more, was.waits, was.lives(step.before.channel), waited >= longest),
            z3.And(after <= 0, z3.Or(job.active, z3.Not(step.before.channel.orphan))),
        ),
    )
    yield step.goal(
        f"{channel}: in its turn, and behind an orphan, each scan is counted",
        z3.Implies(
            z3.And(
                more,
                in_bounds,
                z3.Or(was.active, z3.And(step.before.channel.orphan, z3.Not(job.active))),
            ),
            after == counted,
        ),
    )
    yield step.goal(
        f"{channel}: its own turn is counted from its start",
        z3.Implies(z3.And(limited, job.busy, job.active, z3.Not(was.active)), after == 0),
    )
    over = z3.Or(
        longest == 0,
        z3.And(limited, in_bounds, z3.Not(z3.And(waited >= 0, waited + elapsed >= longest))),
    )
    yield step.goal(
        f"{channel}: a limit never ends it early, and a block without a limit is not ended",
        z3.Implies(
            z3.And(was.busy, z3.Not(job.busy), over, step.was(("JOB1", "TROUBLE")) == 0),
            z3.Or(job.error == pins["ANSWER"], z3.Not(_one_of(job.error, _LIMIT))),
        ),
    )


def _rests_on(part: str) -> list[str]:
    block = part.split()[1]
    heads = {"HOLDER": [*_HEADS, "FB_WRITEAREA"], "ORPHAN": [*_HEADS, "FB_WRITEAREA"]}
    return heads.get(block, ["FB_RCXJOB", block])


PROPERTIES = (
    Property(
        "turn-free",
        "A channel is used by one block at a time, the block that has the turn. From every state "
        "the channel becomes free again. After a loss of the link or of CPU_OK this takes two "
        "scans. Otherwise the controller has to answer. Every scan then brings the end of the "
        "turn nearer, and the next waiting block gets the turn in its next call.",
        "guide chapter 2; docs/explanation/scan-model.md",
        ("inner", "calls", "missed", "waiters", "counts", "answers"),
        _free,
        lambda _: [
            *turns.parts("FB_RCXJOB", *turns.WRITERS),
            "COMMAND HOLDER",
            "COMMAND ORPHAN",
        ],
        _rests_on,
    ),
    Property(
        "turn-limit",
        "If a block has a time limit, the block ends at the latest in the call in which the limit "
        "is reached. The time counts while the block has its turn, and while it waits for the end "
        "of a command whose block is not called any more. The limit never ends a block earlier.",
        "docs/explanation/scan-model.md",
        ("inner", "calls", "missed", "waiters", "counts"),
        _limit,
        lambda _: turns.CHANNELS,
        lambda _: ("FB_RCXJOB",),
    ),
)
