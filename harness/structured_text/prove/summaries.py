"""What stands for a function that counts in a long loop, so that a program can be run on terms."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import z3

from structured_text.prove.machine import Machine
from structured_text.prove.values import TIME_BITS

__all__ = ["Summaries", "literals", "one_of", "summaries"]

#: 20 days.
_LONGEST_MS = 1_728_000_000
#: More durations than these are not tried one by one.
_MOST = 32


#: What stands for functions, by upper-case names: takes the machine and the arguments.
Summaries: TypeAlias = dict[str, Callable[[Machine, list[Any]], Any]]


def summaries(milliseconds: str, *, exact: bool) -> Summaries:
    """Return what stands for a function that counts the milliseconds of a duration.

    Args:
        milliseconds: Its name; empty: there is none.
        exact: The result is exactly that of its body: for runs. Else it is anything in its range:
            for proofs.
    """
    name = milliseconds.upper()
    return {name: partial(_each_duration if exact else _any_count, name)} if name else {}


def _each_duration(name: str, machine: Machine, arguments: list[Any]) -> Any:
    """The function itself, of each literal that its argument may be; else of any duration."""
    (given,) = arguments
    tried = None if isinstance(given, int) else literals(given)
    if tried is None:
        return _body(name, machine, arguments)
    first, *rest = sorted(tried)
    result = z3.BitVecVal(_body(name, machine, [first]), 32)
    for literal in rest:
        here = z3.BitVecVal(_body(name, machine, [literal]), 32)
        result = z3.If(given == z3.BitVecVal(literal, TIME_BITS), here, result)
    return result


def _any_count(name: str, machine: Machine, arguments: list[Any]) -> Any:
    """Any number that the function can give: who names it proves that there is no other."""
    if isinstance(arguments[0], int):
        return _body(name, machine, arguments)
    result = z3.BitVec(machine.fresh("milliseconds"), 32)
    machine.assume(z3.And(result >= 0, result <= _LONGEST_MS))
    return result


def _body(name: str, machine: Machine, arguments: list[Any]) -> Any:
    summary = machine.summaries.pop(name)
    try:
        return machine.call_function(name, arguments)
    finally:
        machine.summaries[name] = summary


def literals(term: Any) -> set[int] | None:
    """The numbers that a nest of choices ends in; None if something else is among them."""
    found: set[int] = set()
    seen: set[int] = set()
    waiting = [term]
    while waiting:
        one = waiting.pop()
        if one.get_id() in seen:
            continue
        seen.add(one.get_id())
        if z3.is_bv_value(one):
            found.add(one.as_signed_long())
        elif z3.is_true(one) or z3.is_false(one):
            found.add(int(z3.is_true(one)))
        elif z3.is_app_of(one, z3.Z3_OP_ITE):
            waiting += [one.arg(1), one.arg(2)]
        else:
            return None
    return found if len(found) <= _MOST else None


def one_of(term: Any, numbers: set[int]) -> Any:
    """A term that is one of these numbers, written as a choice among them."""
    first, *rest = sorted(numbers)
    result = z3.BitVecVal(first, term.size())
    for number in rest:
        literal = z3.BitVecVal(number, term.size())
        result = z3.If(term == literal, literal, result)
    return result
