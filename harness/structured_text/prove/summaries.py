"""Summaries for functions that count in a long loop, so that a program can be run on terms.

Without a summary, such a loop would be unrolled into one round per millisecond.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import z3

from structured_text.prove.machine import Machine
from structured_text.prove.values import TIME_BITS

__all__ = ["Summaries", "literals", "one_of", "summaries"]

#: Largest number of milliseconds that a summarized function may count: 20 days.
_LONGEST_MS = 1_728_000_000
#: Greatest number of durations for which the function is run one by one.
_MOST = 32


#: Replacements for functions by upper-case name; each takes the machine and the arguments.
Summaries: TypeAlias = dict[str, Callable[[Machine, list[Any]], Any]]


def summaries(milliseconds: str, *, exact: bool) -> Summaries:
    """Return the summary of a function that counts the milliseconds of a duration.

    If `exact`, the summary gives the result of the function's body, as runs need it. Otherwise it
    gives any number in the range of the function, as proofs need it. Without a name there is no
    summary.
    """
    name = milliseconds.upper()
    return {name: partial(_each_duration if exact else _any_count, name)} if name else {}


def _each_duration(name: str, machine: Machine, arguments: list[Any]) -> Any:
    """Run the function for each literal that its argument may be, and return a choice among them.

    If the argument is not a choice among few literals, run the body itself.
    """
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
    """Return any number in the range of the function.

    The library with the function must prove this range.
    """
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
    """Return the literals at the leaves of a nest of choices, or None.

    The result is None if a leaf is not a literal, or if there are more than `_MOST`.
    """
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
    """Return `term` rewritten as a choice among the numbers that it can have as its value."""
    first, *rest = sorted(numbers)
    result = z3.BitVecVal(first, term.size())
    for number in rest:
        literal = z3.BitVecVal(number, term.size())
        result = z3.If(term == literal, literal, result)
    return result
