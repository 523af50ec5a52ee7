"""Which argument of a call is meant for which pin, of functions and of blocks."""

from __future__ import annotations

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.declare import Scope
from rcx_harness.engine.frontend.standard import Signature
from rcx_harness.engine.types import BlockType, ElementaryType, EnumType, Variable
from rcx_harness.errors import InputError

__all__ = ["block_arguments", "function_arguments", "pin_of", "standard_arguments"]


def function_arguments(node: s.Call, pou: t.Pou, scope: Scope) -> dict[str, s.Argument]:
    """The arguments of a function of the sources by upper-case name of its input.

    Raises:
        InputError: arguments that do not fit.
    """
    inputs = pou.section("VAR_INPUT")
    given: dict[str, s.Argument] = {}
    named = _are_named(node, scope)
    if not named and len(node.arguments) != len(inputs):
        raise scope.error(
            f"{pou.name} takes {len(inputs)} arguments, not {len(node.arguments)}", node.at
        )
    for position, argument in enumerate(node.arguments):
        key = argument.name.key if argument.name else inputs[position].name.upper()
        if key not in (symbol.name.upper() for symbol in inputs) or argument.output:
            raise scope.error(
                f"{pou.name} has no input {key}",
                argument.at,
                f"it has {', '.join(symbol.name for symbol in inputs)}",
            )
        if key in given and argument.name is not None:
            raise scope.error(f"{argument.name.text} is given twice", argument.at)
        given[key] = argument
    for symbol in inputs:
        scalar = isinstance(symbol.type, (ElementaryType, EnumType))
        if not scalar and symbol.name.upper() not in given:
            message = f"the input {symbol.name} of {pou.name} is missing"
            raise scope.error(message, node.at)
    return given


def standard_arguments(
    node: s.Call, signature: Signature, scope: Scope
) -> list[tuple[s.Argument, tuple[str, str]]]:
    """The arguments in the order of the pins, each with its (name, type).

    Raises:
        InputError: arguments that do not fit.
    """
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
    named = [argument for argument in node.arguments if argument.name is not None]
    if not named:
        return list(zip(node.arguments, pins, strict=True))
    given = {argument.name.key: argument for argument in named if argument.name}
    if len(given) != len(pins) or set(given) != {name for name, _ in pins}:
        raise scope.error(
            f"{node.function.text} needs {', '.join(name for name, _ in pins)}", node.at
        )
    return [(given[name], (name, kind)) for name, kind in pins]


def block_arguments(node: s.CallStatement, block: BlockType, scope: Scope) -> dict[str, s.Argument]:
    """The input and in-out arguments by upper-case pin name.

    Raises:
        InputError: arguments that do not fit.
    """
    named = _are_named(node, scope)
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
    for argument in node.arguments:
        assert argument.name is not None
        key = argument.name.key
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


def _are_named(node: s.Call | s.CallStatement, scope: Scope) -> bool:
    named = [argument for argument in node.arguments if argument.name is not None]
    if named and len(named) != len(node.arguments):
        raise scope.error("named and positional arguments are mixed", node.at)
    return bool(named)


def _no_pin(block: BlockType, name: s.Name, pins: list[Variable], scope: Scope) -> InputError:
    pin = pin_of(block, name.text)
    if pin is not None and pin.section == "VAR_OUTPUT":
        hint = f"write {pin.name} => variable"
    else:
        hint = f"it has {', '.join(pin.name for pin in pins)}"
    return scope.error(f"{block.name} has no input {name.text}", name.at, hint)


def pin_of(block: BlockType, name: str) -> Variable | None:
    """The variable of a block by its name, without case."""
    return next((pin for pin in block.variables if pin.name.upper() == name.upper()), None)
