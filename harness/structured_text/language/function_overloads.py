"""Functions of one name for several types of arguments, as SIMATIC AX has them.

Each further function of a name is registered under a generated name. The types of the arguments of
a call choose the function.
"""

from __future__ import annotations

from collections.abc import Iterable

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.checking import Checking
from structured_text.language.resolve import fills
from structured_text.language.scalars import ANY_INT, ANY_NUM, ANY_STRING
from structured_text.language.types import Type, type_name
from structured_text.language.widening import widens

__all__ = ["chosen_function"]

_EXACT, _WIDER, _NUMBER = 3, 2, 1


def chosen_function(
    callee: s.Name, arguments: Iterable[s.Argument], expressions: Checking
) -> s.Name:
    """Return the name of the function that fits the arguments best.

    If no function fits, return the name in the call.
    """
    scope = expressions.scope
    keys = scope.registry.overloads.get(callee.key)
    if not keys:
        return callee
    given = list(arguments)
    pous = [one for key in keys if (one := scope.declarations.pous.get(key)) is not None]
    rated = [(_fit(one, given, expressions), one) for one in pous]
    best = max((points for points, _ in rated), default=0)
    if best <= 0:
        return callee
    found = next(one for points, one in rated if points == best)
    return s.Name(found.name, callee.at)


def _fit(pou: t.Pou, arguments: list[s.Argument], expressions: Checking) -> int:
    """Return how well the arguments fit the pins of a function; 0 if they do not."""
    pins = [one for one in pou.symbols.values() if one.section in ("VAR_INPUT", "VAR_IN_OUT")]
    by_name = {one.name.upper(): one for one in pou.symbols.values()}
    total, number = 0, 0
    for argument in arguments:
        if argument.name is not None:
            pin = by_name.get(argument.name.key)
        else:
            pin = pins[number] if number < len(pins) else None
            number += 1
        if pin is None:
            return 0
        if argument.output:
            have = expressions.infer(argument.value)
            points = (
                _EXACT
                if have == pin.type
                else _WIDER * (have is not None and widens(pin.type, have))
            )
        else:
            points = _points(argument.value, pin.type, expressions)
        if not points:
            return 0
        total += points
    # If several functions take the arguments, the one with fewer unused inputs is chosen.
    return total * 100 - (len(pins) - len(arguments)) if total else 0


def _points(value: s.Expression, want: Type, expressions: Checking) -> int:
    have = expressions.infer(value)
    name = type_name(want)
    if have is None:
        real = expressions.is_real(value)
        allowed = name in ANY_NUM and (not real or name not in ANY_INT)
        return _NUMBER if allowed else 0
    if have == want or fills(have, want):
        return _EXACT
    if type_name(have) == name and name in ANY_STRING:
        return _EXACT
    if expressions.scope.declarations.objects.is_a(have, want):
        return _WIDER
    return _WIDER if widens(have, want) else 0
