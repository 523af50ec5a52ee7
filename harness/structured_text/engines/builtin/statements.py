"""Python code for checked POUs: a function for each POU, and a map back to the source lines."""

from __future__ import annotations

import re

from structured_text.engines.builtin.expression_code import ExpressionCode, has_call
from structured_text.engines.builtin.objects import handed_back, is_dynamic
from structured_text.engines.builtin.storage import (
    Storage,
    in_cell,
    is_scalar,
    needs_globals,
    slot_name,
)
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.scalars import INT_RANGE
from structured_text.language.standard import BLOCKS
from structured_text.language.types import ArrayType, type_name
from structured_text.language.walk import bodies, statements

__all__ = ["Branches", "Writer"]

#: Pairs of a condition, as Python code, and the statements to run if it is true.
Branches = list[tuple[str, tuple[t.Statement, ...]]]
#: Largest number of branches in one Python `if`.
_BRANCHES = 50
#: Matches an assignment to a variable of a POU inside an expression. Generated names are lower
#: case.
_WRITTEN = re.compile(r"[( ]([^\W\da-z]\w*) := ")


class Writer:
    """The writer of the Python function of a POU.

    A block's function has the parameters `s`, its instance, and the VAR_IN_OUT variables.
    Structures and arrays are passed by reference, scalars are returned at the end. A call that
    passes the same variable twice is refused. Therefore a program has the same results as with
    copies at the beginning and at the end of the call.

    Attributes:
        lines: The code.
        origins: Source line of each line of code, 0 if it has none.
    """

    def __init__(self, project: Project, pou: t.Pou, storage: Storage) -> None:
        self.lines: list[str] = []
        self.origins: list[int] = []
        self._pou = pou
        self._storage = storage
        self._project = project
        self._code = ExpressionCode(project, pou)
        self._code.pointing.storage = storage
        self._at = 0
        self._prelude = 0
        self._depth = 1
        self._temporaries = 0
        self._tries = 0

    def write(self) -> None:
        """Write the whole function."""
        pou = self._pou
        if pou.kind == "METHOD":
            parameters = ["s", *(symbol.name.upper() for symbol in _parameters(pou))]
            local = [*pou.section("VAR_OUTPUT"), *pou.section("VAR_TEMP")]
            local += [one for one in pou.section("VAR") if "." not in one.name]
            local += [pou.result] if pou.result is not None else []
        elif pou.kind == "FUNCTION":
            passed = [*pou.section("VAR_INPUT"), *pou.section("VAR_IN_OUT")]
            parameters = [symbol.name.upper() for symbol in passed]
            if self._code.is_shared(pou.name.upper()):
                parameters.insert(0, "g")
            local = [*pou.section("VAR"), *pou.section("VAR_TEMP"), *pou.section("VAR_OUTPUT")]
            local += [pou.result] if pou.result else []
        else:
            parameters = ["s", *(symbol.name.upper() for symbol in pou.section("VAR_IN_OUT"))]
            local = pou.section("VAR_TEMP")
        self._depth = 0
        self._emit(f"def f_{slot_name(pou.name)}({', '.join(parameters)}):")
        self._depth = 1
        if self._has_globals():
            self._emit("g = s.g")
        for symbol in local:
            self._emit(
                f"{symbol.name.upper()} = {self._storage.create(symbol.type, symbol.initial)}"
            )
        for symbol in pou.section("VAR_INPUT") if pou.kind == "FUNCTION" else ():
            if symbol.name.upper() in pou.copied and not is_scalar(symbol.type):
                self._emit(self._storage.own(symbol))
        if pou.kind == "METHOD":
            for symbol in pou.section("VAR_INPUT"):
                self._input(symbol)
        for symbol in (*pou.symbols.values(), *([pou.result] if pou.result else [])):
            if in_cell(symbol) and self._code.is_local(symbol):
                self._emit(f"{symbol.name.upper()} = [{symbol.name.upper()}]")
        self._share()
        if any(isinstance(one, t.Try) for one in statements(pou.body)):
            self._emit("r_ = False")
        self._prelude = len(self.lines)
        self._statements(pou.body)
        self._leave_pou()

    def _share(self) -> None:
        """Write code that stores in the instance each VAR_IN_OUT that methods of the block use."""
        for symbol in self._pou.section("VAR_IN_OUT") if self._pou.block is not None else ():
            if symbol.shared:
                self._emit(f"s.{symbol.name.upper()} = {symbol.name.upper()}")

    def _has_globals(self) -> bool:
        """Return whether the code of a body or method uses the globals `g`."""
        pou = self._pou
        if pou.block is not None:
            return self._code.uses_globals(pou, pou.section("VAR_TEMP"))
        if pou.owner is None:
            return False
        own = (one for one in pou.symbols.values() if one.section != "VAR_IN_OUT")
        return needs_globals(pou.owner) or self._code.uses_globals(pou, own)

    def _input(self, symbol: t.Symbol) -> None:
        """Write code that gives an input of a method a copy of its argument, or its default."""
        name = symbol.name.upper()
        created = self._storage.create(symbol.type, symbol.initial)
        if is_scalar(symbol.type):
            self._emit(f"if {name} is None: {name} = {created}")
            return
        given = self._temporary(name)
        self._emit(f"{name} = {created}")
        self._emit(f"if {given} is not None: {self._storage.copy(symbol.type, name, given)}")

    def _return(self) -> str:
        pou = self._pou
        if pou.kind == "METHOD":
            first = "None" if pou.result is None else self._code.symbol(pou.result)
            return f"return {', '.join([first, *map(self._code.symbol, handed_back(pou))])}"
        in_outs = [one for one in pou.section("VAR_IN_OUT") if is_scalar(one.type)]
        if pou.kind == "FUNCTION":
            first = "None" if pou.result is None else self._code.symbol(pou.result)
            others = [self._code.symbol(one) for one in (*in_outs, *pou.section("VAR_OUTPUT"))]
            return f"return ({', '.join([first, *others])})" if others else f"return {first}"
        return f"return {', '.join(map(self._code.symbol, in_outs))}".rstrip()

    def _emit(self, line: str) -> None:
        for name, code in self._code.parts:
            outer = ", ".join(dict.fromkeys(_WRITTEN.findall(code)))
            outer = f"nonlocal {outer}; " if outer else ""
            self.lines.insert(self._prelude, f"    def {name}(): {outer}return {code}")
            self.origins.insert(self._prelude, self._at)
        self._code.parts.clear()
        self.lines.append("    " * self._depth + line)
        self.origins.append(self._at)

    def _temporary(self, code: str) -> str:
        self._temporaries += 1
        name = f"t{self._temporaries}"
        self._emit(f"{name} = {code}")
        return name

    def _block(self, head: str, statements: tuple[t.Statement, ...]) -> None:
        self._emit(head)
        self._depth += 1
        self._statements(statements)
        if not statements:
            self._nothing()
        self._depth -= 1

    def _nothing(self) -> None:
        """Write the Python statement `pass` for an empty body of an IF, CASE or loop."""
        self._emit("pass")

    def _statements(self, statements: tuple[t.Statement, ...]) -> None:
        for statement in statements:
            self._at = statement.at.line
            self._statement(statement)

    def _statement(self, node: t.Statement) -> None:
        if isinstance(node, t.Assign):
            target = self._code.variable(node.target)
            self._emit(self._storage.copy(node.target.type, target, self._code.exact(node.value)))
        elif isinstance(node, t.CallBlock):
            self._call(node)
        elif isinstance(node, t.CallBase):
            self._call_base(node)
        elif isinstance(node, t.If):
            self._if(node)
        elif isinstance(node, t.Case):
            self._case(node)
        elif isinstance(node, t.For):
            self._for(node)
        elif isinstance(node, t.While):
            self._while(node)
        elif isinstance(node, t.Repeat):
            self._repeat(node)
        elif isinstance(node, t.Try):
            self._try(node)
        elif isinstance(node, s.Exit):
            self._emit("break")
        elif isinstance(node, s.Continue):
            self._emit("continue")
        elif isinstance(node, t.Evaluate):
            self._emit(self._code.exact(node.value))
        else:
            if self._tries:
                self._emit("r_ = True")
            self._leave_pou()

    def _leave_pou(self) -> None:
        """Write the code for RETURN and the end of a POU.

        If a VAR_IN_OUT of a block is read outside of the block, its last value is stored in the
        instance.
        """
        for symbol in self._pou.section("VAR_IN_OUT") if self._pou.block is not None else ():
            held = self._pou.symbols.get(f"{symbol.name}.{t.AFTER_CALL}".upper())
            if held is not None:
                self._emit(f"s.{slot_name(held.name)} = {self._code.symbol(symbol)}")
        self._emit(self._return())

    def _try(self, node: t.Try) -> None:
        """Write a `__TRY` as a Python `try` that runs the sections in the same order as CODESYS."""
        self._tries += 1
        self._emit("try:")
        self._inside(node.body)
        self._emit("except FAULTS as x_:")
        self._depth += 1
        target = "x_" if node.code is None else self._code.variable(node.code)
        self._emit(f"{target} = caught(x_)")
        self._statements(node.handler)
        self._depth -= 1
        self._tries -= 1
        if node.last:
            self._emit("finally:")
            self._inside(node.last)
            # A RETURN before __FINALLY has already read the result. It is read again, because the
            # statements of __FINALLY may have changed it.
            self._emit(f"    if r_: {self._return()}")

    def _inside(self, statements: tuple[t.Statement, ...]) -> None:
        """Write the statements of one section of a `__TRY`."""
        self._depth += 1
        self._statements(statements)
        if not statements:
            self._emit("pass")
        self._depth -= 1

    def _if(self, node: t.If) -> None:
        branches = [(self._code.exact(condition), body) for condition, body in node.branches]
        self._branches(branches, node)

    def _branches(self, branches: Branches, node: t.If | t.Case) -> None:
        """Write one `if`, or several if there are many branches.

        Python nests each `elif` in the branch before it, so a long chain would be too deep. Each
        further `if` is entered only if no branch before it was taken.
        """
        if len(branches) <= _BRANCHES:
            self._chain(branches)
            self._no_branch(node)
            return
        missed = self._temporary("True")
        for first in range(0, len(branches), _BRANCHES):
            self._emit(f"if {missed}:")
            self._depth += 1
            self._emit(f"{missed} = False")
            self._chain(branches[first : first + _BRANCHES])
            self._emit(f"else: {missed} = True")
            self._depth -= 1
        self._emit(f"if not {missed}: pass")
        self._no_branch(node)

    def _chain(self, branches: Branches) -> None:
        word = "if"
        for condition, body in branches:
            self._block(f"{word} {condition}:", body)
            word = "elif"

    def _no_branch(self, node: t.If | t.Case) -> None:
        if node.otherwise:
            self._block("else:", node.otherwise)

    def _case(self, node: t.Case) -> None:
        selector = self._temporary(self._code.exact(node.selector))
        branches = []
        for labels, body in node.branches:
            tests = [
                f"{selector} == {low}" if low == high else f"{low} <= {selector} <= {high}"
                for low, high in labels
            ]
            branches.append((" or ".join(tests), body))
        self._branches(branches, node)

    # A loop is a Python `for` over the allowed number of rounds. Each end of the loop is a `break`,
    # which skips the `else`. If the rounds are used up, the `else` reports an endless loop.

    def _loop(self, line: int) -> None:
        self._depth -= 1
        self._at = line
        self._emit("else: endless()")

    def _while(self, node: t.While) -> None:
        self._emit("for _ in FUSE:")
        self._depth += 1
        self._leave(f"not {self._code.exact(node.condition)}", node)
        self._statements(node.body)
        self._loop(node.at.line)

    def _leave(self, condition: str, node: t.While | t.For) -> None:
        """Write the condition that ends a loop before its next round."""
        self._emit(f"if {condition}: break")

    def _repeat(self, node: t.Repeat) -> None:
        self._emit("for _ in FUSE:")
        self._depth += 1
        if _continues(node.body):
            # CONTINUE in a REPEAT jumps to the condition at its end. The condition is therefore
            # tested at the start of each round but the first.
            self._emit(f"if _ and {self._code.exact(node.condition)}: break")
            self._statements(node.body)
            self._loop(node.at.line)
            return
        self._statements(node.body)
        self._emit(f"if {self._code.exact(node.condition)}: break")
        self._loop(node.at.line)

    def _for(self, node: t.For) -> None:
        counter = self._code.variable(node.counter)
        end = self._code.exact(node.end)
        if not isinstance(node.end, t.Constant) and has_call(node.end):
            end = self._temporary(end)
        self._emit(f"{counter} = {self._code.exact(node.start)}")
        self._emit("for _ in FUSE:")
        self._depth += 1
        continues = _continues(node.body)
        if continues:
            # CONTINUE in a FOR starts the next round with the next value. The step is therefore
            # made at the start of each round but the first.
            self._emit("if _:")
            self._depth += 1
            self._step(node, counter)
            self._depth -= 1
        if isinstance(node.step, t.Constant):
            past = ">" if int(node.step.value) > 0 else "<"
            self._leave(f"{counter} {past} {end}", node)
        else:
            step = self._code.exact(node.step)
            self._leave(f"{counter} > {end} if {step} > 0 else {counter} < {end}", node)
        self._statements(node.body)
        self._at = node.at.line
        if not continues:
            self._step(node, counter)
        self._loop(node.at.line)

    def _step(self, node: t.For, counter: str) -> None:
        """Write the step of a FOR; the loop ends if its type cannot hold the next value."""
        next_value = t.Binary("+", node.counter, node.step, node.counter.type)
        code = self._code.exact(next_value)
        if _may_wrap(node):
            self._emit(f"t_ = {counter}")
            self._emit(f"{counter} = {code}")
            constant = isinstance(node.step, t.Constant)
            step = f"({node.step.value})" if constant else self._code.exact(node.step)  # type: ignore[union-attr]
            self._emit(f"if {counter} != t_ + {step}: break")
        else:
            self._emit(f"{counter} = {code}")

    def _call(self, node: t.CallBlock) -> None:
        instance = self._code.variable(node.instance)
        block = node.block
        if node.inputs or node.outputs:
            instance = self._temporary(instance)
        types = {pin.name: pin.type for pin in block.variables}
        for pin, value in node.inputs:
            target = f"{instance}.{pin.upper()}"
            self._emit(self._storage.copy(types[pin], target, self._code.exact(value)))
        arguments, scalars = [instance], []
        for name, variable in node.in_outs:
            if is_scalar(variable.type):
                scalars.append(self._fixed(variable))
                arguments.append(scalars[-1])
            else:
                arguments.append(self._code.given(variable, types[name]))
        prefix = "body_" if block.name in BLOCKS else "f_"
        call = f"{prefix}{block.name.upper()}({', '.join(arguments)})"
        if is_dynamic(self._project.objects, block, self._project):
            call = f"{instance}.body({', '.join(arguments[1:])})"
        self._emit(f"{', '.join(scalars)} = {call}" if scalars else call)
        for pin, variable in node.outputs:
            target = self._code.variable(variable)
            source = f"{instance}.{pin.upper()}"
            if types[pin] != variable.type:
                source = self._code.cut(source, variable.type)
            self._emit(self._storage.copy(types[pin], target, source))

    def _call_base(self, node: t.CallBase) -> None:
        types = {pin.name: pin.type for pin in node.block.variables}
        for pin, value in node.inputs:
            target = f"s.{pin.upper()}"
            self._emit(self._storage.copy(types[pin], target, self._code.exact(value)))
        pins = [pin for pin in node.block.variables if pin.section == "VAR_IN_OUT"]
        symbols = [self._code.symbol(self._pou.symbols[pin.name.upper()]) for pin in pins]
        scalars = [code for code, pin in zip(symbols, pins, strict=True) if is_scalar(pin.type)]
        call = f"f_{node.block.name.upper()}({', '.join(['s', *symbols])})"
        self._emit(f"{', '.join(scalars)} = {call}" if scalars else call)
        self._share()

    def _fixed(self, node: t.Variable) -> str:
        """Return the Python code of a variable with its indices evaluated once, in temporaries.

        A VAR_IN_OUT is read before the call and written after it; both must use the same element.
        """
        if isinstance(node, t.Use):
            return self._code.variable(node)
        if isinstance(node, t.Member):
            return f"{self._fixed(node.base)}.{node.name.upper()}"
        if not isinstance(node, t.Index):
            return self._code.pointing.fixed(node, self._temporary)
        position = self._code.position(node)
        if not position.isdigit():
            position = self._temporary(position)
        base, kind = self._fixed(node.base), node.base.type
        if isinstance(kind, ArrayType) and kind.open:
            base = f"{base}.held"
        return f"{base}[{position}]"


def _continues(body: tuple[t.Statement, ...]) -> bool:
    """Return whether the body contains a CONTINUE of its own loop."""
    for one in body:
        if isinstance(one, s.Continue):
            return True
        if isinstance(one, (t.If, t.Case, t.Try)) and any(map(_continues, bodies(one))):
            return True
    return False


def _may_wrap(node: t.For) -> bool:
    """Return whether the counter of a FOR can exceed the range of its type."""
    low, high = INT_RANGE[type_name(node.counter.type)]
    if not isinstance(node.end, t.Constant) or not isinstance(node.step, t.Constant):
        return True
    return not low <= int(node.end.value) + int(node.step.value) <= high


def _parameters(method: t.Pou) -> list[t.Symbol]:
    """Return the parameters of a method: its inputs, then its VAR_IN_OUT."""
    return [*method.section("VAR_INPUT"), *method.section("VAR_IN_OUT")]
