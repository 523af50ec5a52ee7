"""Checks calls of function blocks, and what may be written where."""

from __future__ import annotations

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.expressions import Expressions
from rcx_harness.engine.frontend.standard import BLOCKS
from rcx_harness.engine.frontend.values import describe
from rcx_harness.engine.types import BlockType, Variable
from rcx_harness.errors import InputError

__all__ = ["BlockCalls"]


class BlockCalls:
    """The block calls and assignment targets of one POU; shares its expressions."""

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._scope = expressions.scope

    def target(self, node: s.Variable) -> t.Variable:
        """A variable that is to be written.

        Raises:
            InputError: it cannot be written here: an input, a constant, a block or an output
                of a block.
        """
        known = not isinstance(node, s.Name) or self._scope.symbol(node.key) is not None
        if isinstance(node, s.Name) and not known and node.key in self._scope.registry.members:
            raise self._scope.error(f"{node.text} is a member of an enumeration", node.at)
        found = self._expressions.variable(node)
        if isinstance(found.type, BlockType):
            raise self._scope.error("a block cannot be assigned", node.at)
        part: t.Variable = found
        while not isinstance(part, t.Use):
            if isinstance(part, t.Member) and isinstance(part.base.type, BlockType):
                pin = _pin(part.base.type, part.name)
                if pin is None or pin.section != "VAR_INPUT":
                    raise self._scope.error(
                        f"{part.name} is an output of {part.base.type.name}", node.at
                    )
            part = part.base
        symbol = part.symbol
        if symbol.section == "VAR_INPUT":
            raise self._scope.error(
                f"{symbol.name} is a VAR_INPUT and cannot be written inside",
                node.at,
                "copy it to a variable of its own",
            )
        external = symbol.section == "VAR_EXTERNAL"
        source = self._scope.declarations.globals.get(symbol.name.upper()) if external else None
        if symbol.constant or (source is not None and source.constant):
            raise self._scope.error(f"{symbol.name} is CONSTANT", node.at)
        return found

    def check(self, node: s.CallStatement) -> t.CallBlock:
        """Type a call of a block instance.

        Raises:
            InputError: no block instance, arguments that do not fit, or a VAR_IN_OUT left out.
        """
        instance = self._instance(node)
        block = instance.type
        assert isinstance(block, BlockType)
        given = self._arguments(node, block)
        inputs: list[tuple[str, t.Expression]] = []
        in_outs: list[tuple[str, t.Variable]] = []
        for pin in block.variables:
            argument = given.get(pin.name.upper())
            if pin.section == "VAR_IN_OUT":
                if argument is None:
                    raise self._scope.error(
                        f"the VAR_IN_OUT {pin.name} of {block.name} is missing", node.at
                    )
                in_outs.append((pin.name, self._in_out(argument, pin, block)))
            elif argument is not None and pin.section == "VAR_INPUT":
                inputs.append((pin.name, self._expressions.check(argument.value, pin.type)))
        self._check_aliases(in_outs, block, node)
        outputs = [self._output(argument, block) for argument in node.arguments if argument.output]
        return t.CallBlock(instance, block, tuple(inputs), tuple(in_outs), tuple(outputs), node.at)

    def _instance(self, node: s.CallStatement) -> t.Variable:
        callee = node.callee
        if isinstance(callee, s.Name) and self._scope.symbol(callee.key) is None:
            pou = self._scope.declarations.pous.get(callee.key)
            if callee.key in BLOCKS or (pou is not None and pou.kind == "FUNCTION_BLOCK"):
                raise self._scope.error(
                    f"{callee.text} is a type of block", callee.at, "declare and call an instance"
                )
            if self._scope.registry.is_standard(callee.key) or pou is not None:
                raise self._scope.error(
                    f"the result of {callee.text} is not used", callee.at, "assign it"
                )
        found = self._expressions.variable(callee)
        if not isinstance(found.type, BlockType):
            raise self._scope.error(
                f"a {describe(found.type)} cannot be called; only blocks can", callee.at
            )
        return found

    def _arguments(self, node: s.CallStatement, block: BlockType) -> dict[str, s.Argument]:
        """The input and in-out arguments by upper-case pin name."""
        named = [argument for argument in node.arguments if argument.name is not None]
        if named and len(named) != len(node.arguments):
            raise self._scope.error("named and positional arguments are mixed", node.at)
        pins = [pin for pin in block.variables if pin.section in ("VAR_INPUT", "VAR_IN_OUT")]
        if not named:
            if len(node.arguments) not in (0, len(pins)):
                raise self._scope.error(
                    f"{block.name} takes {len(pins)} arguments, not {len(node.arguments)}",
                    node.at,
                    "name the arguments",
                )
            return {pin.name.upper(): item for pin, item in zip(pins, node.arguments, strict=False)}
        given: dict[str, s.Argument] = {}
        sent: set[str] = set()
        for argument in named:
            assert argument.name is not None
            key = argument.name.key
            known = key in (pin.name.upper() for pin in pins)
            if not argument.output and not known:
                raise self._no_pin(block, argument.name, pins)
            if key in (sent if argument.output else given):
                raise self._scope.error(f"{argument.name.text} is given twice", argument.at)
            if argument.output:
                sent.add(key)
            else:
                given[key] = argument
        return given

    def _no_pin(self, block: BlockType, name: s.Name, pins: list[Variable]) -> InputError:
        pin = _pin(block, name.text)
        if pin is not None and pin.section == "VAR_OUTPUT":
            hint = f"write {pin.name} => variable"
        else:
            hint = f"it has {', '.join(pin.name for pin in pins)}"
        return self._scope.error(f"{block.name} has no input {name.text}", name.at, hint)

    def _in_out(self, argument: s.Argument, pin: Variable, block: BlockType) -> t.Variable:
        value = argument.value
        if not isinstance(value, (s.Name, s.Field, s.Index)):
            raise self._scope.error(
                f"the VAR_IN_OUT {pin.name} of {block.name} needs a variable", argument.at
            )
        found = self.target(value)
        if found.type != pin.type:
            raise self._scope.error(
                f"{pin.name} of {block.name} needs a {describe(pin.type)},"
                f" not a {describe(found.type)}",
                argument.at,
            )
        part: t.Variable = found
        while not isinstance(part, t.Use):
            if isinstance(part.base.type, BlockType):
                raise self._scope.error(
                    f"a pin of a block cannot be passed to the VAR_IN_OUT {pin.name}", argument.at
                )
            part = part.base
        return found

    def _check_aliases(
        self, in_outs: list[tuple[str, t.Variable]], block: BlockType, node: s.CallStatement
    ) -> None:
        """One variable under two names behaves differently on each PLC, so it is refused."""
        reached = self._scope.declarations.externals(block)
        for position, (name, variable) in enumerate(in_outs):
            root = _path(variable)[0]
            assert isinstance(root, t.Symbol)
            if root.section == "VAR_EXTERNAL" and root.name.upper() in reached:
                raise self._scope.error(
                    f"{block.name} also uses the global variable {root.name} itself", node.at
                )
            for other_name, other in in_outs[:position]:
                if _overlap(_path(variable), _path(other)):
                    raise self._scope.error(
                        f"{other_name} and {name} are given the same variable", node.at
                    )

    def _output(self, argument: s.Argument, block: BlockType) -> tuple[str, t.Variable]:
        assert argument.name is not None
        pin = _pin(block, argument.name.text)
        if pin is None or pin.section != "VAR_OUTPUT":
            outputs = [pin.name for pin in block.variables if pin.section == "VAR_OUTPUT"]
            raise self._scope.error(
                f"{block.name} has no output {argument.name.text}",
                argument.at,
                f"it has {', '.join(outputs)}",
            )
        assert isinstance(argument.value, (s.Name, s.Field, s.Index))
        found = self.target(argument.value)
        if found.type != pin.type:
            raise self._scope.error(
                f"{pin.name} is a {describe(pin.type)}, its target a {describe(found.type)}",
                argument.at,
            )
        return pin.name, found


def _pin(block: BlockType, name: str) -> Variable | None:
    return next((pin for pin in block.variables if pin.name.upper() == name.upper()), None)


def _path(variable: t.Variable) -> list[object]:
    """The symbol, then each member name or constant index; None for an index unknown yet."""
    if isinstance(variable, t.Use):
        return [variable.symbol]
    if isinstance(variable, t.Member):
        return [*_path(variable.base), variable.name]
    indices = variable.indices
    known = all(isinstance(index, t.Constant) for index in indices)
    step = tuple(index.value for index in indices if isinstance(index, t.Constant))
    return [*_path(variable.base), step if known else None]


def _overlap(first: list[object], second: list[object]) -> bool:
    return all(a is None or b is None or a == b for a, b in zip(first, second, strict=False))
