"""Proof that after a loss only a new edge starts something again (chapter 1, 5; chapter 5, 3).

The property is proved block by block. Each block has an invariant (`agrees`): the pins repeat the
state of the job, and the job remembers Execute and the number of the last scan. The goals show that
a job becomes busy only at an edge, makes requests only while busy, and ends when the link is lost.
The proof of a block with inner blocks uses facts about them that are already proved (`known`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import z3

from rcx_tools.evidence.prove.area import STOPS, accepted, at_the_start
from rcx_tools.evidence.prove.composites import inside, keeps
from rcx_tools.evidence.prove.guarantee import INNER, READERS, REQUESTS, WRITERS, between
from rcx_tools.evidence.prove.invariants import ABNORMAL, View, alarms
from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.outline import OUTLINED, Outline, Outlined
from rcx_tools.evidence.prove.property import Goal, Property
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value

__all__ = ["CARRIERS", "PROPERTIES", "agrees", "answers", "jobs_of", "known", "shows"]

Memory = Mapping[Path, Value]

_NOT_CONNECTED, _NOT_READY = 0x8001, 0x8002
#: SI(01), which needs SI(00). SI(12), SI(14) and SI(17) need SI(00) and SI(06) (chapter 5, 3.1 and
#: 3.2).
_SERVO, _MOVES = 0x0002, 0x9400
#: Path of the job in those blocks in which it is not `JOB`.
_PLACES: dict[str, Path] = {
    "FB_PROGRAMCONTINUE": ("START", "JOB"),
    "FB_PROGRAMCALL": ("CALL", "JOB"),
    "FB_PROGRAMCALLINWORDS": ("CALL", "JOB"),
}
#: Blocks that start a robot program by FB_RcxProgramCall.
_CALLERS = ("FB_PROGRAMCALL", "FB_PROGRAMCALLINWORDS")
#: Blocks that have a pin Enable instead of Execute.
_LEVELS = (
    "FB_SEQUENCECONTROL",
    "FB_JOG",
    "FB_CONTINUOUSPOSITION",
    "FB_OVERRIDE",
    "FB_TOOLPOSITION",
)
#: Blocks that send single commands by FB_RcxCommandWhile, with the path of this inner block.
_SENDERS: dict[str, Path] = {
    "FB_OVERRIDE": (*BLOCK, "COMMAND"),
    "FB_TOOLPOSITION": (*BLOCK, "READING"),
}
#: Blocks that contain other blocks. FB_PowerUp itself waits for link and CPU_OK before its first
#: request.
_COMPOSITES = ("FB_POWERUP", "FB_SERVOONFROMEMERGENCYSTOP")
#: Blocks that send one command after the other by FB_RcxPointRow.
CARRIERS = ("FB_POINTBACKUP", "FB_POINTRESTORE")
_STOPPERS = ("FB_EMERGENCYSTOP", "FB_PROGRAMSTOP")


def answers(machine: Machine, memory: Memory | None = None) -> Any:
    """Return the claim that Answer reports a lost link and a missing CPU_OK within a scan."""
    placed = machine.term((*INNER, "INSCAN"), memory)
    connected = machine.term((*ROBOT, "CONNECTED"), memory)
    ready = machine.term((*ROBOT, "SO", "SO01_CPUOK"), memory)
    answer = machine.term((*INNER, "ANSWER"), memory)
    told = z3.And(
        (answer == _NOT_CONNECTED) == z3.Not(connected),
        (answer == _NOT_READY) == z3.And(connected, z3.Not(ready)),
        z3.Implies(ready, connected),
    )
    return z3.Implies(placed, told)


def jobs_of(library: Library) -> list[str]:
    """Return the blocks with a pin Execute and a job, or with an inner block that has a job."""
    return [
        name
        for name in between(library)
        if name not in _LEVELS and {"EXECUTE", "BUSY"} <= set(library.pou(name).symbols)
    ]


def _job(name: str) -> Path:
    return (*BLOCK, *_PLACES.get(name, ("JOB",)))


def agrees(library: Library, machine: Machine, memory: Memory, name: str) -> Any:
    """Return the invariant of a block between two calls."""
    job = _job(name)
    claims = [claim for block in {BLOCK, job[:-1]} for claim in shows(machine, memory, block, job)]
    if (*BLOCK, "WASEXECUTE") in memory:
        seen = machine.term((*BLOCK, "WASEXECUTE"), memory)
        claims.append(seen == machine.term((*job, "WASEXECUTE"), memory))
    if name in _COMPOSITES:
        claims += _nested(machine, memory, name, BLOCK)
    if name in _CALLERS:
        claims += _called(machine, memory, (*BLOCK, "CALL"))
    if name in CARRIERS:
        claims += _carried(machine, memory, name)
    if name in OUTLINED:
        claims += _has_own_turn(machine, memory, BLOCK)
        claims += keeps(library, machine, memory, name)
        for path, _ in inside(library, name):
            claims += _alone(machine, memory, path)
    return z3.And(*claims)


def _alone(machine: Machine, memory: Memory, path: Path) -> Iterator[Any]:
    """Yield the invariants of an inner block that sends a single command."""
    yield from shows(machine, memory, path, (*path, "JOB"))
    active, busy, done, error = (
        machine.term((*path, pin), memory) for pin in ("ACTIVE", "BUSY", "DONE", "ERROR")
    )
    yield z3.And(z3.Implies(active, busy), z3.Not(z3.And(done, error)))


def known(machine: Machine) -> Iterator[Any]:
    """Yield facts about calls of inner blocks. The facts are proved for the inner blocks alone.

    Each fact is an implication: if the state before the call is legal, the promises of the inner
    block hold after it.
    """
    for call in machine.outlined if isinstance(machine, Outline) else ():
        if {"EXECUTE", "BUSY"} <= {path[-1] for path in call.after if path[:-1] == call.instance}:
            holds = z3.And(*_alone(machine, call.before, call.instance))
            yield z3.Implies(z3.And(call.when, holds), z3.And(*_promises(machine, call)))


def _promises(machine: Machine, call: Outlined) -> Iterator[Any]:
    """Yield the promises of a block that sends a single command.

    The promises are goals of this module and of property `contract`.
    """
    path, job = call.instance, (*call.instance, "JOB")

    def was(*place: Any) -> Any:
        return machine.term(place, call.before)

    def now(*place: Any) -> Any:
        return machine.term(place, call.after)

    yield from _alone(machine, call.after, path)
    asks, busy, began = _asks_of(was, now), now(*path, "BUSY"), was(*path, "BUSY")
    execute, seen = now(*path, "EXECUTE"), was(*job, "WASEXECUTE")
    yield now(*job, "WASEXECUTE") == execute
    yield z3.Implies(busy, now(*job, "SEEN") == now(*INNER, "SCAN"))
    yield z3.Implies(z3.And(busy, z3.Not(began)), z3.And(execute, z3.Not(seen)))
    yield z3.Implies(asks, busy)
    ready = was(*ROBOT, "SO", "SO01_CPUOK")
    connected = was(*ROBOT, "CONNECTED")
    skipped = was(*INNER, "SCAN") != was(*job, "SEEN") + 1
    ends = z3.And(z3.Not(busy), now(*path, "ERROR"), z3.Not(asks))
    lost = z3.Or(z3.Not(connected), z3.Not(ready), skipped)
    yield z3.Implies(z3.And(began, lost), ends)
    yield z3.Implies(z3.Not(connected), z3.Not(asks))
    yield z3.Implies(z3.Not(was(*INNER, "INSCAN")), z3.Not(busy))  # property `contract`
    shown = z3.Or(busy, now(*path, "DONE"), now(*path, "ERROR"))
    yield z3.Implies(z3.And(z3.Not(began), z3.Not(execute)), z3.Not(shown))
    yield z3.Implies(began, shown)


#: The stages of composite blocks in their order, each with the inner block that works in the stage.
_CHARTS: dict[str, dict[str, str]] = {
    "FB_SERVOONFROMEMERGENCYSTOP": {
        "EMERGENCY_RELEASE": "",
        "ALARM_RESET": "RESET",
        "MP_READY": "",
        "SERVO_ON": "SERVO",
    },
    "FB_POWERUP": {
        "CONNECTION": "",
        "CPU_OK": "",
        "CELL_SAFE": "",
        "EMERGENCY_RELEASE": "SERVOON",
        "ALARM_RESET": "SERVOON",
        "MP_READY": "SERVOON",
        "SERVO_ON": "SERVOON",
        "STOP_RELEASE": "",
        "AUTO_MODE": "",
        "PROGRAM_RESET": "RESET",
        "PROGRAM_START": "START",
    },
}


def _stage(machine: Machine, memory: Memory, at: Path, names: Iterable[str]) -> Any:
    """Return the claim that the stage of a block is one of these members of RCX_POWER_UP."""
    kind = machine.type_of((*at, "STAGE"))
    members = [member.upper() for member in getattr(kind, "members", ())]
    stage = machine.term((*at, "STAGE"), memory)
    return z3.Or(*[stage == members.index(f"POWER_UP_{name}") for name in names])


def _has_own_turn(machine: Machine, memory: Memory, at: Path) -> Iterator[Any]:
    """Yield the claims that a composite block has its own channel, and its turn while busy."""

    def get(*path: Any) -> Any:
        return machine.term((*at, *path), memory)

    yield z3.Implies(get("BUSY"), get("SEEN") == get("JOB", "SEEN"))
    turn = z3.And(
        get("JOB", "ACTIVE"),
        get("JOB", "ARMED"),
        get("JOB", "TICKET") == get("OWN", "SERVING"),
        get("OWN", "NEXTTICKET") == get("OWN", "SERVING") + 1,
    )
    yield z3.Implies(get("BUSY"), turn)
    yield z3.Not(get("OWN", "ORPHAN"))


def _called(machine: Machine, memory: Memory, at: Path) -> Iterator[Any]:
    """Yield the claims about FB_RcxProgramCall.

    FB_RcxProgramCall has its own turn. It remembers scan and Execute of its job. Its Failure is 0
    or an ErrorID.
    """

    def get(*path: Any) -> Any:
        return machine.term((*at, *path), memory)

    yield from _has_own_turn(machine, memory, at)
    yield get("SEEN") == get("JOB", "SEEN")
    yield get("EDGE", "seen") == get("JOB", "WASEXECUTE")
    yield z3.Or(get("FAILURE") == 0, z3.Extract(15, 15, get("FAILURE")) == 1)


def _carried(machine: Machine, memory: Memory, name: str) -> Iterator[Any]:
    """Yield the claims about a block that sends one command after the other.

    A command is busy only while rows remain. No command shows an end.
    """

    def get(*path: Any) -> Any:
        return machine.term((*BLOCK, *path), memory)

    yield from _has_own_turn(machine, memory, BLOCK)
    yield get("SEEN") == get("JOB", "SEEN")
    command = (*BLOCK, "ONE", "COMMAND")
    yield from shows(machine, memory, command, (*command, "JOB"))
    sends, busy = get("ONE", "COMMAND", "BUSY"), get("BUSY")
    yield sends == get("ONE", "COMMAND", "JOB", "WASEXECUTE")
    yield z3.Not(z3.Or(get("ONE", "COMMAND", "DONE"), get("ONE", "COMMAND", "ERROR")))
    yield z3.And(z3.Not(get("ONE", "DONE")), get("ONE", "ERRORID") == 0)
    yield from alarms(View(machine, memory, command)).values()
    if name == "FB_POINTRESTORE":
        rows = z3.Not(z3.Or(get("CHECKS"), get("THROUGH")))
        yield z3.Implies(busy, z3.Not(get("THROUGH")))
    else:
        rows = get("HEAD", "COUNT") < get("WANTED")
    seen = get("ONE", "COMMAND", "JOB", "SEEN") == get("SEEN")
    yield z3.Implies(sends, z3.And(busy, rows, get("FAILURE") == 0, seen))
    yield z3.Implies(busy, get("FAILURE") != ABNORMAL)
    yield get("ONE", "COMMAND", "REFUSED") != ABNORMAL
    for number in (get("FAILURE"), get("ONE", "COMMAND", "REFUSED")):
        yield z3.Or(number == 0, z3.Extract(15, 15, number) == 1)


def _nested(machine: Machine, memory: Memory, name: str, at: Path) -> Iterator[Any]:
    """Yield the claims that only the inner block of the current stage is busy."""

    def get(*path: Any) -> Any:
        return machine.term((*at, *path), memory)

    busy, chart = get("BUSY"), _CHARTS[name]
    yield from _has_own_turn(machine, memory, at)
    yield get("SEEN") == get("JOB", "SEEN")
    yield get("EDGE", "seen") == get("JOB", "WASEXECUTE")
    yield z3.Implies(busy, _stage(machine, memory, at, chart))
    for block in dict.fromkeys(filter(None, chart.values())):
        own = [stage for stage, worker in chart.items() if worker == block]
        stages = list(chart)
        earlier = stages[: stages.index(own[0])]
        yield from shows(machine, memory, (*at, block), (*at, block, "JOB"))
        number = get(block, "ERRORID")
        yield z3.Or(number == 0, z3.Extract(15, 15, number) == 1)
        works = z3.And(busy, _stage(machine, memory, at, own))
        begun, seen = get(block, "BUSY"), get(block, "JOB", "WASEXECUTE")
        yield works == begun
        yield z3.Implies(works, z3.And(seen, get(block, "JOB", "SEEN") == get("SEEN")))
        yield z3.Implies(z3.And(busy, _stage(machine, memory, at, earlier)), z3.Not(seen))
    if name == "FB_POWERUP":
        yield from _nested(machine, memory, "FB_SERVOONFROMEMERGENCYSTOP", (*at, "SERVOON"))
        yield z3.Implies(get("SERVOON", "BUSY"), get("STAGE") == get("SERVOON", "STAGE"))


def shows(machine: Machine, memory: Memory, block: Path, job: Path) -> Iterator[Any]:
    """Yield the claims that the pins of a block repeat the outputs of its job.

    After a detected edge, one of Busy, Done and Error is TRUE.
    """
    pins = ("BUSY", "DONE", "ERROR", "ERRORID")
    shown, inner = ([machine.term((*path, pin), memory) for pin in pins] for path in (block, job))
    yield from (one == other for one, other in zip(shown, inner, strict=True))
    busy, done, error, number = inner
    yield z3.Implies(machine.term((*job, "WASEXECUTE"), memory), z3.Or(busy, done, error))
    yield error == (number != 0)
    yield z3.Not(z3.And(busy, z3.Or(done, error)))


def _asks(step: Step) -> Any:
    """Return the claim that this call makes a request."""
    return _asks_of(lambda *path: step.was(path), lambda *path: step.now(path))


def _asks_of(was: Callable[..., Any], now: Callable[..., Any]) -> Any:
    inputs = now(*INNER, "REQUEST") & ~was(*INNER, "REQUEST")
    command = z3.And(now(*INNER, "CODEREQUEST"), z3.Not(was(*INNER, "CODEREQUEST")))
    return z3.Or(inputs != 0, command)


def _jobs(library: Library, name: str) -> Iterator[Goal]:
    start = at_the_start(library, name)
    yield Goal(
        f"{name}: the invariant holds at the start",
        (),
        agrees(library, start, start.snapshot(), name),
    )
    step = library.step(name, library.outline(name))
    machine, after = step.machine, step.machine.snapshot()
    assumed = (
        *machine.assumptions,
        *known(machine),
        answers(machine),
        agrees(library, machine, step.before, name),
    )
    was, now = step.was((*BLOCK, "BUSY")), step.now((*BLOCK, "BUSY"))
    job = _job(name)
    execute, seen = step.now((*BLOCK, "EXECUTE")), step.was((*job, "WASEXECUTE"))
    yield Goal(f"{name}: the invariant holds again", assumed, agrees(library, machine, after, name))
    yield Goal(
        f"{name}: it stores Execute of the last call",
        assumed,
        step.now((*job, "WASEXECUTE")) == execute,
    )
    begins = z3.And(now, z3.Not(was))
    edge = z3.And(execute, z3.Not(seen))
    scan = z3.Implies(now, step.now((*job, "SEEN")) == step.now((*INNER, "SCAN")))
    yield Goal(f"{name}: it stores the scan of the last call", assumed, scan)
    yield Goal(f"{name}: it becomes busy only by an edge", assumed, z3.Implies(begins, edge))
    asks = _asks(step)
    yield Goal(f"{name}: it makes requests only while busy", assumed, z3.Implies(asks, now))
    ends = z3.And(z3.Not(now), step.now((*BLOCK, "ERROR")), z3.Not(asks))
    if name in OUTLINED:  # the block may end with Done after the last row
        ends = z3.And(z3.Not(now), z3.Not(asks))
    connected = step.was((*ROBOT, "CONNECTED"))
    waits = z3.BoolVal(False)
    if name == "FB_POWERUP":
        waits = _stage(machine, step.before, BLOCK, ("CONNECTION",))
    lost = z3.And(was, z3.Not(connected), z3.Not(waits))
    yield Goal(f"{name}: a lost link ends it", assumed, z3.Implies(lost, ends))
    yield Goal(
        f"{name}: it makes no request without a link",
        assumed,
        z3.Implies(z3.Not(connected), z3.Not(asks)),
    )
    skipped = z3.And(was, step.was((*INNER, "SCAN")) != step.was((*job, "SEEN")) + 1)
    yield Goal(f"{name}: a scan without a call ends it", assumed, z3.Implies(skipped, ends))
    if name not in _COMPOSITES:
        yield from _troubles(step, name, assumed, ends)


def _troubles(step: Step, name: str, assumed: tuple[Any, ...], ends: Any) -> Iterator[Goal]:
    """Yield the goals for a controller that is not ready.

    Without link or CPU_OK a block ends and makes no request.
    """
    ready = step.was((*ROBOT, "SO", "SO01_CPUOK"))
    was, job = step.was((*BLOCK, "BUSY")), _job(name)
    if name not in REQUESTS and name not in _STOPPERS:
        lost = z3.And(was, z3.Not(ready))
        yield Goal(f"{name}: a lost CPU_OK ends it", assumed, z3.Implies(lost, ends))
        return
    new = step.now((*INNER, "REQUEST")) & ~step.was((*INNER, "REQUEST"))
    fresh = new & ~_applied(step)
    safe = z3.And(
        z3.Not(step.was((*ROBOT, "SO", "SO00_EMERGENCYSTOP"))),
        step.was((*ROBOT, "EMERGENCYSTOPOK")),
        ready,
    )
    starts = REQUESTS.get(name, 0) & (_SERVO | _MOVES)
    if starts:
        claim = z3.Implies(fresh & starts != 0, safe)
        if starts & _MOVES:
            claim = z3.Implies(fresh & starts != 0, z3.And(safe, step.was((*ROBOT, "STOPOK"))))
        yield Goal(f"{name}: no start in an emergency stop", assumed, claim)
        out = z3.And(
            was,
            step.was((*job, "ACTIVE")),
            step.was((*job, "ARMED")),
            _on_wire(step, name),
            z3.Not(safe),
        )
        yield Goal(
            f"{name}: an emergency stop ends a running command", assumed, z3.Implies(out, ends)
        )


#: Maps a bit position in bytes n + 32 and n + 33 to the variable in RCX_REF.SI (chapter 5, 1).
_SI = {
    0: "SI00_EMERGENCYSTOP",
    1: "SI01_SERVOON",
    6: "SI06_STOP",
    8: "SI10_SEQUENCECONTROL",
    10: "SI12_AUTOSTART",
    12: "SI14_RETURNTOORIGININCR",
    13: "SI15_PROGRAMRESET",
    14: "SI16_ALARMRESET",
    15: "SI17_RETURNTOORIGINABS",
}


def _applied(step: Step, now: bool = False) -> Any:
    """Return RCX_REF.SI as the bytes n + 32 and n + 33."""
    value = z3.BitVecVal(0, 16)
    for bit, name in _SI.items():
        flag = (step.now if now else step.was)((*ROBOT, "SI", name))
        value |= z3.If(flag, z3.BitVecVal(1 << bit, 16), z3.BitVecVal(0, 16))
    return value


def _on_wire(step: Step, name: str) -> Any:
    """Return the claim that the dedicated input of a block is ON.

    FB_ReturnToOrigin has two inputs; the claim is about the chosen input.
    """
    own = z3.BitVecVal(REQUESTS[name], 16)
    if name == "FB_RETURNTOORIGIN":
        chosen = step.was((*BLOCK, "CHOSEN")) == 1
        own = z3.If(chosen, z3.BitVecVal(1 << 15, 16), z3.BitVecVal(1 << 12, 16))
    return _applied(step) & own != 0


def _levels(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals of a block with Enable.

    An error stays until Enable is FALSE. During an error the block requests nothing.
    """
    step = library.step(name)
    machine = step.machine
    assumed = [*machine.assumptions, answers(machine)]
    enable, asks = step.now((*BLOCK, "ENABLE")), _asks(step)
    failed, fails = step.was((*BLOCK, "ERRORID")) != 0, step.now((*BLOCK, "ERRORID")) != 0
    works = z3.BoolVal(True)
    if name != "FB_SEQUENCECONTROL":
        holds = _sender if name in _SENDERS else _failure
        assumed.append(holds(machine, step.before, name))
        start = at_the_start(library, name)
        yield Goal(
            f"{name}: the invariant holds at the start", (), holds(start, start.snapshot(), name)
        )
        kept = holds(machine, machine.snapshot(), name)
        yield Goal(f"{name}: the invariant holds again", tuple(assumed), kept)
        if name not in _SENDERS:
            works = step.was((*BLOCK, "JOB", "BUSY"))
    may = held = z3.BoolVal(False)  # the code is already sent: a jog stops, others go on
    if name == "FB_JOG":
        may = step.was((*BLOCK, "OUT"))
    if name in _SENDERS:
        may = held = z3.And(*[step.was((*_SENDERS[name], pin)) for pin in ("BUSY", "OUT")])
    lost = z3.Not(step.was((*ROBOT, "SO", "SO01_CPUOK")))
    yield Goal(
        f"{name}: an error stays until Enable is FALSE",
        tuple(assumed),
        z3.Implies(z3.And(enable, failed), z3.And(fails, z3.Implies(asks, held))),
    )
    yield Goal(
        f"{name}: a lost link or CPU_OK is an error",
        tuple(assumed),
        z3.Implies(z3.And(enable, works, lost), z3.And(fails, z3.Not(asks))),
    )
    yield Goal(
        f"{name}: no request without Enable", tuple(assumed), z3.Implies(asks, z3.Or(enable, may))
    )
    yield Goal(f"{name}: no request without a link", tuple(assumed), z3.Implies(asks, z3.Not(lost)))


