"""Calls of methods, properties, THIS^ and SUPER^, and names with a namespace."""

from __future__ import annotations

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.calls import are_named, refuse_enabling
from structured_text.language.checking import Checking
from structured_text.language.overloads import overload, overloads
from structured_text.language.references import PLACES, place_of
from structured_text.language.registry import ConsequenceError
from structured_text.language.resolve import fills
from structured_text.language.types import BlockType, ElementaryType, InterfaceType, Type
from structured_text.language.values import describe
from structured_text.language.widening import same_number, widens
from structured_text.output.limits import MOST_LEVELS

__all__ = ["NOTHING", "Methods"]

#: The type of a call without a result.
NOTHING = ElementaryType("")
_SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")


class Methods:
    """Checks the calls of methods in one POU; `expression_checker` uses this class."""

    def __init__(self, expressions: Checking) -> None:
        self._all = expressions
        self._scope = expressions.scope
        self._objects = expressions.scope.declarations.objects
        # The key is the `id` of the call. The value includes the call, so that Python does not
        # reuse this `id`.
        self._plain: dict[int, tuple[s.Invoke, s.Call | None]] = {}

    # --- names ---

    def this(self, at: s.Position, *, above: bool = False) -> t.This:
        """Check and type `THIS^`; with `above`, `SUPER^`: the same instance as a base block.

        Raise InputError if there is no instance, or the block has no base.
        """
        pou = self._scope.block
        if pou is None or pou.block is None:
            raise self._scope.error("THIS and SUPER belong to function blocks", at)
        if not above:
            return t.This(pou.block)
        base = self._objects.extended.get(pou.name.upper())
        if base is None:
            text = f"SUPER needs a block that extends another; {pou.name} does not"
            raise self._scope.error(text, at)
        above_it = self._scope.declarations.pous.get(base)
        if above_it is None or above_it.block is None:
            raise ConsequenceError(f"{pou.name} has a base with an error")
        return t.This(above_it.block)

    def is_own_property(self, key: str) -> bool:
        """Return whether a name without a path is a property of the block of this POU."""
        pou = self._scope.block
        return pou is not None and self._objects.is_property(pou.block, key)

    def own_property(self, node: s.Name) -> t.CallMethod:
        """Check and type the value of a property of the block itself."""
        return self._read(self.this(node.at), node)

    def property(self, base: t.Variable, name: s.Name, *, final: bool = False) -> t.Variable | None:
        """Check and type the value of a property of a block or interface; None if there is none."""
        if not self._objects.is_property(base.type, name.key):
            return None
        return self._read(base, name, final=final)

    def _read(self, base: t.Expression, name: s.Name, *, final: bool = False) -> t.CallMethod:
        getter = self._objects.method(base.type, f"{name.key}.GET")
        if getter is not None:
            self._check_whole(getter)
        setter = self._objects.method(base.type, f"{name.key}.SET")
        if setter is not None:
            self._check_whole(setter)
        if getter is None or getter.result is None:
            raise self._scope.error(f"the property {name.text} has no GET", name.at)
        self._check_access(getter, name)
        return t.CallMethod(base, getter, final, (), (), (), getter.result.type)

    def setter(self, node: s.Variable) -> tuple[t.Expression, t.Pou, bool] | None:
        """Return instance, SET and `final` of an assigned property; None for another variable.

        `final` is true if exactly the SET of this block is called (SUPER^).
        """
        if isinstance(node, s.Name):
            if self._scope.symbol(node.key) is not None or not self.is_own_property(node.key):
                return None
            base, name, final = self.this(node.at), node, False
        elif isinstance(node, s.Field) and not self._is_plain(node):
            found = self._all.base(node.base)
            if not self._objects.is_property(found.type, node.name.key):
                return None
            base, name = found, node.name  # type: ignore[assignment]
            final = isinstance(node.base, s.This) and node.base.above
        else:
            return None
        method = self._objects.method(base.type, f"{name.key}.SET")
        if method is None:
            kind = self._all.variable(node).type
            if self._all.references.followed(t.This(kind)).type != kind:
                return None  # The property returns a REFERENCE TO: its target is written.
            raise self._scope.error(f"the property {name.text} has no SET", name.at)
        self._check_whole(method)
        self._check_access(method, name)
        return base, method, final

    def _is_plain(self, node: s.Field) -> bool:
        """Return whether a variable is named with its namespace, or with its list of globals."""
        base = node.base
        if self._is_space(base) or not isinstance(base, s.Name):
            return self._is_space(base)
        known = self._scope.declarations.lists.get(base.key, {})
        return self._scope.symbol(base.key) is None and node.name.key in known

    def symbol_of_this(self, node: s.Field) -> t.Use | None:
        """Return the variable `x` that `THIS^.x` denotes; None for any other expression."""
        pou = self._scope.block
        if not isinstance(node.base, s.This) or pou is None:
            return None
        symbol = pou.symbols.get(node.name.key)
        if symbol is None or symbol.section == "VAR_TEMP":
            return None
        if symbol.section == "VAR_IN_OUT" and self._scope.pou.owner is not None:
            symbol.shared = symbol.addressed = True
        return t.Use(symbol, symbol.type)

    def method_hint(self, kind: Type, key: str) -> str:
        """Return a hint for a method that is named but not called."""
        return "call it with ()" if self._objects.method(kind, key) is not None else ""

    # --- namespaces ---

    def _is_space(self, node: s.Variable | s.Invoke) -> bool:
        """Return whether a node is the name of a namespace or library, and not a variable."""
        parts: list[str] = []
        while isinstance(node, s.Field):
            parts.append(node.name.key)
            node = node.base
            # Each step of a long path calls this method. Without a limit for the length of a path,
            # the time would grow with the square of the length.
            if len(parts) > MOST_LEVELS:
                return False
        if not isinstance(node, s.Name) or self._scope.symbol(node.key) is not None:
            return False
        here = self._scope.block
        if here is not None and here.kind == "PROGRAM" and node.key == here.name.upper():
            # Inside a program, the program's name before a dot refers to its own variables.
            return not parts
        name = ".".join([node.key, *reversed(parts)])
        return name in self._scope.registry.namespaces

    def bare(self, node: s.Variable) -> s.Variable:
        """Return `Library.Name` as `Name`; without a namespace the node itself."""
        return node.name if isinstance(node, s.Field) and self._is_space(node.base) else node

    def plain_call(self, node: s.Invoke) -> s.Call | None:
        """Return `Library.Function(…)` as `Function(…)`; None for calls of methods."""
        if id(node) not in self._plain:
            callee, call = node.callee, None
            if isinstance(callee, s.Field) and self._is_space(callee.base):
                call = s.Call(callee.name, node.arguments, node.at)
            self._plain[id(node)] = node, call
        return self._plain[id(node)][1]

    # --- calls ---

    def called(self, callee: s.Variable) -> tuple[t.Expression, t.Pou, bool] | None:
        """Return instance, method and `final` of a call; None if it calls no method.

        `final` is true if exactly the method of this block is called (SUPER^).
        """
        if isinstance(callee, s.Name):
            pou = self._scope.block
            symbol = self._scope.symbol(callee.key)
            if pou is None or (symbol is not None and symbol is not self._scope.pou.result):
                return None
            method = self._method(pou.block, callee.key)
            if method is None:
                return None
            self._check_access(method, callee)
            return self.this(callee.at), method, False
        if not isinstance(callee, s.Field) or self._is_space(callee.base):
            return None
        first = callee.base
        if isinstance(first, s.Name) and self._is_elsewhere(first):
            return None
        if isinstance(first, s.Name) and not self._all.is_variable(first):
            here = self._scope.block
            lacks = here is not None and self._scope.registry.incomplete(here.name.upper())
            if lacks or first.key in self._scope.declarations.broken:
                raise ConsequenceError(f"{first.text} has an error")
            text = f"there is no variable or namespace {first.text}"
            if first.key in self._scope.declarations.broken:
                raise ConsequenceError(text)
            raise self._scope.error(text, first.at, "name its file, too, or check the spelling")
        final = isinstance(callee.base, s.This) and callee.base.above
        base = self._all.base(callee.base)
        method = self._method(base.type, callee.name.key)
        if method is None:
            if isinstance(base.type, (BlockType, InterfaceType)):
                self._refuse_no_method(base.type, callee)
            return None
        self._check_access(method, callee.name)
        return base, method, final

    def _method(self, kind: Type | None, key: str) -> t.Pou | None:
        """Return a method of a block or interface, or one of the method's overloads, or None."""
        found = self._objects.method(kind, key)
        return found or next(iter(overloads(self._objects, kind, key).values()), None)

    def _is_elsewhere(self, name: s.Name) -> bool:
        """Return whether a name before a dot is a list of globals, a program or a type."""
        declarations = self._scope.declarations
        if self._scope.symbol(name.key) is not None:
            return False
        found = (declarations.pous, self._scope.registry.types, declarations.lists)
        return any(name.key in names for names in found)

    def _refuse_no_method(self, kind: BlockType | InterfaceType, callee: s.Field) -> None:
        """Raise InputError for a missing method, unless a pin or property has the name."""
        pins = [pin.name.upper() for pin in getattr(kind, "variables", ())]
        if callee.name.key in pins or self._objects.is_property(kind, callee.name.key):
            return
        names = self._objects.names(kind)
        text = f"{kind.name} has no method {callee.name.text}"
        hint = f"use {', '.join(names[:8])}" if names else ""
        raise self._scope.error(text, callee.name.at, hint)

    def call(
        self, node: s.Call | s.Invoke | s.CallStatement, *, value: bool = True
    ) -> t.CallMethod | None:
        """Check and type a call of a method; None if it calls something else.

        `value` says whether its result is used.

        Raises:
            InputError: The method cannot be called here, or the arguments do not fit.
        """
        callee = node.function if isinstance(node, s.Call) else node.callee
        found = self.called(callee)
        if found is None:
            return None
        instance, method, final = found
        key = (callee.name if isinstance(callee, s.Field) else callee).key  # type: ignore[union-attr]
        if self._objects.method(instance.type, key) is None:
            node, method = overload(node, overloads(self._objects, instance.type, key), self._all)
        self._check_whole(method)
        if final and "ABSTRACT" in method.words:
            raise self._scope.error(f"{method.name} is ABSTRACT and has no body", node.at)
        if value and method.result is None:
            raise self._scope.error(f"{method.name} has no result", node.at)
        given = self._arguments(node, method)
        inputs: list[t.Expression | None] = []
        in_outs: list[tuple[str, t.Variable]] = []
        outputs: list[tuple[str, t.Variable]] = []
        for key, symbol in method.symbols.items():
            argument = given.get(key)
            if symbol.section == "VAR_INPUT":
                inputs.append(self._all.check(argument.value, symbol.type) if argument else None)
            elif symbol.section == "VAR_IN_OUT":
                if argument is None:
                    text = f"the VAR_IN_OUT {symbol.name} of {method.name} is missing"
                    raise self._scope.error(text, node.at)
                in_outs.append((symbol.name, self._target(argument, symbol, method)))
            elif symbol.section == "VAR_OUTPUT" and argument is not None:
                outputs.append((symbol.name, self._target(argument, symbol, method)))
        kind = method.result.type if method.result is not None else NOTHING
        return t.CallMethod(
            instance, method, final, tuple(inputs), tuple(in_outs), tuple(outputs), kind
        )

    def _arguments(
        self, node: s.Call | s.Invoke | s.CallStatement, method: t.Pou
    ) -> dict[str, s.Argument]:
        if not isinstance(node, s.CallStatement):
            refuse_enabling(node, method.symbols, self._scope)
        pins = {key: one for key, one in method.symbols.items() if one.section in _SECTIONS}
        order = list(pins)
        given: dict[str, s.Argument] = {}
        are_named(node, self._scope)
        if len(node.arguments) > len(order):
            text = f"{method.name} takes {len(order)} arguments, not {len(node.arguments)}"
            raise self._scope.error(text, node.at)
        for position, argument in enumerate(node.arguments):
            key = argument.name.key if argument.name is not None else order[position]
            section = pins[key].section if key in pins else ""
            is_output = section == "VAR_OUTPUT"
            if not section or (argument.name is not None and argument.output != is_output):
                kind = "output" if argument.output else "input"
                of_kind = ("VAR_OUTPUT",) if argument.output else ("VAR_INPUT", "VAR_IN_OUT")
                names = [one.name for one in pins.values() if one.section in of_kind]
                raise self._scope.error(
                    f"{method.name} has no {kind} {argument.name.text if argument.name else key}",
                    argument.at,
                    f"use {', '.join(names)}" if names else "",
                )
            if key in given:
                raise self._scope.error(f"{pins[key].name} is given twice", argument.at)
            given[key] = argument
        return given

    def _target(self, argument: s.Argument, symbol: t.Symbol, method: t.Pou) -> t.Variable:
        """Check and type the variable for a VAR_IN_OUT or an output."""
        value = argument.value
        if not isinstance(value, PLACES):
            text = f"{symbol.section} {symbol.name} of {method.name} needs a variable"
            raise self._scope.error(text, argument.at)
        block = isinstance(symbol.type, BlockType)
        read = block or symbol.constant
        found = self._all.variable(value) if read else self._all.writable(value)
        fits = found.type == symbol.type or (block and self._objects.is_a(found.type, symbol.type))
        fits = fits or fills(found.type, symbol.type)
        below = self._scope.declarations.derives(found.type, symbol.type)
        if below and symbol.section == "VAR_IN_OUT":
            self._scope.note("a structure as its base", argument.at)
            fits = True
        if symbol.section == "VAR_OUTPUT" and same_number(symbol.type, found.type):
            self._scope.note("an enumeration as a number", argument.at)
            fits = True
        if symbol.section == "VAR_OUTPUT" and widens(symbol.type, found.type):
            self._scope.note("an implicit conversion", argument.at, f"the output {symbol.name}")
            fits = True
        if not fits or place_of(found) is None:
            raise self._scope.error(
                f"{symbol.name} of {method.name} needs a variable of {describe(symbol.type)},"
                f" not a {describe(found.type)}",
                argument.at,
            )
        return found

    def _check_whole(self, method: t.Pou) -> None:
        """Raise ConsequenceError if the declaration of a method has an error."""
        if method.name.upper() in self._scope.declarations.broken:
            raise ConsequenceError(f"{method.name} has an error")

    def _check_access(self, method: t.Pou, name: s.Name) -> None:
        """Raise InputError if a PRIVATE or PROTECTED method is called from outside.

        INTERNAL means PUBLIC here, because all sources are one library.
        """
        here = self._scope.block
        owner = method.owner
        if owner is None or here is owner:
            return
        if "PRIVATE" in method.words:
            raise self._scope.error(f"{method.name} is PRIVATE", name.at)
        inside = here is not None and self._objects.is_a(here.block, owner.block)
        if "PROTECTED" in method.words and not inside:
            raise self._scope.error(f"{method.name} is PROTECTED", name.at)
