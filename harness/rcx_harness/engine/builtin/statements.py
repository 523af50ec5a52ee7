"""Python code for checked POUs: one function each, with a map back to the source lines."""

from __future__ import annotations

from rcx_harness.engine.builtin.expressions import Expressions
from rcx_harness.engine.builtin.storage import Storage, is_scalar, needs_globals
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.frontend.standard import BLOCKS

__all__ = ["Writer"]

#: Condition and statements.
_Branches = list[tuple[str, tuple[t.Statement, ...]]]
#: Branches of one Python `if`.
_BRANCHES = 50


class Writer:
    """Writes the function of a POU.

    A block's function takes its instance `s` and its VAR_IN_OUT variables; structures and
    arrays among these are passed as they are, scalars are handed back at the end. A call is
    refused where the same variable comes in under two names, so that this cannot be told from
    copying in and out.

    Args:
        project: The project.
        pou: The POU to write.
        storage: For copies of structures and arrays.

    Attributes:
        lines: The code.
        origins: Source line of each of them, 0 where there is none.
    """

    def __init__(self, project: Project, pou: t.Pou, storage: Storage) -> None:
        self.lines: list[str] = []
        self.origins: list[int] = []
        self._pou = pou
        self._storage = storage
        self._code = Expressions(project, pou)
        self._at = 0
        self._prelude = 0
        self._depth = 1
        self._temporaries = 0

    def write(self) -> None:
        """Write the whole function."""
        pou = self._pou
        if pou.kind == "FUNCTION":
            parameters = [symbol.name.upper() for symbol in pou.section("VAR_INPUT")]
            local = [*pou.section("VAR"), *([pou.result] if pou.result else [])]
        else:
            parameters = ["s", *(symbol.name.upper() for symbol in pou.section("VAR_IN_OUT"))]
            local = pou.section("VAR_TEMP")
        self._depth = 0
        self._emit(f"def f_{pou.name.upper()}({', '.join(parameters)}):")
        self._depth = 1
        if pou.block is not None and needs_globals(pou):
            self._emit("g = s.g")
        for symbol in local:
            self._emit(
                f"{symbol.name.upper()} = {self._storage.create(symbol.type, symbol.initial)}"
            )
        self._prelude = len(self.lines)
        self._statements(pou.body)
        self._emit(self._return())

    def _return(self) -> str:
        pou = self._pou
        if pou.result is not None:
            return f"return {pou.result.name.upper()}"
        return f"return {', '.join(_handed_back(pou.section('VAR_IN_OUT')))}".rstrip()

    def _emit(self, line: str) -> None:
        for name, code in self._code.parts:
            self.lines.insert(self._prelude, f"    def {name}(): return {code}")
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
        self._depth -= 1

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
        elif isinstance(node, t.Exit):
            self._emit("break")
        else:
            self._emit(self._return())

    def _if(self, node: t.If) -> None:
        branches = [(self._code.exact(condition), body) for condition, body in node.branches]
        self._branches(branches, node)

    def _branches(self, branches: _Branches, node: t.If | t.Case) -> None:
        """One `if`; of many branches several, each entered where none before it was right.

        In Python each branch lies inside the one before it.
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

    def _chain(self, branches: _Branches) -> None:
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

    # A loop is a Python `for` over the rounds it may take: leaving it by `break` skips the
    # `else`, which says that it does not end.

    def _loop(self, line: int) -> None:
        self._depth -= 1
        self._at = line
        self._emit("else: endless()")

    def _while(self, node: t.While) -> None:
        self._emit("for _ in FUSE:")
        self._depth += 1
        self._emit(f"if not {self._code.exact(node.condition)}: break")
        self._statements(node.body)
        self._loop(node.at.line)

    def _repeat(self, node: t.Repeat) -> None:
        self._emit("for _ in FUSE:")
        self._depth += 1
        self._statements(node.body)
        self._emit(f"if {self._code.exact(node.condition)}: break")
        self._loop(node.at.line)

    def _for(self, node: t.For) -> None:
        counter = self._code.variable(node.counter)
        end = self._code.exact(node.end)
        self._emit(f"{counter} = {self._code.exact(node.start)}")
        self._emit("for _ in FUSE:")
        self._depth += 1
        if isinstance(node.step, t.Constant):
            past = ">" if int(node.step.value) > 0 else "<"
            self._emit(f"if {counter} {past} {end}: break")
        else:
            step = self._code.exact(node.step)
            self._emit(f"if {counter} > {end} if {step} > 0 else {counter} < {end}: break")
        self._statements(node.body)
        self._at = node.at.line
        next_value = t.Binary("+", node.counter, node.step, node.counter.type)
        self._emit(f"{counter} = {self._code.exact(next_value)}")
        self._loop(node.at.line)

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
        for _, variable in node.in_outs:
            if is_scalar(variable.type):
                scalars.append(self._fixed(variable))
                arguments.append(scalars[-1])
            else:
                arguments.append(self._code.variable(variable))
        prefix = "body_" if block.name in BLOCKS else "f_"
        call = f"{prefix}{block.name.upper()}({', '.join(arguments)})"
        self._emit(f"{', '.join(scalars)} = {call}" if scalars else call)
        for pin, variable in node.outputs:
            target = self._code.variable(variable)
            self._emit(self._storage.copy(types[pin], target, f"{instance}.{pin.upper()}"))

    def _fixed(self, node: t.Variable) -> str:
        """Code of a variable whose indices are evaluated here, once for both ways of the copy."""
        if isinstance(node, t.Use):
            return self._code.variable(node)
        if isinstance(node, t.Member):
            return f"{self._fixed(node.base)}.{node.name.upper()}"
        position = self._code.position(node)
        if not position.isdigit():
            position = self._temporary(position)
        return f"{self._fixed(node.base)}[{position}]"


def _handed_back(symbols: list[t.Symbol]) -> list[str]:
    return [symbol.name.upper() for symbol in symbols if is_scalar(symbol.type)]
