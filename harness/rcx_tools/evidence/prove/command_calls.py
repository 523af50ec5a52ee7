"""A call of a command block, with access to its stored command, its request, and its pins."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.pin_telegrams import WORDS, char_code
from rcx_tools.evidence.prove.tickets.model import keeps_turn
from structured_text.language.types import ArrayType, EnumType
from structured_text.prove.reals import Real
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.texts import Text
from structured_text.prove.values import Value

__all__ = ["Call", "Held"]


@dataclass(frozen=True)
class Held:
    """The command that a block stores until it is sent, and why it may be refused."""

    busy: Any
    refused: Any
    code: Any
    data: tuple[Any, ...]

    @property
    def ready(self) -> Any:
        """Return the claim that the command may be requested."""
        return z3.And(self.busy, self.refused == 0)

    def same(self, other: Held) -> Any:
        """Return the claim that two stored commands are equal, apart from `busy`."""
        pairs = [(self.refused, other.refused), (self.code, other.code)]
        pairs += zip(self.data, other.data, strict=True)
        return z3.And([one == two for one, two in pairs])


class Call:
    """One call of a command block, either from any state with a busy job or from any other state.

    Attributes:
        block: Name of the block in upper case.
        machine: The machine with its memory after the call.
        step: The call with its memories.
    """

    def __init__(self, library: Library, block: str, *, busy: bool) -> None:
        self.block = block
        machine = library.machine()
        machine.summaries["FC_RCXCHARCODE"] = char_code
        self._pou = pou = library.pou(block)
        assert pou.block is not None
        machine.havoc(BLOCK, pou.block)
        job_busy = (*BLOCK, "JOB", "BUSY")
        machine[job_busy] = busy
        machine.havoc(ROBOT, pou.section("VAR_IN_OUT")[0].type)
        before = machine.snapshot()
        machine.call_block(BLOCK, pou.block.name, {"ROBOT": ROBOT})
        self.step = Step(machine, before, BLOCK)
        self.machine = machine

    @cached_property
    def was(self) -> Held:
        """Return the stored command before the call."""
        return self._held(self.step.before)

    @cached_property
    def now(self) -> Held:
        """Return the stored command after the call."""
        return self._held(self.machine.snapshot())

    def _held(self, memory: Mapping[Path, Value]) -> Held:
        def term(*path: Any) -> Any:
            return self.machine.term((*BLOCK, *path), memory)

        busy = term("JOB", "BUSY")
        if self.block == "FB_CONTINUOUSPOSITION":  # all its commands are legal
            data = tuple(z3.BitVecVal(int(k == 0), 16) for k in WORDS)
            return Held(busy, z3.BitVecVal(0, 16), term("CODE"), data)
        data = tuple(term("DATA", k) for k in WORDS)
        if self.block == "FB_JOG":
            return Held(busy, term("ILLEGAL"), term("CODE"), data)
        return Held(busy, term("JOB", "TROUBLE"), term("JOB", "HOLDER"), data)

    def between(self, memory: Mapping[Path, Value], unused: Iterable[int]) -> Any:
        """Return the invariant between two calls, without the claims about the stored command."""
        held = self._held(memory)
        rules = [z3.Implies(self.machine.term((*BLOCK, "JOB", "ACTIVE"), memory), held.busy)]
        rules += [held.data[k] == 0 for k in unused]
        if self.block == "FB_JOG":
            asked = (self.machine.term((*BLOCK, name), memory) for name in ("ASKED", "OUT"))
            rules.append(z3.Implies(z3.Or(*asked), held.ready))
        return z3.And(rules)

    @property
    def turn(self) -> Any:
        """Return the claim about the turn of the job that property `turn-once` has proved."""
        was, job, channel = self.step.was, (*BLOCK, "JOB"), (*ROBOT, "INNER", "COMMAND")
        own = was((*job, "TICKET")) == was((*channel, "SERVING"))
        number = was((*ROBOT, "INNER", "SCAN"))
        return keeps_turn(
            was((*job, "BUSY")), was((*job, "ACTIVE")), was((*job, "SEEN")), number, own
        )

    @property
    def requested(self) -> Any:
        """Return the claim that this call has requested nothing, or exactly the stored command."""
        inner = (*ROBOT, "INNER")
        code, asked = (*inner, "CODE"), (*inner, "CODEREQUEST")
        data = [(*inner, "DATA", k) for k in WORDS]
        step = self.step
        nothing = [step.now(path) == step.was(path) for path in (code, asked, *data)]
        held = [self.now.ready, step.now(asked), step.now(code) == self.now.code]
        held += [step.now(path) == one for path, one in zip(data, self.now.data, strict=True)]
        return z3.Or(z3.And(nothing), z3.And(held))

    @property
    def edge(self) -> Any:
        """Return the claim that Execute has a rising edge.

        The claim is always true for a block with Enable.
        """
        if self.block in ("FB_JOG", "FB_CONTINUOUSPOSITION"):
            return z3.BoolVal(True)
        return z3.And(
            self.step.was((*BLOCK, "EXECUTE")), z3.Not(self.step.was((*BLOCK, "JOB", "WASEXECUTE")))
        )

    # --- pins ---

    def pin(self, name: str, place: int = 0) -> Any:
        """Return the value of a pin at the call, or of an element of the pin: a term, or a text."""
        path: Path = (*BLOCK, name.upper())
        if isinstance(self._pou.symbols[name.upper()].type, ArrayType):
            path = (*path, place)
        value = self.step.before[path]
        if isinstance(value, Text):
            return value
        return value.value if isinstance(value, Real) else self.machine.term(path, self.step.before)

    def member(self, name: str, member: str) -> Any:
        """Return the claim that a pin equals a given member of its enumeration."""
        kind = self._pou.symbols[name.upper()].type
        assert isinstance(kind, EnumType)
        return self.pin(name) == [one.upper() for one in kind.members].index(member)