def _sender(machine: Machine, memory: Memory, name: str) -> Any:
    """Return the claim that ErrorID is the failure.

    No command waits after a failure, or while Enable is FALSE.
    """
    command = _SENDERS[name]

    def get(*path: Any) -> Any:
        return machine.term((*command, *path), memory)

    failure = machine.term((*BLOCK, "FAILURE"), memory)
    off = z3.Or(failure != 0, z3.Not(machine.term((*BLOCK, "WASENABLE"), memory)))
    return z3.And(
        machine.term((*BLOCK, "ERRORID"), memory) == failure,
        *[get(pin) == get("JOB", pin) for pin in ("BUSY", "ACTIVE", "ERROR", "ERRORID")],
        get("ERROR") == (get("ERRORID") != 0),
        z3.Not(z3.And(get("BUSY"), get("ERROR"))),
        z3.Implies(z3.And(off, get("BUSY")), get("OUT")),
    )


def _failure(machine: Machine, memory: Memory, _: str) -> Any:
    """Return the claim that ErrorID is the failure.

    After a failure no job is busy, and a jog is locked.
    """
    shown = machine.term((*BLOCK, "ERRORID"), memory)
    failure = machine.term((*BLOCK, "FAILURE"), memory)
    idle = z3.Not(machine.term((*BLOCK, "JOB", "BUSY"), memory))
    if (*BLOCK, "LOCKED") in memory:
        idle = z3.And(idle, machine.term((*BLOCK, "LOCKED"), memory))
    return z3.And(shown == failure, z3.Implies(failure != 0, idle))


