"""The view of the current moment for the client: the stack, and the variables in scopes."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import FrameType
from typing import Any

from structured_text.debug.machine import Machine
from structured_text.debug.places import Places
from structured_text.debug.tracer import Tracer
from structured_text.debug.values import Held, Item, ProgramVariables, Text, local
from structured_text.language import tree as t
from structured_text.language.source import NetworkLine
from structured_text.output.units import format_us

__all__ = ["Frame", "Scopes"]

#: Greatest length of a statement in the title of a call [characters].
_LONGEST = 60


@dataclass
class Frame:
    """A call of a POU, or a program between two scans.

    Attributes:
        title: Name of the call in the stack.
        line: Current line.
        instance: The object of the block instance or program; None for a function.
        variables: Variables of the call, as Python names them.
        store: A function that sets one of these variables.
        path: Path of the instance; empty for a function.
    """

    pou: t.Pou
    title: str
    line: int
    instance: Any
    variables: dict[str, Any]
    store: Callable[[str, Any], None]
    path: str = ""


class Scopes:
    """The stack and the scopes of a machine."""

    def __init__(self, machine: Machine, places: Places, memory: ProgramVariables) -> None:
        self._machine, self._places, self._memory = machine, places, memory
        self._project = places.project

    # --- the stack ---

    def threads(self) -> list[tuple[int, str]]:
        """Return the programs, each with its task, in order of execution.

        The client shows each program as a thread.
        """
        tasks = {
            name: f" (task {task.name}, {format_us(task.interval_us)})"
            for task in self._project.tasks
            for name in task.instances
        }
        names = list(dict.fromkeys(run.instance for run in self._project.schedule))
        return [(number, f"{name}{tasks.get(name, '')}") for number, name in enumerate(names, 1)]

    def running(self, tracer: Tracer) -> int:
        """Return the thread that runs a scan; between two scans, the first thread."""
        if not tracer.stack:
            return 1
        instance = tracer.stack[0].frame.f_locals.get("s")
        names = list(dict.fromkeys(run.instance for run in self._project.schedule))
        found = [k for k, name in enumerate(names, 1) if self._memory.roots[name] is instance]
        return found[0] if found else 1

    def stack(self, tracer: Tracer, thread: int) -> list[Frame]:
        """Return the calls of a thread, the innermost first."""
        if not tracer.stack or self.running(tracer) != thread:
            return [self._between(thread)]
        frames: list[Frame] = []
        for depth, entry in enumerate(tracer.stack, 1):
            variables = dict(entry.frame.f_locals)
            variables["g"] = self._memory.shared
            instance = variables.get("s")
            pou = entry.code.pou
            path = self._memory.path(instance) if instance is not None else ""
            title = f"{path} ({pou.name})" if path else f"{pou.name}()"
            line = entry.line or self._places.first_line(pou)
            title += _network(line)
            store = _storing(tracer, depth, variables)
            frames.append(Frame(pou, title, line, instance, variables, store, path))
        return frames[::-1]

    def _between(self, thread: int) -> Frame:
        names = list(dict.fromkeys(run.instance for run in self._project.schedule))
        name = names[min(thread, len(names)) - 1]
        block = self._project.instances[name]
        pou = self._project.pous[block.name.upper()]
        instance = self._memory.roots[name]
        variables = {"s": instance, "g": self._memory.shared}
        title = f"{name} ({pou.name}), between two scans"
        line = self._places.last_line(pou) if self._machine.scans else self._places.first_line(pou)
        return Frame(pou, title, line, instance, variables, variables.__setitem__, name)

    # --- variables of a frame ---

    def locals(self, frame: Frame) -> list[Item]:
        """Return the variables of a POU other than its inputs and outputs."""
        return self._of(frame, ("VAR", "VAR_TEMP", "RESULT"))

    def pins(self, frame: Frame) -> list[Item]:
        """Return the inputs and outputs of a POU."""
        return self._of(frame, ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT"))

    def globals(self) -> list[Item]:
        """Return the global variables."""
        symbols = self._project.global_symbols
        programs = {block.name.upper() for block in self._project.instances.values()}
        return [self._memory.of_global(one) for key, one in symbols.items() if key not in programs]

    def _of(self, frame: Frame, sections: Sequence[str]) -> list[Item]:
        found: list[Item] = []
        symbols = [one for one in frame.pou.symbols.values() if not one.name.startswith(" ")]
        if frame.pou.result is not None:
            symbols.append(frame.pou.result)
        for symbol in symbols:
            if symbol.section in sections or (symbol.section == "VAR_EXTERNAL" == sections[-1]):
                one = self.variable(frame, symbol)
                if one is not None:
                    found.append(one)
        return found

    def variable(self, frame: Frame, symbol: t.Symbol) -> Held | None:
        """Return a variable of a frame; None if the variable has no value yet."""
        if symbol.name.upper() in frame.variables:
            return local(frame.variables, symbol, frame.store)
        return self._memory.of_symbol(symbol, frame.instance)

    def moment(self, step: int) -> list[Item]:
        """Return the scan, statement, time and broken rules of the current moment for display."""
        machine = self._machine
        broken = [Text(format_us(one.t_us), one.text) for one in machine.violations]
        return [
            Text("scans", str(machine.scans)),
            Text("statement", str(step) if step else "between two scans"),
            Text("time", format_us(machine.now_us)),
            Text("broken rules", str(len(broken)), "", lambda: list(broken))
            if broken
            else Text("broken rules", "none"),
        ]


def _network(line: int) -> str:
    """Return the rung or network of a statement, and its translation, for the title of a call."""
    if not isinstance(line, NetworkLine):
        return ""
    text = line.text.rstrip(";")
    text = text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
    return f", {line.network}: {text}"


def _storing(tracer: Tracer, depth: int, variables: dict[str, Any]) -> Callable[[str, Any], None]:
    """Return a function that sets a variable of the call at this depth of the stack.

    The function finds the frame by its depth, so it stays valid if the run comes back to this
    moment.
    """

    def store(name: str, value: Any) -> None:
        frame: FrameType = tracer.stack[depth - 1].frame
        if in_list := isinstance(value, list):
            frame.f_locals[name][:] = value
        else:
            frame.f_locals[name] = value
        if not in_list and sys.version_info < (3, 13):
            # Before Python 3.13 f_locals is a copy. This call writes the copy back to the frame.
            ctypes.pythonapi.PyFrame_LocalsToFast(ctypes.py_object(frame), ctypes.c_int(0))
        if not in_list:
            variables[name] = value

    return store
