"""The debug console: expressions, assignments, watched variables, and commands with a dot."""

from __future__ import annotations

import re
from itertools import zip_longest
from typing import Any

from structured_text.debug.breakpoints import DataWatch
from structured_text.debug.debugger import Debugger
from structured_text.debug.drawings import drawing_of
from structured_text.debug.orders import Back, Forward, Order
from structured_text.debug.scopes import Frame, Scopes
from structured_text.debug.values import Held, ProgramVariables, local, refuse_set
from structured_text.debug.watch_expressions import WatchExpressions
from structured_text.engines.builtin.storage import is_scalar
from structured_text.errors import InputError
from structured_text.language import tree as t
from structured_text.language.displayed import value_text
from structured_text.language.paths import resolve
from structured_text.language.types import ArrayType

__all__ = ["Console"]

_HELP = """\
X, X + 1 > 3          what an expression of Structured Text gives here
X := 5                set a variable
.scan 10, .scan -10   go so many scans forwards or back
.goto 120             go to the scan with this number
.back X               go back to the statement that changed X last
.back                 go back to the last breakpoint
.start                go to the start of the run
.where                where the PLC stands, and each task of its devices
.draw                 the rung or network of this statement, with what has power
.inject link_down 1   trigger an event, as in a stimulus; with several robots, say which one"""

_LAST = re.compile(r"(?:(?P<base>[^\W\d][\w.]*(?:\[[^\]]*\][\w.]*)*)\.)?(?P<name>\w*)$")