def _write_area(library: Library, name: str) -> Iterator[Goal]:
    step = library.step(name)
    assumed = tuple(step.machine.assumptions)
    was, now = step.was((*INNER, "APPLIED")), step.now((*INNER, "APPLIED"))
    rises = now & ~was & ~z3.BitVecVal(STOPS, 16)
    connected = step.was((*ROBOT, "CONNECTED"))
    request = step.was((*INNER, "REQUEST"))
    yield Goal(
        f"{name}: an input goes ON only if requested in this scan, with a link",
        assumed,
        z3.Implies(rises != 0, z3.And(rises & ~request == 0, connected, accepted(step))),
    )
    yield Goal(
        f"{name}: SI(01), SI(12), SI(14), SI(17) rise with SI(00) ON, the last three with SI(06)",
        assumed,
        z3.And(
            z3.Implies(rises & (_SERVO | _MOVES) != 0, z3.Extract(0, 0, was) == 1),
            z3.Implies(rises & _MOVES != 0, z3.Extract(6, 6, was) == 1),
        ),
    )
    nothing = z3.And(step.now((*INNER, "REQUEST")) == 0, z3.Not(step.now((*INNER, "CODEREQUEST"))))
    yield Goal(f"{name}: requests end with the scan", assumed, z3.Implies(accepted(step), nothing))
    code = (*BLOCK, "MAKEHEAD", "CODE")
    goes = z3.And(step.was(code) == 0, step.now(code) != 0)
    ready = z3.And(connected, step.was((*ROBOT, "SO", "SO01_CPUOK")))
    asked = step.was((*INNER, "CODEREQUEST"))
    runs = step.was((*INNER, "PHASE")) == 3
    yield Goal(
        f"{name}: a code is sent only if requested in this scan, with link and CPU_OK",
        (*assumed, z3.Implies(runs, step.was(code) == step.was((*INNER, "CODE")))),
        z3.Implies(goes, z3.And(asked, ready, accepted(step))),
    )
    yield Goal(
        f"{name}: RCX_REF.SI shows the applied inputs",
        assumed,
        z3.Implies(accepted(step), _applied(step, now=True) == now & _applied_mask()),
    )
    kept = [(*ROBOT, "CONNECTED"), (*ROBOT, "SO", "SO01_CPUOK"), (*INNER, "ANSWER")]
    yield Goal(
        f"{name}: it does not change the values of FB_ReadArea",
        assumed,
        z3.And(*[step.was(path) == step.now(path) for path in kept]),
    )


