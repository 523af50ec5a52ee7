"""The machine that runs a user's program: it tells his own calls from those inside the library."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from itertools import combinations
from typing import Any

import z3

from structured_text.engines.builtin.storage import is_scalar
from structured_text.language.project import Project
from structured_text.language.standard import BLOCKS
from structured_text.prove import values
from structured_text.prove.logic import Bool, UnsupportedError, both
from structured_text.prove.machine import Alternatives, Call, Machine, Path
from structured_text.prove.summaries import summaries

__all__ = ["ProgramMachine"]


class ProgramMachine(Machine):
    """A machine for a whole program.

    Args:
        project: The sources.
        library: The files of the library.
        exact: For runs: nothing is taken for more than it is. Else for proofs.
        outline: A block or function of the library may do anything to what it is connected to,
            as long as its outputs keep the contract.
        milliseconds: A function of the library that counts those of a duration in a long loop.

    Attributes:
        own: The calls of blocks of the library in the user's own code; `calls` are all.
        until: When it is given up (`time.monotonic`).
    """

    def __init__(
        self,
        project: Project,
        library: frozenset[str] = frozenset(),
        *,
        exact: bool = True,
        outline: bool = False,
        milliseconds: str = "",
    ) -> None:
        super().__init__(project, summaries(milliseconds, exact=exact))
        self._library, self._outline = library, outline
        self.own: list[Call] = []
        self.until = math.inf

    def possible(self, condition: Bool) -> bool:
        """Whether a condition can hold here, in a state that may be anything.

        A new solver each time is far faster on terms as large as these.
        """
        if isinstance(condition, bool):
            return condition
        if time.monotonic() > self.until:
            raise UnsupportedError("it takes longer than the limit")
        solver = z3.SolverFor("QF_AUFBVFP")
        solver.set("timeout", 2000)
        solver.add(*[guard for guard in self._guards if guard is not True], condition)
        return bool(solver.check() != z3.unsat)

    def call_block(
        self, instance: Path, block: str, in_outs: Mapping[str, Path | Alternatives]
    ) -> None:
        """Run a block, or let it do anything."""
        if block in BLOCKS or self.project.pous[block.upper()].file not in self._library:
            super().call_block(instance, block, in_outs)
            return
        if self.frame.pou.file not in self._library:
            self.own.append(Call(instance, block, both(*self._guards)))
        if not self._outline:
            super().call_block(instance, block, in_outs)
            return
        pou = self.project.pous[block.upper()]
        assert pou.block is not None
        self.havoc(instance, pou.block)
        self._keep_contract(instance)
        for symbol in pou.section("VAR_IN_OUT"):
            places = in_outs[symbol.name.upper()]
            for _, path in places if isinstance(places, list) else [(True, places)]:
                self.havoc(path, symbol.type)

    def _keep_contract(self, instance: Path) -> None:
        """Done, Busy and Error exclude each other; ErrorID goes with Error."""
        pins = [(*instance, name) for name in ("DONE", "BUSY", "ERROR")]
        flags = [self[pin] for pin in pins if pin in self and z3.is_bool(self[pin])]
        for one, other in combinations(flags, 2):
            self.assume(z3.Not(z3.And(one, other)))
        code, error = (*instance, "ERRORID"), (*instance, "ERROR")
        if code in self and error in self:
            self.assume(self[error] == (self.term(code) != 0))

    def call_function(self, name: str, arguments: list[Any]) -> Any:
        """Run a function, or let it give anything."""
        pou = self.project.pous[name]
        outside = self._outline and pou.file in self._library and pou.result is not None
        if not outside or not is_scalar(pou.result.type):  # type: ignore[union-attr]
            return super().call_function(name, arguments)
        assert pou.result is not None
        result = values.anything(pou.result.type, self.fresh(name))
        self.assume(values.legal(pou.result.type, result))
        return result
