"""The machine that runs a whole program of a user symbolically.

It distinguishes calls of library blocks in the user's own code from calls inside the library.
"""

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
from structured_text.prove.machine import Call, Machine
from structured_text.prove.summaries import summaries
from structured_text.prove.symbolic_memory import Alternatives, Path

__all__ = ["ProgramMachine"]


class ProgramMachine(Machine):
    """A symbolic machine for a whole program.

    `Search` uses it with exact semantics; the induction step of `user` uses it for proofs.

    Args:
        project: The sources.
        library: The files of the library.
        exact: If True, functions give exactly the result of their body (for runs). If False, a
            summarized function may give any result in its range (for proofs).
        outline: Whether a block or function of the library may write anything to its VAR_IN_OUT
            variables and outputs. Only the rules for Done, Busy, Error and ErrorID are assumed.
        milliseconds: The name of a library function that counts the milliseconds of a duration in a
            long loop.

    Attributes:
        own: The calls of library blocks in the user's own code; `calls` holds all calls.
        until: The time (`time.monotonic`) at which the machine gives up.
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
        """Return whether a condition can hold at this point; True if the solver does not decide it.

        The check uses a new solver each time. For terms as large as those of a program, a new
        solver is far faster than an incremental one. Raise UnsupportedError if `until` has passed.
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
        """Run a block, or replace the call by arbitrary results (`outline`).

        In outline mode the body of a library block is not run. All variables of the instance and
        its VAR_IN_OUT variables get arbitrary values; only the contract of the outputs is assumed.
        A property that holds for arbitrary results holds for the results of the body as well.
        """
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
        """Assume the contract of a block's outputs.

        At most one of Done, Busy and Error is TRUE. Error is TRUE if and only if ErrorID is not 0.
        """
        pins = [(*instance, name) for name in ("DONE", "BUSY", "ERROR")]
        flags = [self[pin] for pin in pins if pin in self and z3.is_bool(self[pin])]
        for one, other in combinations(flags, 2):
            self.assume(z3.Not(z3.And(one, other)))
        code, error = (*instance, "ERRORID"), (*instance, "ERROR")
        if code in self and error in self:
            self.assume(self[error] == (self.term(code) != 0))

    def call_function(self, name: str, arguments: list[Any]) -> Any:
        """Run a function.

        In outline mode, a library function returns any legal value.
        """
        pou = self.project.pous[name]
        outside = self._outline and pou.file in self._library and pou.result is not None
        if not outside or not is_scalar(pou.result.type):  # type: ignore[union-attr]
            return super().call_function(name, arguments)
        assert pou.result is not None
        result = values.anything(pou.result.type, self.fresh(name))
        self.assume(values.legal(pou.result.type, result))
        return result
