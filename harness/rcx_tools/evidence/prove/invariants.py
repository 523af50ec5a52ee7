"""Invariants of a block between its calls: guessed from templates, and accepted if inductive.

The method is called Houdini. A wrong guess is harmless, because it fails at the start or a
counterexample to the induction step refutes it. The remaining guesses are inductive together, so a
proof may assume them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.outline import OUTLINED, is_outside
from structured_text.language.standard import BLOCKS
from structured_text.language.types import BlockType, EnumType
from structured_text.language.walk import written
from structured_text.prove.logic import UnsupportedError
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value, concrete

__all__ = [
    "ABNORMAL",
    "PINS",
    "Memory",
    "View",
    "alarms",
    "assumed",
    "at_start",
    "call",
    "exclusive",
    "invariant",
    "linked",
    "without_floats",
]

#: Pins to which the PLCopen rules apply.
PINS = ("DONE", "BUSY", "ACTIVE", "ERROR", "ERRORID", "VALID", "ALARMGROUP", "ALARMCATEGORY")
#: ErrorID of an abnormal end. The response then contains the alarm of the controller.
ABNORMAL = 0x8020

Memory = Mapping[Path, Value]


@dataclass(frozen=True)
class View:
    """Access to the pins of a block in one state of the memory, as terms."""

    machine: Machine
    memory: Memory
    path: Path = BLOCK

    def __contains__(self, pin: str) -> bool:
        return (*self.path, pin) in self.memory

    def __getitem__(self, pin: str) -> Any:
        return self.machine.term((*self.path, pin), self.memory)

    def bit(self, pin: str) -> Any:
        """Return a pin as a term; FALSE if the block does not have this pin."""
        return self[pin] if pin in self else z3.BoolVal(False)

    @property
    def shown(self) -> Any:
        """Return the claim that Busy, Done or Error is TRUE."""
        return z3.Or(self["BUSY"], self["DONE"], self["ERROR"])

    def same(self, other: View, pins: Iterable[str]) -> Any:
        """Return the claim that these pins have the same values in both views."""
        return z3.And([self[pin] == other[pin] for pin in pins])


def exclusive(view: View, pins: Iterable[str]) -> Any:
    """Return the claim that at most one of these pins is TRUE. Missing pins are ignored."""
    there = [view[pin] for pin in pins if pin in view]
    return z3.And([z3.Not(z3.And(one, other)) for one, other in combinations(there, 2)])


def _instances(library: Library, block: str) -> Iterator[tuple[Path, BlockType]]:
    """Yield the block and its inner blocks, except blocks that their guarantee replaces."""
    kind = library.pou(block).block
    assert kind is not None
    yield from _inside(kind, BLOCK, library if block in OUTLINED else None)


def _inside(
    kind: BlockType, path: Path, outlined: Library | None
) -> Iterator[tuple[Path, BlockType]]:
    yield path, kind
    for variable in kind.variables:
        inner = variable.type
        if variable.section != "VAR" or not isinstance(inner, BlockType):
            continue
        if outlined is None or not is_outside(outlined.project, inner.name):
            yield from _inside(inner, (*path, variable.name.upper()), outlined)


def _guesses(
    library: Library, block: str, machine: Machine, memory: Memory, saw: Any
) -> dict[str, Any]:
    """Return candidates for the invariant, by name.

    `saw` is the value of Execute in the last call.
    """
    views = {path: View(machine, memory, path) for path, _ in _instances(library, block)}
    whole = views[BLOCK]
    guesses: dict[str, Any] = {}
    for path, view in views.items():
        told = ".".join(path)
        guesses |= {f"{told}: {name}": guess for name, guess in _of_one(view).items()}
        if path != BLOCK:
            found = _of_two(view, views[path[:-1]])
            guesses |= {f"{told} in its owner: {name}": guess for name, guess in found.items()}
            if "SEEN" in view and "BUSY" in view and "SEEN" in whole:
                guesses[f"{told}: seen in one scan"] = z3.Implies(
                    view["BUSY"], view["SEEN"] == whole["SEEN"]
                )
    if "EXECUTE" in whole:
        guesses["an Execute that was read is answered"] = z3.Implies(saw, whole.shown)
    if "ENABLE" in whole:
        guesses |= {
            f"{'.'.join(path)}: after its end an Error": z3.Implies(_over(view), whole["ERROR"])
            for path, view in views.items()
            if path != BLOCK and "ACTIVE" in view and "BUSY" in view
        }
        for symbol in library.pou(block).section("VAR"):
            if getattr(symbol.type, "name", "") == "BOOL":
                flag = whole[symbol.name.upper()]
                guesses[f"Error with {symbol.name}"] = z3.Implies(whole["ERROR"], flag)
                guesses[f"Error without {symbol.name}"] = z3.Not(z3.And(whole["ERROR"], flag))
                abnormal = whole["ERRORID"] == ABNORMAL
                guesses[f"abnormal end without {symbol.name}"] = z3.Not(z3.And(abnormal, flag))
                for path, view in views.items():
                    if path != BLOCK and "ACTIVE" in view and "BUSY" in view:
                        told = f"{symbol.name}, {'.'.join(path)}"
                        guesses[f"{told}: only if Active"] = z3.Implies(flag, view["ACTIVE"])
                        guesses[f"{told}: never Busy"] = z3.Not(z3.And(flag, view["BUSY"]))
                        guesses[f"{told}: after its end"] = z3.Implies(_over(view), flag)
    edges = [
        (path, view[pin])
        for path, view in views.items()
        for pin in ("WASEXECUTE", "seen")
        if pin in view
    ]
    for path, edge in edges:
        guesses[f"{path} has the last Execute"] = edge == saw
    for (one, first), (other, second) in combinations(edges, 2):
        if one[:-1] == other[:-1]:
            guesses[f"{one} and {other} have the same Execute"] = first == second
    return guesses


def _over(view: View) -> Any:
    """Return the claim that the work of a block has ended and Execute is still TRUE.

    The claim is FALSE if the block has no WasExecute.
    """
    return z3.And(view.bit("WASEXECUTE"), z3.Not(view["BUSY"]))


def _of_one(view: View) -> dict[str, Any]:
    """Return candidates for the invariant about a single instance."""
    guesses: dict[str, Any] = {}
    if "ERROR" in view:
        guesses["one end at most"] = exclusive(view, ("DONE", "BUSY", "VALID", "ERROR"))
        guesses["Error exactly with ErrorID"] = view["ERROR"] == (view["ERRORID"] != 0)
    if "ACTIVE" in view and "BUSY" in view:
        guesses["Active only with Busy"] = z3.Implies(view["ACTIVE"], view["BUSY"])
    for pin in ("ACTIVE", "ARMED"):
        if pin in view and "BUSY" in view:
            guesses[f"{pin} from the first call on"] = z3.Implies(view["BUSY"], view[pin])
    if "REMOTE" in view:
        guesses["never Remote"] = z3.Not(view["REMOTE"])
    if "WASEXECUTE" in view:
        guesses["Execute is answered"] = z3.Implies(view["WASEXECUTE"], view.shown)
    if all(pin in view for pin in ("FAILURE", "ERRORID", "BUSY")):
        guesses["Failure is ErrorID"] = view["FAILURE"] == view["ERRORID"]
        abnormal = view["FAILURE"] == ABNORMAL
        guesses["no abnormal end while Busy"] = z3.Not(z3.And(view["BUSY"], abnormal))
    if "BUSY" in view and "STAGE" in view:
        for stage in range(_stages(view)):
            guesses[f"not Busy in stage {stage}"] = z3.Implies(view["BUSY"], view["STAGE"] != stage)
    return guesses | alarms(view)


def alarms(now: View) -> dict[str, Any]:
    """Return the claims that the pins of the alarm are 0 except after an abnormal end."""
    return {
        f"{pin} only of an abnormal end": z3.Implies(now[pin] != 0, now["ERRORID"] == ABNORMAL)
        for pin in ("ALARMGROUP", "ALARMCATEGORY")
        if pin in now
    }


def _of_two(inner: View, outer: View) -> dict[str, Any]:
    """Return candidates for the invariant about an instance and the instance that contains it."""
    guesses = {
        f"equal {pin}": inner[pin] == outer[pin] for pin in PINS if pin in inner and pin in outer
    }
    if "BUSY" not in inner or "ERROR" not in inner or "ERROR" not in outer:
        return guesses
    busy = inner["BUSY"]
    own = View(outer.machine, outer.memory, (*outer.path, "OWN"))
    if "TICKET" in inner and "SERVING" in own:
        turn = inner["TICKET"] == own["SERVING"]
        guesses["Busy with the turn of its own channel"] = z3.Implies(busy, turn)
        guesses["its own channel has no orphan"] = z3.Not(own["ORPHAN"])
    if "BUSY" in outer:
        guesses["Busy together"] = z3.Implies(busy, outer["BUSY"])
    guesses["Busy without Error outside"] = z3.Implies(busy, z3.Not(outer["ERROR"]))
    if "BUSY" in outer:
        guesses["no Error inside Busy"] = z3.Not(z3.And(inner["ERROR"], outer["BUSY"]))
    if "STAGE" in outer:
        if "STAGE" in inner:
            guesses["in one stage"] = z3.Implies(busy, inner["STAGE"] == outer["STAGE"])
        for stage in range(_stages(outer)):
            here = outer["STAGE"] == stage
            guesses[f"Busy outside of stage {stage}"] = z3.Not(z3.And(busy, here))
            guesses[f"Done outside of stage {stage}"] = z3.Not(z3.And(inner["DONE"], here))
    return guesses


def _stages(view: View) -> int:
    kind = view.machine.type_of((*view.path, "STAGE"))
    return len(kind.members) if isinstance(kind, EnumType) else 0


def inductive(
    assumed: Iterable[Any], before: Mapping[str, Any], after: Mapping[str, Any]
) -> list[str]:
    """Return the largest inductive subset of the guesses.

    If all guesses of the result hold before a step, all of them hold after the step. If the solver
    gives no answer, the result is empty.
    """
    solver = z3.SolverFor("QF_AUFBVFP")
    solver.set("timeout", 20_000)
    solver.add(*assumed)
    holds = {name: z3.Bool(f"guess {name}") for name in before}
    solver.add(*[z3.Implies(holds[name], before[name]) for name in before])
    kept = list(before)
    # Houdini: each counterexample to the induction step refutes at least one remaining guess. All
    # refuted guesses are dropped, and the rest is tried again. Every round drops at least one
    # guess, so the loop ends. The literals `holds` switch guesses off, so that no new solver is
    # necessary.
    while kept:
        solver.push()
        solver.add(z3.Not(z3.And([after[name] for name in kept])))
        found = solver.check([holds[name] for name in kept])
        model = solver.model() if found == z3.sat else None
        solver.pop()
        if found == z3.unsat:
            return kept
        if model is None:
            return []
        kept = [n for n in kept if z3.is_true(model.eval(after[n], model_completion=True))]
    return kept


def at_start(library: Library, block: str) -> tuple[Machine, Memory]:
    """Return a machine with a block that was never called, and the memory of the machine."""
    machine = library.machine()
    pou = library.pou(block)
    assert pou.block is not None
    machine.create(BLOCK, pou.block)
    return machine, machine.snapshot()


def invariant(library: Library, block: str, step: Step, saw: Any) -> tuple[list[Any], list[Any]]:
    """Return the invariant before and after a call. The invariant also holds at the start.

    Args:
        library: The library.
        block: The block that was called.
        step: The call of the block.
        saw: Value of Execute in the previous call, as a variable of the solver.
    """
    machine, after_call = step.machine, step.machine.snapshot()
    execute = (*BLOCK, "EXECUTE")
    saw_now = machine.term(execute) if execute in machine else saw
    first, initial = at_start(library, block)
    start = _guesses(library, block, first, initial, z3.BoolVal(False))
    before = {
        name: guess
        for name, guess in _guesses(library, block, machine, step.before, saw).items()
        if z3.is_true(z3.simplify(start[name]))
    }
    after = _guesses(library, block, machine, after_call, saw_now)
    kept = inductive(assumed(step), before, after)
    return [before[name] for name in kept], [after[name] for name in kept]


def assumed(step: Step) -> tuple[Any, ...]:
    """Return the assumptions that hold before a call of any block."""
    linked_up = [linked(step.machine, step.before)] if (*ROBOT, "CONNECTED") in step.before else []
    return (*step.machine.assumptions, *linked_up)


def linked(machine: Machine, memory: Memory) -> Any:
    """Return the claim about the answer of FB_ReadArea: without CPU_OK it is an error.

    Only FB_ReadArea changes these values. Before its first call there is no answer.
    """
    placed = machine.term((*ROBOT, "INNER", "INSCAN"), memory)
    answer = machine.term((*ROBOT, "INNER", "ANSWER"), memory)
    cpu_ok = machine.term((*ROBOT, "SO", "SO01_CPUOK"), memory)
    return z3.Or(z3.Not(placed), cpu_ok, answer == 0x8001, answer == 0x8002)


def _unwritten(library: Library, block: str, machine: Machine) -> Iterator[Path]:
    """Yield the scalars of the block and its inner blocks that no statement writes."""
    for path, inner in _instances(library, block):
        if inner.name in BLOCKS:
            continue
        pou = library.pou(inner.name.upper())
        assigned = written(pou)
        for symbol in pou.section("VAR"):
            if not isinstance(symbol.type, BlockType) and symbol.name.upper() not in assigned:
                for leaf in machine.leaves(symbol.type):
                    yield (*path, symbol.name.upper(), *leaf.suffix)


def call(
    library: Library, block: str, machine: Machine | None = None, like: Memory | None = None
) -> Step:
    """Call a block once from any state, like `Library.step`.

    Variables that no call writes have their initial values.

    Args:
        library: The library.
        block: The block.
        machine: A machine to continue with. None: a new machine.
        like: A state from which inputs and connected variables are taken.
    """
    machine = machine or library.outline(block)
    pou = library.pou(block)
    assert pou.block is not None
    _, initial = at_start(library, block)
    machine.havoc(BLOCK, pou.block)
    fixed = [path for path in _unwritten(library, block, machine) if concrete(initial[path])]
    for path in fixed:
        machine[path] = initial[path]
    in_outs = {}
    for symbol in pou.section("VAR_IN_OUT"):
        in_outs[symbol.name.upper()] = (symbol.name.upper(),)
        machine.havoc((symbol.name.upper(),), symbol.type)
    inputs = {symbol.name.upper() for symbol in pou.section("VAR_INPUT")}
    for path, value in (like or {}).items():
        if path[0] != BLOCK[0] or path[1] in inputs:
            machine[path] = value
    before = machine.snapshot()
    machine.call_block(BLOCK, pou.block.name, in_outs)
    if any(machine[path] is not initial[path] for path in fixed):
        raise UnsupportedError(
            f"{block} writes a variable in a way that the analysis does not detect"
        )
    return Step(machine, before, BLOCK)


def without_floats(term: Any) -> Any:
    """Replace each floating-point result in a term by a free variable.

    A proof of the new term also proves the old term. Identical results get the same variable.
    """
    if isinstance(term, bool):
        return term
    swaps, seen, waiting = [], set(), [term]
    while waiting:
        node = waiting.pop()
        if node.get_id() in seen:
            continue
        seen.add(node.get_id())
        if not z3.is_fp(node) and any(z3.is_fp(child) for child in node.children()):
            swaps.append((node, z3.FreshConst(node.sort(), "result")))
        else:
            waiting += node.children()
    return z3.substitute(term, swaps) if swaps else term
