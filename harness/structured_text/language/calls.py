"""Assigns the arguments of a call to the pins of the function or block."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.declare import Scope
from structured_text.language.standard import Signature, pin_name
from structured_text.language.types import ArrayType, BlockType, ElementaryType, EnumType, Variable

__all__ = [
    "ENABLING",
    "are_named",
    "block_arguments",
    "enabling",
    "function_arguments",
    "pin_of",
    "refuse_enabling",
    "standard_arguments",
]


def function_arguments(
    node: s.Call, pou: t.Pou, scope: Scope
) -> tuple[dict[str, s.Argument], dict[str, s.Argument]]:
    """Return the arguments in a call of a user's function, by the name of their pin.

    Returns:
        The arguments of VAR_INPUT and VAR_IN_OUT by upper-case name, and the targets of outputs by
        declared name.

    Raises:
        InputError: The arguments do not fit.
    """
    node = without_true(node, pou.symbols)
    refuse_enabling(node, pou.symbols, scope)
    pins = [one for one in pou.symbols.values() if one.section in ("VAR_INPUT", "VAR_IN_OUT")]
    given: dict[str, s.Argument] = {}
    sent: dict[str, s.Argument] = {}
    outputs = {one.name.upper(): one for one in pou.section("VAR_OUTPUT")}
    every = [*pins, *outputs.values()]
    unnamed = [one for one in node.arguments if one.name is None]
    are_named(node, scope)
    # matiec accepts a call without arguments. A single `EN := TRUE` has already been removed from
    # the call.
    empty = pins and not node.arguments and scope.registry.dialect.name != "openplc"
    if len(unnamed) > len(every) or empty:
        message = f"{pou.name} takes {len(pins)} arguments, not {len(node.arguments)}"
        raise scope.error(message, node.at)
    for symbol, argument in zip(every, node.arguments, strict=False):
        if argument.name is not None:
            continue
        if symbol.section == "VAR_OUTPUT":
            sent[symbol.name] = argument
        else:
            given[symbol.name.upper()] = argument
    for argument in node.arguments:
        if argument.name is None:
            continue
        key = argument.name.key
        if argument.output and key in outputs:
            sent[outputs[key].name] = argument
            continue
        pin = next((symbol for symbol in pins if symbol.name.upper() == key), None)
        by_place = pin is not None and isinstance(pin.type, ArrayType) and pin.type.open
        if pin is None or (argument.output and not by_place):
            raise scope.error(
                f"{pou.name} has no input {key}",
                argument.at,
                f"use {', '.join(symbol.name for symbol in pins)}",
            )
        if key in given:
            raise scope.error(f"{argument.name.text} is given twice", argument.at)
        given[key] = argument
    if (unnamed or not node.arguments) and len(given) < len(pins):
        scope.note("inputs of a function left out", node.at)
    for symbol in pins:
        scalar = isinstance(symbol.type, (ElementaryType, EnumType))
        if symbol.name.upper() in given:
            continue
        if not scalar or symbol.section == "VAR_IN_OUT":
            message = f"the input {symbol.name} of {pou.name} is missing"
            raise scope.error(message, node.at)
    return given, sent


def standard_arguments(
    node: s.Call, signature: Signature, scope: Scope
) -> list[tuple[s.Argument, tuple[str, str]]]:
    """Return the arguments of a standard function in the order of the pins, each with its pin.

    A pin is a pair (name, type).

    Raises:
        InputError: The arguments do not fit.
    """
    refuse_enabling(node, (), scope)
    pins = list(signature.pins)
    if signature.extensible:
        name, kind = pins[-1]
        first = int(name[2:])
        extra = len(node.arguments) - len(pins)
        pins += [(f"IN{first + 1 + more}", kind) for more in range(extra)]
    if len(node.arguments) != len(pins):
        least = "at least " if signature.extensible else ""
        raise scope.error(
            f"{node.function.text} takes {least}{len(pins)} arguments, not {len(node.arguments)}",
            node.at,
        )
    if not are_named(node, scope):
        return list(zip(node.arguments, pins, strict=True))
    names = [name for name, _ in pins]
    pairs = zip(names, node.arguments, strict=True)
    given = {name: argument for name, argument in pairs if argument.name is None}
    for argument in node.arguments:
        if argument.name is None:
            continue
        key = argument.name.key
        if key not in names and key in _PIN_NAMES:
            scope.note("another name of a pin", argument.at, f"{key} is {_PIN_NAMES[key]}")
            key = _PIN_NAMES[key]
        if key in given:
            raise scope.error(f"{argument.name.text} is given twice", argument.at)
        given[key] = argument
    unknown = next((name for name in given if name not in names), None)
    if unknown is not None:
        text = f"{node.function.text} has no input {unknown}"
        raise scope.error(text, node.at, f"use {', '.join(names)}")
    if len(given) != len(pins) or set(given) != {name for name, _ in pins}:
        raise scope.error(
            f"{node.function.text} needs {', '.join(name for name, _ in pins)}", node.at
        )
    return [(given[name], (name, kind)) for name, kind in pins]


#: Names of the pins of text functions in CODESYS and TwinCAT.
_PIN_NAMES = {
    "STR": "IN",
    "SIZE": "L",
    "LEN": "L",
    "POS": "P",
    "STR1": "IN1",
    "STR2": "IN2",
}


def block_arguments(node: s.CallStatement, block: BlockType, scope: Scope) -> dict[str, s.Argument]:
    """Return the VAR_INPUT and VAR_IN_OUT arguments of a block call by upper-case pin name.

    Raises:
        InputError: The arguments do not fit.
    """
    named = are_named(node, scope)
    pins = [pin for pin in block.variables if pin.section in ("VAR_INPUT", "VAR_IN_OUT")]
    if not named:
        if len(node.arguments) not in (0, len(pins)):
            raise scope.error(
                f"{block.name} takes {len(pins)} arguments, not {len(node.arguments)}",
                node.at,
                "name the arguments",
            )
        return {pin.name.upper(): item for pin, item in zip(pins, node.arguments, strict=False)}
    given: dict[str, s.Argument] = {}
    sent: set[str] = set()
    for pin, argument in zip(pins, node.arguments, strict=False):
        if argument.name is None:
            given[pin.name.upper()] = argument
    if sum(one.name is None for one in node.arguments) > len(given):
        raise scope.error(f"{block.name} takes {len(pins)} arguments without names", node.at)
    for argument in node.arguments:
        if argument.name is None:
            continue
        key = pin_name(block, argument.name.key)
        if key != argument.name.key:
            scope.note("another name of a pin", argument.at, f"{argument.name.key} is {key}")
        known = key in (pin.name.upper() for pin in pins)
        if not argument.output and not known:
            raise _no_pin(block, argument.name, pins, scope)
        if key in (sent if argument.output else given):
            raise scope.error(f"{argument.name.text} is given twice", argument.at)
        if argument.output:
            sent.add(key)
        else:
            given[key] = argument
    return given


def are_named(node: s.Call | s.Invoke | s.CallStatement, scope: Scope) -> bool:
    """Return whether the arguments of a call are named; note a call that mixes both forms.

    An unnamed argument belongs to the pin at the same position in the list.
    """
    named = [argument.name is not None for argument in node.arguments]
    if any(named) and not all(named):
        scope.note("named and positional arguments together", node.at)
    return any(named)


#: Pins that every function and block has in addition to its declared pins. EN enables a call, ENO
#: reports it.
ENABLING = ("EN", "ENO")


def enabling(
    node: s.Call | s.Invoke | s.CallStatement, own: Collection[str], scope: Scope
) -> dict[str, s.Argument]:
    """Return the arguments EN and ENO of a call by their name.

    `own` are the upper-case names of the callee's variables. A declared EN or ENO is an ordinary
    pin.

    Raises:
        InputError: EN is an output (`EN =>`), ENO is an input (`ENO :=`), or one of them is given
            twice.
    """
    found: dict[str, s.Argument] = {}
    for argument in node.arguments:
        if argument.name is None or argument.name.key not in ENABLING or argument.name.key in own:
            continue
        key = argument.name.key
        if argument.output != (key == "ENO"):
            is_input = key == "EN"
            text = f"{key} is an {'input' if is_input else 'output'}"
            hint = "write EN := condition" if is_input else "write ENO => variable"
            raise scope.error(text, argument.at, hint)
        if key in found:
            raise scope.error(f"{key} is given twice", argument.at)
        found[key] = argument
    return found


def without_true(node: s.Call, own: Collection[str]) -> s.Call:
    """Return a call without `EN := TRUE`, because this argument changes nothing.

    `own` has the declared variables of the callee. A declared EN is not removed.
    """

    def is_true(argument: s.Argument) -> bool:
        value, name = argument.value, argument.name
        literal = isinstance(value, s.Literal) and value.text.upper() == "TRUE"
        return literal and name is not None and name.key == "EN" and "EN" not in own

    kept = tuple(one for one in node.arguments if not is_true(one))
    return replace(node, arguments=kept) if len(kept) < len(node.arguments) else node


def refuse_enabling(node: s.Call | s.Invoke, own: Collection[str], scope: Scope) -> None:
    """Raise InputError if a call inside an expression has EN or ENO.

    If EN is FALSE, such a call has no value, and each PLC tool continues with a different value.
    """
    for argument in enabling(node, own, scope).values():
        assert argument.name is not None
        raise scope.error(
            f"{argument.name.key} of a call inside an expression",
            argument.at,
            "assign the result to a variable in a statement of its own",
        )


def _no_pin(block: BlockType, name: s.Name, pins: list[Variable], scope: Scope) -> InputError:
    pin = pin_of(block, name.text)
    if pin is not None and pin.section == "VAR_OUTPUT":
        hint = f"write {pin.name} => variable"
    else:
        hint = f"use {', '.join(pin.name for pin in pins)}"
    return scope.error(f"{block.name} has no input {name.text}", name.at, hint)


def pin_of(block: BlockType, name: str) -> Variable | None:
    """Return the variable of a block by its name, compared without case; None if there is none."""
    key = pin_name(block, name)
    return next((pin for pin in block.variables if pin.name.upper() == key), None)
