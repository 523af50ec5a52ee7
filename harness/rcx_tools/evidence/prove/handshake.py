"""The handshake of remote commands on the wire (guide chapters 1 and 2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import z3

from rcx_tools.evidence.prove.area import (
    DEDICATED,
    accepted,
    at_the_start,
    legal_image,
    offset,
    word,
)
from rcx_tools.evidence.prove.composites import COLLECTS, inside
from rcx_tools.evidence.prove.guarantee import COMMAND_RUN, INNER, READERS, WRITERS
from rcx_tools.evidence.prove.invariants import View, alarms
from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.restart import CARRIERS, agrees, answers, jobs_of, known, shows
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value

__all__ = ["PROPERTIES"]

Memory = Mapping[Path, Value]

#: Remote status (guide chapter 1, 1.2).
READY, RUNNING, NORMAL_END, ABNORMAL_END = 0x0000, 0x0100, 0x0200, 0x4000
#: Answer of FB_ReadArea for each end status (docs/reference/errors.md: 16#8020 means abnormal end).
_ENDS = {NORMAL_END: 0x0200, ABNORMAL_END: 0x8020}
#: All answers of FB_ReadArea: the end statuses, no answer yet, not connected, not ready, command
#: lost.
_ANSWERS = (*_ENDS.values(), 0x0000, 0x8001, 0x8002, 0x8014)
#: Codes for the current position in pulses and in mm, and the bit of n + 2 that requests continuous
#: output (guide 4.7.4). Continuous output has no end status. The status reset ends it.
_POSITIONS, _CONTINUOUS = (0x0505, 0x0506), 0x0001
_HEAD: Path = (*BLOCK, "MAKEHEAD")
#: Path of the variable in FB_WriteArea with a copy of the data on the wire (see property `bytes`).
_CODE: Path = (*_HEAD, "CODE")
_RECOVERY: Path = (*_HEAD, "HANDSHAKE", "RECOVERY")
_COMMAND_DATA = 2
#: Blocks that send one command per row: the pin that shows the end of a row, and the row counter.
_ROWS: dict[str, tuple[str, Path]] = {
    "FB_POINTBACKUP": ("TAKEN", ("HEAD", "COUNT")),
    "FB_POINTRESTORE": ("DIFFERENT", ("ROW",)),
}


def _words(step_or_memory: Any, machine: Machine, root: Path) -> list[Any]:
    return [machine.term((*root, place), step_or_memory) for place in range(15)]


def _same(one: list[Any], other: list[Any]) -> Any:
    return z3.And(*[left == right for left, right in zip(one, other, strict=True)])


def _holds(machine: Machine, memory: Memory | None, answered: Any) -> list[Any]:
    """Return the invariant between two calls of FB_WriteArea.

    `answered`: a status other than 16#0000 has been read since the code was sent.
    """

    def get(*path: Any) -> Any:
        return machine.term(path, memory)

    phase, code = get(*INNER, "PHASE"), get(*_CODE)
    runs = phase == COMMAND_RUN
    wire, data = (
        _words(memory, machine, (*_HEAD, "WORDS")),
        _words(memory, machine, (*INNER, "DATA")),
    )
    expired, clock = get(*_RECOVERY, "Q"), get(*_RECOVERY, "phase")
    # The clauses, in order: the recovery timer is consistent; there is no code on the wire unless a
    # command runs; while a command runs, wire and request have the same code and data; a command
    # runs only after the recovery time and if it was not lost; RUNNING is set only after an answer.
    # The last clause links the flag to the history of the wire, which no variable of the block
    # records.
    return [
        z3.And(
            z3.ULE(clock, 2), expired == (clock == 2), get(*_RECOVERY, "before") == (clock != 0)
        ),
        z3.Implies(z3.Not(runs), code == 0),
        z3.Implies(runs, code == get(*INNER, "CODE")),
        z3.Implies(runs, _same(wire, data)),
        z3.Implies(runs, z3.And(expired, z3.Not(get(*_HEAD, "HANDSHAKE", "LOST")))),
        z3.Implies(z3.And(runs, get(*INNER, "RUNNING")), answered),
    ]


def _continuous(step: Step) -> Any:
    """Return the claim that the command on the wire is a continuous output of positions."""
    code = step.was(_CODE) & 0x0FFF
    asked = step.was((*_HEAD, "WORDS", 0)) & _CONTINUOUS != 0
    return z3.And(z3.Or(*[code == number for number in _POSITIONS]), asked)


def _write_area(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals that every call of FB_WriteArea preserves the invariant `_holds`.

    Calls of other blocks do not violate the invariant: by property `guarantee` they change neither
    Phase nor Running, and while a command is sent also not Code and Data. Only FB_WriteArea
    contains MakeHead.
    """
    start = at_the_start(library, name)
    claim = z3.And(*_holds(start, None, z3.BoolVal(False)))
    yield Goal(f"{name}: the invariant holds at the start", tuple(start.assumptions), claim)
    step = library.step(name)
    machine = step.machine
    answered = z3.Bool("answered")
    assumed = (*machine.assumptions, *_holds(machine, step.before, answered))
    status = step.was((*ROBOT, "STATUS"))
    was, now = step.was(_CODE), step.now(_CODE)
    data = [_words(memory, machine, (*_HEAD, "WORDS")) for memory in (step.before, None)]
    up = z3.And(step.was((*ROBOT, "CONNECTED")), step.was((*ROBOT, "SO", "SO01_CPUOK")))
    goes = z3.And(was == 0, now != 0)
    out = was != 0
    show = {"status": status, "code before": was, "code": now}

    yield Goal(
        f"{name}: the data are on the wire one scan before the code",
        assumed,
        z3.Implies(goes, _same(*data)),
        show,
    )
    yield Goal(
        f"{name}: a code is sent at the ready status only",
        assumed,
        z3.Implies(goes, z3.And(status == READY, up)),
        show,
    )
    ended = z3.Or(status == NORMAL_END, status == ABNORMAL_END)
    fell = z3.And(status == READY, answered)
    stopped = z3.And(_continuous(step), status == RUNNING)
    kept = z3.And(now == was, _same(*data))
    yield Goal(
        f"{name}: code and data are held until an end",
        assumed,
        z3.Implies(out, z3.Or(kept, ended, z3.Not(up), fell, stopped)),
        show,
    )
    yield Goal(
        f"{name}: 16#0000 between two codes",
        assumed,
        z3.Implies(out, z3.Or(now == was, now == 0)),
        show,
    )
    over = z3.And(accepted(step), out, z3.Or(ended, z3.Not(up), fell))
    yield Goal(
        f"{name}: an end, a loss or a status that falls back ends the command at once",
        (*assumed, z3.Implies(fell, step.was((*INNER, "RUNNING")))),
        z3.Implies(over, now == 0),
        show,
    )
    phases = [call((*INNER, "PHASE")) == COMMAND_RUN for call in (step.was, step.now)]
    since = z3.And(*phases, z3.Or(answered, status != READY))
    for number, claim in enumerate(_holds(machine, None, since), 1):
        more = z3.Implies(accepted(step), claim)
        other = z3.Implies(z3.Not(accepted(step)), z3.And(*_holds(machine, None, answered)))
        yield Goal(
            f"{name}: the invariant holds again ({number})", assumed, z3.And(more, other), show
        )


