"""The linker of a program: it translates blocks, labels and subroutines to jumps in flat code."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from rcx_harness.robot.program.syntax import Instruction, Node, Program, Subroutine
from structured_text.errors import InputError

__all__ = ["Line", "link"]

#: Maps each kind of block to the statement that ends it.
_ENDS = {
    "IF": "ENDIF",
    "FOR": "NEXT",
    "WHILE": "WEND",
    "SELECT": "END SELECT",
    "SUB": "END SUB",
}
_LABELLED = ("goto", "gosub", "on_error", "resume_at")


@dataclass(frozen=True)
class Line:
    """One statement of a program: its line number, its label, and its node (None: only a label)."""

    number: int
    label: str = ""
    statement: Node | None = None


@dataclass
class _Block:
    """A block, such as IF or FOR, whose end has not been read yet.

    Attributes:
        kind: IF, FOR, WHILE, SELECT or SUB.
        line: Number of the block's first line.
        at: Position at which the block begins.
        test: Position of the condition that jumps to the next branch or to the end of the block;
            -1: none.
        exits: Positions of the jumps to the end of the block.
        name: The variable of FOR, the hidden variable of SELECT, or the name of SUB.
    """

    kind: str
    line: int
    at: int
    test: int = -1
    exits: list[int] = field(default_factory=list)
    name: str = ""


def link(
    lines: Sequence[Line], texts: tuple[str, ...], *, integers: bool, shared: bool
) -> tuple[Program, list[tuple[int, InputError]]]:
    """Link statements to a program; return the program and all errors with their line numbers."""
    linker = _Linker()
    for line in lines:
        linker.add(line)
    errors = linker.finish()
    program = Program(
        tuple(linker.code), linker.labels, linker.subs, texts, integers=integers, shared=shared
    )
    return program, errors


class _Linker:
    """Links statements to code, one after the other."""

    def __init__(self) -> None:
        self.code: list[Instruction] = []
        self.labels: dict[str, int] = {}
        self.subs: dict[str, Subroutine] = {}
        self._blocks: list[_Block] = []
        self._errors: list[tuple[int, InputError]] = []
        self._line = 0

    def add(self, line: Line) -> None:
        """Add one statement with its label."""
        self._line = line.number
        if line.label:
            if line.label in self.labels:
                self._error(f"the label {line.label} occurs twice", "rename one of them")
            if line.statement is None:
                # A jump continues after the label's instruction, because a label alone is not a
                # line that is executed.
                self._emit("label")
            self.labels[line.label] = len(self.code)
        if line.statement is not None:
            self._statement(line.statement)

    def finish(self) -> list[tuple[int, InputError]]:
        """Report blocks without an end, resolve all labels, and return all errors."""
        for block in self._blocks:
            self._line = block.line
            self._error(f"this {block.kind} has no {_ENDS[block.kind]}", f"add {_ENDS[block.kind]}")
        for at, one in enumerate(self.code):
            self._line = one.line
            if one.kind in _LABELLED:
                self.code[at] = replace(one, jump=self._place(one.args[0]))
            elif one.kind in ("on_goto", "on_gosub"):
                places = tuple(self._place(label) for label in one.args[1:])
                self.code[at] = replace(one, args=(one.args[0], places))
            elif one.kind == "call" and one.args[0] not in self.subs:
                self._error(f"there is no SUB {one.args[0]}", f"add SUB {one.args[0]} ... END SUB")
        self._check_recursion()
        return self._errors

    def _statement(self, node: Node) -> None:
        handler = getattr(self, f"_on_{node.kind}", None)
        if handler:
            handler(*node.args)
        elif node.kind in ("move", "movei", "movet", "path"):
            self._moves(node)
        else:
            self._emit(node.kind, *node.args)

    # --- statements that begin, divide or end a block ---

    def _on_if_line(self, condition: Node, then: Node, otherwise: Node | None) -> None:
        test = self._emit("unless", condition)
        self._statement(then)
        if otherwise is None:
            self._jump_here(test)
        else:
            end = self._emit("jump")
            self._jump_here(test)
            self._statement(otherwise)
            self._jump_here(end)
        self.code[test] = replace(self.code[test], behind=len(self.code))

    def _on_if_block(self, condition: Node) -> None:
        block = self._begin("IF")
        block.test = self._emit("unless", condition)

    def _on_else_if(self, condition: Node) -> None:
        if block := self._within("ELSEIF", "IF"):
            self._next_branch(block, "ELSEIF")
            block.test = self._emit("unless", condition)

    def _on_else_(self) -> None:
        if block := self._within("ELSE", "IF"):
            self._next_branch(block, "ELSE")

    def _on_end_if(self) -> None:
        if block := self._end("ENDIF", "IF"):
            self._close(block)

    def _on_for_(self, name: str, first: Node, last: Node, step: Node | None) -> None:
        block = self._begin("FOR")
        block.name = name
        variable = Node("variable", (name, None))
        self._emit("assign", variable, first)
        self._emit("assign", _hidden("LIMIT", block.at), last)
        self._emit("assign", _hidden("STEP", block.at), step or Node("number", (1,)))
        block.test = self._emit("for_test", variable, *_limits(block))

    def _on_next_(self, name: str | None) -> None:
        block = self._end("NEXT", "FOR")
        if not block:
            return
        if name and name != block.name:
            self._error(f"NEXT {name} ends FOR {block.name}", f"write NEXT {block.name}")
        self._emit("for_next", Node("variable", (block.name, None)), *_limits(block))
        self._emit("jump", jump=block.test)
        self._close(block)

    def _on_exit_for(self) -> None:
        block = next((one for one in reversed(self._blocks) if one.kind == "FOR"), None)
        if block is None:
            self._error("EXIT FOR is outside of FOR ... NEXT", "remove it")
            return
        block.exits.append(self._emit("jump"))

    def _on_while_(self, condition: Node) -> None:
        block = self._begin("WHILE")
        block.test = self._emit("unless", condition)

    def _on_wend(self) -> None:
        if block := self._end("WEND", "WHILE"):
            self._emit("jump", jump=block.test)
            self._close(block)

    def _on_select(self, value: Node) -> None:
        block = self._begin("SELECT")
        self._emit("assign", _hidden("SELECT", block.at), value)
        block.test = self._emit("jump")

    def _on_case(self, *values: Node) -> None:
        if block := self._within("CASE", "SELECT"):
            self._next_branch(block, "CASE")
            block.test = self._emit("case", _hidden("SELECT", block.at), *values)

    def _on_case_else(self) -> None:
        if block := self._within("CASE ELSE", "SELECT"):
            self._next_branch(block, "CASE ELSE")

    def _on_end_select(self) -> None:
        if block := self._end("END SELECT", "SELECT"):
            self._close(block)

    def _on_sub(self, name: str, *parameters: str | None) -> None:
        if self._blocks:
            self._error("SUB is inside of another block", f"end {self._blocks[-1].kind} before it")
        block = self._begin("SUB")
        block.name = name
        block.exits.append(self._emit("leave"))  # the main program jumps over a SUB
        if name in self.subs:
            self._error(f"SUB {name} occurs twice", "rename one of them")
        names = tuple(one for one in parameters if one)
        self.subs[name] = Subroutine(len(self.code), names)

    def _on_end_sub(self) -> None:
        if block := self._end("END SUB", "SUB"):
            self._emit("exit_sub")
            self._close(block)

    # --- all other statements ---

    def _moves(self, node: Node) -> None:
        """Add an instruction for each target of a movement; only the last instruction has CONT."""
        robot, kind, *items = node.args
        targets = [one for one in items if one.kind in ("point", "data")]
        options = [one for one in items if one.kind not in ("point", "data")]
        if not targets or items[: len(targets)] != targets:
            self._error(f"{node.kind.upper()} needs its targets before its options")
            return
        size = 2 if kind == "C" else 1
        if kind == "C" and node.kind in ("movei", "movet"):
            self._error(f"{node.kind.upper()} C does not exist", "write MOVE C with two points")
            return
        if kind == "P" and node.kind == "path":
            self._error("PATH P does not exist", "a path has lines and arcs: PATH L or PATH C")
            return
        if len(targets) % size:
            self._error(
                f"{node.kind.upper()} C needs two points for each arc: a point on the way, and the "
                "target"
            )
            return
        for at in range(0, len(targets), size):
            last = at + size == len(targets)
            own = [one for one in options if last or one.kind != "cont"]
            self._emit(node.kind, robot, kind, tuple(targets[at : at + size]), tuple(own))

    # --- helper methods ---

    def _emit(self, kind: str, *args: Any, jump: int = -1) -> int:
        self.code.append(Instruction(kind, args, self._line, jump))
        return len(self.code) - 1

    def _jump_here(self, at: int) -> None:
        self.code[at] = replace(self.code[at], jump=len(self.code))

    def _begin(self, kind: str) -> _Block:
        self._blocks.append(_Block(kind, self._line, len(self.code)))
        return self._blocks[-1]

    def _within(self, word: str, kind: str) -> _Block | None:
        """Return the innermost open block; report an error if the block is of another kind."""
        if self._blocks and self._blocks[-1].kind == kind:
            return self._blocks[-1]
        open_ = self._blocks[-1] if self._blocks else None
        if open_:
            hint = f"end {open_.kind} of line {open_.line} with {_ENDS[open_.kind]} before it"
        else:
            hint = f"add {kind} before it, or take it out"
        self._error(f"{word} without {kind}", hint)
        return None

    def _end(self, word: str, kind: str) -> _Block | None:
        block = self._within(word, kind)
        if block:
            self._blocks.pop()
        return block

    def _next_branch(self, block: _Block, word: str) -> None:
        if block.test < 0:
            self._error(f"{word} follows ELSE", "move it before ELSE")
            return
        first = block.kind == "SELECT" and self.code[block.test].kind == "jump"
        if not first:
            block.exits.append(self._emit("leave"))
        self._jump_here(block.test)
        block.test = -1

    def _close(self, block: _Block) -> None:
        for at in [block.test, *block.exits]:
            if at >= 0:
                self._jump_here(at)

    def _place(self, label: str) -> int:
        if label not in self.labels:
            self._error(f"there is no label {label}", f"write {label}: before a statement")
            return 0
        return self.labels[label]

    def _check_recursion(self) -> None:
        """Report each SUB that calls itself, directly or through another SUB."""
        calls = {name: set(self._calls_of(sub)) for name, sub in self.subs.items()}
        for name, sub in self.subs.items():
            reached: set[str] = set()
            todo = list(calls[name])
            while todo:
                other = todo.pop()
                if other not in reached:
                    reached.add(other)
                    todo += calls.get(other, ())
            if name in reached:
                self._line = self.code[sub.at].line if sub.at < len(self.code) else self._line
                self._error(f"SUB {name} calls itself", "use a loop instead")

    def _calls_of(self, sub: Subroutine) -> Iterator[str]:
        others = [other.at for other in self.subs.values() if other.at > sub.at]
        for one in self.code[sub.at : min(others, default=len(self.code))]:
            if one.kind == "call":
                yield one.args[0]

    def _error(self, message: str, hint: str = "") -> None:
        self._errors.append((self._line, InputError(message, hint=hint)))


def _hidden(name: str, at: int) -> Node:
    """Return a variable whose name cannot occur in a program."""
    return Node("variable", (f"{name}@{at}", None))


def _limits(block: _Block) -> tuple[Node, Node]:
    return _hidden("LIMIT", block.at), _hidden("STEP", block.at)