def _applied_mask() -> Any:
    return z3.BitVecVal(sum(1 << bit for bit in _SI), 16)


def _read_area(library: Library, name: str) -> Iterator[Goal]:
    step = library.step(name)
    machine = step.machine
    first = z3.Not(step.was((*INNER, "INSCAN")))
    yield Goal(
        f"{name}: all blocks receive a lost link or CPU_OK",
        (*machine.assumptions, z3.Or(first, answers(machine, step.before))),
        answers(machine),
    )
    yield Goal(
        f"{name}: no link while Connected is FALSE",
        tuple(machine.assumptions),
        z3.Implies(
            z3.Not(step.now((*BLOCK, "CONNECTED"))), z3.Not(step.now((*ROBOT, "CONNECTED")))
        ),
    )


def _goals(library: Library, part: str) -> Iterator[Goal]:
    if part in WRITERS:
        yield from _write_area(library, part)
    elif part in READERS:
        yield from _read_area(library, part)
    elif part in _LEVELS:
        yield from _levels(library, part)
    else:
        yield from _jobs(library, part)


PROPERTIES = (
    Property(
        "restart",
        "After a loss of the link, no dedicated input except SI(00) and SI(06) goes ON and no "
        "command is sent until Execute or Enable has a new rising edge. The same holds for "
        "commands after a loss of CPU_OK. In an emergency stop, no servo ON, program start or "
        "return-to-origin begins, and one that is running ends. FB_Operator has keys instead of "
        "Execute. The proof covers the blocks that the keys start, but not the keys.",
        "chapter 1, 5; chapter 5, 3",
        ("inner", "calls"),
        _goals,
        lambda library: (*WRITERS, *READERS, *_LEVELS, *jobs_of(library)),
        lambda part: (part,),
        ("contract", "guarantee"),
    ),
)