def _read_area(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals about the values that FB_ReadArea reads, and its answer to the blocks."""
    step = library.step(name)
    machine = step.machine
    taken = z3.And(step.now((*ROBOT, "CONNECTED")), z3.Not(step.was((*INNER, "INSCAN"))))
    assumed = (*machine.assumptions, legal_image(machine), taken)
    start = offset(machine, "M")
    status, answer = step.now((*ROBOT, "STATUS")), step.now((*INNER, "ANSWER"))
    yield Goal(f"{name}: the status of this scan", assumed, status == word(machine, start))
    for number in range(1, 16):
        response = step.now((*ROBOT, "RESPONSE", number - 1))
        claim = response == word(machine, start + 2 * number)
        yield Goal(f"{name}: word {number} of the response of this scan", assumed, claim)
    ready = z3.Extract(1, 1, word(machine, start + DEDICATED)) == 1
    yield Goal(
        f"{name}: CPU_OK of this scan", assumed, step.now((*ROBOT, "SO", "SO01_CPUOK")) == ready
    )
    known = z3.Or(*[answer == told for told in _ANSWERS])
    yield Goal(f"{name}: there is no other answer", assumed, known)
    for end, told in _ENDS.items():
        claim = (answer == told) == z3.And(ready, status == end)
        yield Goal(f"{name}: the end status 16#{end:04X} is reported", assumed, claim)


def _taken(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals that a command block with the turn ends in the scan of the end status.

    Done is not TRUE before that scan. The block shows the alarm and the response of that scan.
    """
    step = library.step(name)
    machine = step.machine
    job = (*BLOCK, "JOB")
    busy, answer = step.was((*BLOCK, "BUSY")), step.was((*INNER, "ANSWER"))
    agree = shows(machine, step.before, BLOCK, job)  # this fact is proved by property `restart`
    known = z3.Or(*[answer == told for told in _ANSWERS])
    assumed = (*machine.assumptions, *agree, known)
    done, error = step.now((*BLOCK, "DONE")), step.now((*BLOCK, "ERROR"))
    runs = step.was((*INNER, "PHASE")) == COMMAND_RUN
    began = z3.And(busy, done)
    yield Goal(
        f"{name}: Done comes in the scan of the end status only",
        assumed,
        z3.Implies(began, z3.And(answer == _ENDS[NORMAL_END], runs)),
    )
    out = z3.And(
        busy,
        runs,
        step.was((*job, "ACTIVE")),
        step.was((*job, "ARMED")),
        step.was((*job, "TICKET")) == step.was((*INNER, "COMMAND", "SERVING")),
        step.was((*job, "SEEN")) + 1 == step.was((*INNER, "SCAN")),
    )
    ends = z3.Or(*[answer == told for told in _ENDS.values()])
    yield Goal(
        f"{name}: it ends in the scan of the end status",
        assumed,
        z3.Implies(
            z3.And(out, ends), z3.And(z3.Not(step.now((*BLOCK, "BUSY"))), z3.Or(done, error))
        ),
    )
    failed = z3.And(busy, error, step.now((*BLOCK, "ERRORID")) == _ENDS[ABNORMAL_END])
    alarm = [
        step.now((*BLOCK, pin)) == step.was((*ROBOT, "RESPONSE", place))
        for place, pin in enumerate(("ALARMGROUP", "ALARMCATEGORY"))
    ]
    yield Goal(
        f"{name}: the alarm is what was read in this scan",
        assumed,
        z3.Implies(failed, z3.And(*alarm)),
    )
    if name == "FB_REMOTECOMMAND":
        response = [
            _words(None, machine, root) for root in ((*BLOCK, "RESPONSE"), (*ROBOT, "RESPONSE"))
        ]
        claim = z3.Implies(z3.Or(began, failed), _same(*response))
        yield Goal(f"{name}: the response is what was read in this scan", assumed, claim)


def _row(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals of a block that sends one command per row.

    In the scan of the end status the block shows the row and the alarm.
    """
    step = library.step(name)
    machine = step.machine
    command = (*BLOCK, "ONE", "COMMAND")
    job = (*command, "JOB")
    busy, answer = step.was((*BLOCK, "BUSY")), step.was((*INNER, "ANSWER"))
    assumed = (
        *machine.assumptions,
        agrees(library, machine, step.before, name),  # this fact is proved by property `restart`
        answers(machine),
        z3.Or(*[answer == told for told in _ANSWERS]),
    )
    runs = step.was((*INNER, "PHASE")) == COMMAND_RUN
    ends = z3.And(runs, z3.Or(*[answer == told for told in _ENDS.values()]))
    shown, counts = _ROWS[name]
    yield Goal(
        f"{name}: a row is shown in the scan of the end status only",
        assumed,
        z3.Implies(z3.And(busy, step.now((*BLOCK, shown))), ends),
    )
    failed = z3.And(busy, step.now((*BLOCK, "ERROR")), step.now((*BLOCK, "ERRORID")) == 0x8020)
    alarm = [
        step.now((*BLOCK, pin)) == step.was((*ROBOT, "RESPONSE", place))
        for place, pin in enumerate(("ALARMGROUP", "ALARMCATEGORY"))
    ]
    yield Goal(
        f"{name}: the alarm is what was read in this scan",
        assumed,
        z3.Implies(failed, z3.And(*alarm, ends)),
    )
    out = z3.And(
        step.was((*command, "BUSY")),
        step.was((*job, "ACTIVE")),
        step.was((*job, "ARMED")),
        step.was((*job, "TICKET")) == step.was((*INNER, "COMMAND", "SERVING")),
        step.was((*job, "SEEN")) + 1 == step.was((*INNER, "SCAN")),
    )
    goes_on = step.now((*BLOCK, *counts)) == step.was((*BLOCK, *counts)) + 1
    yield Goal(
        f"{name}: it ends, or goes on to the next row, in the scan of the end status",
        assumed,
        z3.Implies(z3.And(out, ends), z3.Or(goes_on, z3.Not(step.now((*BLOCK, "BUSY"))))),
    )


def _collected(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals that a composite block shows the alarm of the inner block that failed.

    The inner block has ended abnormally in this scan. Active is TRUE only with Busy.
    """
    step = library.step(name, library.outline(name))
    machine = step.machine
    parts = [path for path, _ in inside(library, name)]
    alarm = [  # this fact is proved by property `contract` for each inner block
        claim
        for memory in (step.before, machine.snapshot())
        for path in parts
        for claim in alarms(View(machine, memory, path)).values()
    ]
    holds = agrees(library, machine, step.before, name)  # this fact is proved by property `restart`
    assumed = (*machine.assumptions, *known(machine), answers(machine), holds, *alarm)
    number = step.now((*BLOCK, "ERRORID"))
    failed = z3.And(step.was((*BLOCK, "BUSY")), number == _ENDS[ABNORMAL_END])
    pins = ("ERRORID", "ALARMGROUP", "ALARMCATEGORY")
    shown = [
        z3.And(*[step.now((*path, pin)) == step.now((*BLOCK, pin)) for pin in pins])
        for path in parts
    ]
    yield Goal(
        f"{name}: the alarm is that of a command that has ended in this scan",
        assumed,
        z3.Implies(failed, z3.Or(*shown)),
    )
    active, busy = step.now((*BLOCK, "ACTIVE")), step.now((*BLOCK, "BUSY"))
    yield Goal(f"{name}: Active only with Busy", assumed, z3.Implies(active, busy))


def _commands(library: Library) -> list[str]:
    """Return the blocks that send a remote command, except blocks with their own channel."""
    pous = {name: library.pou(name) for name in jobs_of(library) if name not in CARRIERS}
    return [
        name
        for name, pou in pous.items()
        if "ALARMGROUP" in pou.symbols and "OWN" not in pou.symbols
    ]


def _goals(library: Library, part: str) -> Iterator[Goal]:
    yield from (_write_area if part in WRITERS else _read_area)(library, part)


def _responses(library: Library, part: str) -> Iterator[Goal]:
    if part in READERS:
        yield from _read_area(library, part)
    elif part in CARRIERS:
        yield from _row(library, part)
    else:
        yield from (_collected if part == COLLECTS else _taken)(library, part)


PROPERTIES = (
    Property(
        "handshake",
        "FB_WriteArea sends the data of a command one scan before the code. It sends the code "
        "only if the status is 16#0000. Code and data then stay unchanged until one of these "
        "events: the status becomes 16#0200 or 16#4000, the link or CPU_OK is lost, the status "
        "falls back, or a continuous output is ended. Between two codes it sends 16#0000.",
        "guide chapters 1 and 2, 4.7.4",
        ("inner", "calls", "area"),
        _goals,
        lambda _: WRITERS,
        lambda part: (part,),
    ),
    Property(
        "response",
        "FB_ReadArea reads status and response in the same scan. A command block takes the "
        "response in the scan in which the end status arrives. FB_PointBackup and FB_PointRestore "
        "show the row and its alarm in that scan. FB_PickPlace shows the alarm of the command "
        "that ended in that scan, and is Active only while it is Busy. The proof does not cover "
        "blocks with Enable, and not the numbers that blocks calculate from a response.",
        "guide chapters 1 and 2",
        ("inner", "calls", "area"),
        _responses,
        lambda library: (*READERS, *_commands(library), *CARRIERS, COLLECTS),
        lambda part: (part,),
        ("restart", "contract"),
    ),
)
