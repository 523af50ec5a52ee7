"""The check of types in a robot program before it runs."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.robot.program.syntax import COORDINATES, SIGNATURES, Instruction, Node, Program
from structured_text.errors import InputError

__all__ = ["type_errors"]

_NUMBER, _TEXT, _POINT, _SHIFT, _HAND = "a number", "a text", "a point", "a shift", "a hand"
_KINDS = {"n": (_NUMBER,), "t": (_TEXT,), "p": (_POINT,), "e": (_POINT, _SHIFT, _HAND)}
_CALCULATIONS = ("add", "subtract", "multiply", "divide", "modulo", "power")
_ASSIGNED = {"port": _NUMBER, "point": _POINT, "shift": _SHIFT, "hand": _HAND}


def type_errors(program: Program) -> Iterator[tuple[int, InputError]]:
    """Yield each value of a wrong type, and each function or array that does not exist.

    Errors that depend on values are not reported here; the program gets an alarm when it runs.
    """
    arrays = {part.args[0] for one in program.code if one.kind == "dim" for part in one.args}
    arrays |= {name for sub in program.subs.values() for name in sub.parameters}
    for one in program.code:
        checker = _Checker(arrays, program.shared)
        checker.instruction(one)
        for error in checker.errors:
            yield one.line, error


class _Checker:
    """Collects the type errors of one instruction.

    With `shared` the instruction may use arrays that another program has declared.
    """

    def __init__(self, arrays: Collection[str], shared: bool) -> None:
        self._arrays, self._shared = arrays, shared
        self.errors: list[InputError] = []

    def instruction(self, one: Instruction) -> None:
        """Check all expressions of an instruction."""
        if one.kind == "assign":
            self._assignment(*one.args[-2:])
        elif one.kind not in ("dim", "for_next"):
            for part in one.args:
                self._part(part)

    def _part(self, part: object) -> None:
        if isinstance(part, tuple):
            for inner in part:
                self._part(inner)
        elif isinstance(part, Node):
            self.type_of(part)

    def _assignment(self, target: Node, source: Node) -> None:
        given = self.type_of(source)
        wanted = _ASSIGNED.get(target.kind, "")
        if target.kind == "variable":
            name, *indices = target.args
            has_index = any(index is not None for index in indices)
            if name in COORDINATES and has_index:
                wanted = _NUMBER
                self.type_of(target)
            elif name in SIGNATURES and name not in self._arrays:
                self._error(f"{name} is a function; it cannot be assigned", "use another name")
                return
            else:
                wanted = _TEXT if name.endswith("$") else _NUMBER
                if has_index:
                    self.type_of(target)
        if target.kind in ("shift", "hand") and source.kind == "data":
            return
        if given and wanted and given != wanted:
            hint = f"write {wanted}" + (", such as VAL(A$)" if given == _TEXT else "")
            self._error(f"{wanted} is needed here, but this is {given}", hint)

    def type_of(self, node: Node) -> str:
        """Return the type of an expression and record its errors; empty if the type is unknown."""
        kind, args = node.kind, node.args
        if kind == "text":
            return _TEXT
        if kind in ("point", "shift", "hand"):
            self._part(args)
            return {"point": _POINT, "shift": _SHIFT, "hand": _HAND}[kind]
        if kind == "data":
            return _POINT
        if kind in ("number", "port"):
            return _NUMBER
        if kind == "variable":
            return self._variable(args[0], [one for one in args[1:] if one is not None])
        if kind in _CALCULATIONS:
            return self._calculation(kind, *args)
        if kind == "compare":
            left, right = self.type_of(args[0]), self.type_of(args[2])
            if left and right and left != right:
                self._error(f"{left} is compared with {right}", "compare values of one type")
            return _NUMBER
        self._part(args)
        if kind in ("and_", "or_", "xor", "not_", "negative"):
            return _NUMBER
        return ""

    def _calculation(self, kind: str, left: Node, right: Node) -> str:
        first, second = self.type_of(left), self.type_of(right)
        if kind == "add" and _TEXT in (first, second) and first and second and first != second:
            self._error(f"{first} and {second} cannot be added", "write STR$(A) for a number")
            return ""
        alike = {"add": (_TEXT, _POINT, _SHIFT, _NUMBER), "subtract": (_POINT, _SHIFT, _NUMBER)}
        if first == second and first in alike.get(kind, ()):
            return first
        wrong = next((one for one in (first, second) if one and one != _NUMBER), "")
        if wrong:
            self._error(f"this operation is not possible with {wrong}", "use numbers")
            return ""
        return _NUMBER

    def _variable(self, name: str, given: list[Node]) -> str:
        types = [self.type_of(one) for one in given]
        if name in SIGNATURES and name not in self._arrays:
            arguments, result = SIGNATURES[name].split(":")
            least = sum(letter.islower() for letter in arguments)
            if not least <= len(given) <= len(arguments):
                noun = "argument" if len(arguments) == 1 else "arguments"
                count = len(arguments) or "no"
                self._error(f"{name} has {count} {noun}, and {len(given)} are given", "")
            else:
                for letter, one in zip(arguments.lower(), types, strict=False):
                    if one and one not in _KINDS[letter]:
                        wanted = " or ".join(_KINDS[letter])
                        self._error(f"{name} needs {wanted}, and this is {one}", "")
            return _KINDS[result][0]
        if given and name not in self._arrays and not self._shared:
            hint = f"write DIM {name}(10) before it, or correct the name of the function"
            self._error(f"there is no array or function {name}", hint)
        return _TEXT if name.endswith("$") else _NUMBER

    def _error(self, message: str, hint: str) -> None:
        self.errors.append(InputError(message, hint=hint))