class Console:
    """An interpreter for the user's input in the debug console."""

    def __init__(
        self,
        debugger: Debugger,
        expressions: WatchExpressions,
        memory: ProgramVariables,
        scopes: Scopes,
    ) -> None:
        self._debugger, self._expressions, self._memory = debugger, expressions, memory
        self._scopes = scopes
        self._machine = debugger.player.machine
        self._project = self._machine.program.module.project

    # --- expressions ---

    def look(self, frame: Frame, text: str) -> Held:
        """Evaluate an expression in a frame; return a variable or a value.

        A path from a program on (`Main.Servo.Busy`) is valid in every frame. Raise InputError if
        the text is not an expression, or has no value.
        """
        try:
            compiled = self._expressions.compiled(frame.pou, text)
            found = self._variable(frame, compiled.node, text)
        except InputError as error:
            absolute = self._absolute(text)
            if absolute is None:
                raise error from None
            return absolute
        if found is not None:
            return found
        value = compiled.value(frame.variables)
        return Held(text, compiled.type, lambda: value)

    def place(self, frame: Frame, text: str) -> Held:
        """Return the variable that an expression names, or raise InputError if it cannot be set."""
        found = self.look(frame, text)
        if found.set is None:
            raise refuse_set(found)
        return found

    def _absolute(self, text: str) -> Held | None:
        try:
            return self._memory.at(resolve(self._project, text))
        except InputError:
            return None

    def _variable(self, frame: Frame, node: t.Expression, text: str) -> Held | None:
        """Return the variable that a checked expression names; None if it is not a variable."""
        if isinstance(node, t.Use):
            return self._named(frame, node.symbol)
        if isinstance(node, t.Member):
            base = self._variable(frame, node.base, text)
            parts = self._memory.parts(base) if base is not None else []
            found = [one for one in parts if one.name.upper() == node.name.upper()]
            return found[0] if found else None
        if isinstance(node, t.Index):
            base = self._variable(frame, node.base, text)
            return None if base is None else self._element(frame, base, node, text)
        return None

    def _named(self, frame: Frame, symbol: t.Symbol) -> Held | None:
        key = symbol.name.upper()
        if key in frame.variables:
            return local(frame.variables, symbol, frame.store)
        return self._memory.of_symbol(symbol, frame.instance)

    def _element(self, frame: Frame, base: Held, node: t.Index, text: str) -> Held:
        kind, held = base.type, base.get()
        assert isinstance(kind, ArrayType)
        bounds = held.bounds if kind.open else kind.bounds
        items = held.held if kind.open else held
        indices = [
            int(self._expressions.of_node(frame.pou, one, text).value(frame.variables))
            for one in node.indices
        ]
        position = 0
        for index, (low, high) in zip_longest(indices, bounds):
            if not low <= index <= high:
                raise InputError(f"{text}: the index {index} is not in {low}..{high}")
            position = position * (high - low + 1) + index - low
        name = f"[{','.join(map(str, indices))}]"
        return self._memory.element(items, position, name, f"{base.path}{name}", kind.element)

    # --- setting ---

    def put(self, frame: Frame, of: Held, text: str) -> str:
        """Assign an expression to a variable; return a note for the user, or an empty text.

        Raises:
            InputError: The value does not fit the variable's type, or the variable cannot be set.
        """
        if of.set is None:
            raise refuse_set(of)
        value: Any = self._expressions.compiled(frame.pou, text, of.type).value(frame.variables)
        put = of.set
        return self._changed(lambda: put(value))

    def _changed(self, apply: Any) -> str:
        later = self._debugger.edit(apply)
        return "the scans after this one were discarded" if later else ""

    # --- watching ---

    def lasting(self, frame: Frame, text: str) -> str:
        """Return the full path of a variable that is named in a frame.

        Raise InputError if the variable does not keep its value from scan to scan.
        """
        found = self.look(frame, text)
        first, _, _ = re.split(r"([.\[])", f"{found.path}.", maxsplit=1)
        rest = found.path[len(first) :]
        candidates = [found.path]
        if frame.path:
            candidates.insert(0, f"{frame.path}.{found.path}")
        passed = frame.variables.get(first.upper())
        if passed is not None and (base := self._memory.path(passed)):
            candidates.insert(0, f"{base}{rest}")
        for one in candidates if found.path else []:
            try:
                return resolve(self._project, one).path
            except InputError:
                continue
        raise InputError(f"{text} is not a variable that lasts from scan to scan")

    def watch(self, path: str, number: int) -> DataWatch:
        """Return a watch for a variable; raise InputError if the variable cannot be watched."""
        found = self._memory.at(resolve(self._project, path))
        if is_scalar(found.type):
            return DataWatch(
                number, path, found.get, lambda held: self._memory.text(found.type, held)
            )
        program = self._machine.program
        return DataWatch(
            number, path, lambda: program.read(path), lambda value: value_text(found.type, value)
        )

    # --- commands ---

    def command(self, frame: Frame, text: str) -> Order | str:
        """Execute an assignment, or a command that begins with a dot.

        Raise InputError if the text is neither.

        Returns:
            An order for the debugger, or the text to print.
        """
        if not text.startswith("."):
            target, _, value = text.rstrip("; ").partition(":=")
            of = self.place(frame, target.strip())
            said = self.put(frame, of, value.strip())
            return f"{of.path} = {self._memory.shown(of).text}" + (f"; {said}" if said else "")
        word, *rest = text[1:].split(maxsplit=1)
        argument = rest[0].strip() if rest else ""
        if word == "back":
            if not argument:
                return Back("continue")
            return Back("change", watch=self.watch(self.lasting(frame, argument), 0))
        if word == "start":
            return Back("start")
        if word == "scan":
            number = _number(argument or "1", ".scan 10")
            return Forward("scan", number) if number > 0 else Back("scan", -number)
        if word == "goto":
            return self._goto(_number(argument, ".goto 120"))
        if word == "inject":
            return self._inject(argument)
        if word == "where":
            return self.positions()
        if word == "draw":
            return self._drawing(frame)
        if word == "help":
            return _HELP
        raise InputError(f"there is no command .{word}", hint=".help lists them")

    def positions(self) -> str:
        """Return one line with the position of the PLC, and one for each task of a device."""
        tracer = self._debugger.player.tracer
        thread = self._scopes.running(tracer)
        frame = self._scopes.stack(tracer, thread)[0]
        place = f", line {frame.line}" if tracer.stack else ""
        devices = self._machine.devices
        lines = [f"{self._debugger.where()}: PLC: {frame.title}{place}"]
        return "\n    ".join([*lines, *(devices.positions if devices is not None else ())])

    def _drawing(self, frame: Frame) -> str:
        return drawing_of(
            self._project,
            frame,
            lambda text: self.look(frame, text),
            lambda held: self._memory.shown(held).text,
        )

    def _goto(self, number: int) -> Order:
        """Return the order that goes to a scan; for the user, the first scan is number 1."""
        now = self._debugger.player.now
        if number > now.scan + 1 or (number == now.scan + 1 and not now.step):
            return Forward("scan", number - 1 - now.scan)
        return Back("scan", now.scan - max(0, number - 1))

    def _inject(self, argument: str) -> str:
        if self._debugger.player.tracer.device is not None:
            hint = "go to a statement of the PLC first: .scan 1"
            raise InputError("a device is in the middle of its cycle", hint=hint)
        event, *which = argument.split()
        device = _number(which[0], ".inject link_down 2") if which else 1
        said = self._changed(lambda: self._machine.inject(event, device))
        return f"{event} at {self._debugger.where()}" + (f"; {said}" if said else "")

    # --- completing ---

    def completions(self, frame: Frame, text: str) -> list[tuple[str, str]]:
        """Return names that can complete the input, each with its kind in the protocol."""
        found = _LAST.search(text)
        if found is None:
            return []
        base, begin = found["base"], found["name"].upper()
        if base is None:
            names = self._expressions.names(frame.pou)
            names += [name for name in self._memory.roots if name not in names]
        else:
            try:
                names = [one.name for one in self._memory.parts(self.look(frame, base))]
            except InputError:
                return []
        kind = "variable" if base is None else "field"
        return [
            (name, kind)
            for name in names
            if name.upper().startswith(begin) and not name.startswith("[")
        ]


def _number(text: str, example: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise InputError(f"{text!r} is not a number", hint=f"write {example}") from None
