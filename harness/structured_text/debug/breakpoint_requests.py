"""The requests of the protocol that set breakpoints or list the lines where breakpoints can be."""

from __future__ import annotations

import re
from functools import partial
from typing import TypeAlias

from structured_text.debug.breakpoints import Breakpoint, Counting, DataWatch, message_of
from structured_text.debug.debuggee import Debuggee, Requests, source_of, unverified
from structured_text.debug.devices import DeviceBreakpoint, Devices, next_line
from structured_text.debug.places import real_path
from structured_text.debug.protocol import Message
from structured_text.debug.values import Held
from structured_text.debug.view_requests import ViewRequests
from structured_text.errors import InputError, near
from structured_text.language import tree as t

__all__ = ["BreakpointRequests"]

_Lines: TypeAlias = tuple[str, ...]

#: A function breakpoint in a drawing: `Main rung 3`, `Main: network 3`, `Main, step Fill`.
_NETWORK = re.compile(r"\s*(?P<pou>\w+(?:\.\w+)*)\s*[\s:,]\s*(?P<network>\S.*)")


class BreakpointRequests(Requests):
    """Sets the breakpoints and watches of the debugger."""

    def __init__(self, run: Debuggee, views: ViewRequests) -> None:
        super().__init__(run)
        self._views = views
        self._numbers = 0
        self._of_lines: dict[str, list[Breakpoint]] = {}
        self._of_functions: list[Breakpoint] = []

    def _on_setBreakpoints(self, arguments: Message) -> Message:  # noqa: N802 (as the protocol)
        file = str(arguments.get("source", {}).get("path", ""))
        wanted = arguments.get("breakpoints")
        if wanted is None:
            wanted = [{"line": line} for line in arguments.get("lines", ())]
        made: list[Breakpoint] = []
        told = [self._line_breakpoint(file, one, made) for one in wanted]
        self._of_lines[real_path(file)] = made
        self._set()
        return {"breakpoints": told}

    def _line_breakpoint(self, file: str, wanted: Message, made: list[Breakpoint]) -> Message:
        line, devices = int(wanted["line"]) + 1 - self._run.base, self._run.machine.devices
        shown: Message = {}
        try:
            if devices is not None and devices.lines(file):
                at = next_line(devices, file, line)
                if at is not None:
                    made.append(self._of_device(devices, wanted, file, at))
                    if at != line:
                        shown["message"] = f"moved from line {line} to the next statement"
            elif self._run.places.is_source(file):
                found = self._run.places.line(file, line)
                at = found and found[0]
                if found is not None:
                    made.append(self._of_pous(wanted, *found))
            else:
                text = f"the running program has no declaration in {file}"
                raise InputError(f"{text}, and no device of the cell runs it" if devices else text)
        except InputError as error:
            return unverified(str(error))
        if at is None:
            return unverified("there is no statement from this line on")
        shown |= {"line": at - 1 + self._run.base, "source": source_of(file)}
        return {"id": self._numbers, "verified": True, **shown}

    def _of_pous(
        self,
        wanted: Message,
        at: int,
        pous: _Lines,
        *,
        entry: bool = False,
        code: frozenset[int] | None = None,
    ) -> Breakpoint:
        """Return a breakpoint at a line of POUs.

        With `code`, it is at these lines of the Python module.
        """
        conditions, messages = {}, {}
        run = self._run
        for key in pous:
            pou = run.places.project.pous[key]
            if text := wanted.get("condition"):
                conditions[key] = run.expressions.condition(pou, text)
            if text := wanted.get("logMessage"):
                messages[key] = message_of(text, partial(run.expressions.compiled, pou))
        counting = _counting(wanted)
        lines = {key: run.places.code_lines(key, at) if code is None else code for key in pous}
        self._numbers += 1
        return Breakpoint(self._numbers, lines, conditions, counting, messages, entry)

    def _of_device(self, devices: Devices, wanted: Message, file: str, at: int) -> Breakpoint:
        """Return a breakpoint in the program of a device.

        The condition of the breakpoint is written in the language of the device.
        """
        if wanted.get("logMessage"):
            hint = "remove it; a condition or a number of hits works there"
            text = "logpoints are possible in Structured Text only, not in the program of a device"
            raise InputError(text, hint=hint)
        holds = devices.condition(wanted["condition"]) if wanted.get("condition") else None
        counting = _counting(wanted)
        self._numbers += 1
        return DeviceBreakpoint(
            self._numbers, {}, counting=counting, file=real_path(file), line=at, holds=holds
        )

    def _on_setFunctionBreakpoints(self, arguments: Message) -> Message:  # noqa: N802
        self._of_functions = []
        told = []
        for wanted in arguments.get("breakpoints", ()):
            try:
                pou, at, code = self._named(str(wanted.get("name", "")))
                key, entry = pou.name.upper(), code is None
                made = self._of_pous(wanted, at, (key,), entry=entry, code=code)
                self._of_functions.append(made)
            except InputError as error:
                told.append(unverified(str(error)))
                continue
            shown = {"line": at - 1 + self._run.base, "source": source_of(pou.file)}
            told.append({"id": self._numbers, "verified": True, **shown})
        self._set()
        return {"breakpoints": told}

    def _named(self, name: str) -> tuple[t.Pou, int, frozenset[int] | None]:
        """Return the POU of a function breakpoint, and the line at which the breakpoint stops.

        The name of the POU may be followed by a rung or network, as in `Main rung 3`. Then the
        last value has the lines of the Python module at which the breakpoint stops. Raise
        InputError if there is no such POU or network.
        """
        places = self._run.places
        pou = places.project.pous.get(name.strip().upper())
        if pou is not None and pou.body:
            return pou, places.first_line(pou), None
        found = _NETWORK.fullmatch(name)
        key = found["pou"].upper() if found is not None else ""
        networks = places.networks(key)
        if found is None or not networks:
            raise InputError(f"there is no POU {name} with statements")
        wanted = " ".join(found["network"].upper().split())
        for network, (at, code) in networks.items():
            words = network.upper().split()
            if wanted in (" ".join(words), words[-1]):
                return places.project.pous[key], at, code
        raise InputError(
            f"{places.project.pous[key].name} has no {found['network'].strip()} with statements",
            hint=near(found["network"], networks, "it has"),
        )

    def _set(self) -> None:
        every = [one for some in self._of_lines.values() for one in some]
        self._run.debugger.breakpoints = [*every, *self._of_functions]

    def _on_setExceptionBreakpoints(self, arguments: Message) -> Message:  # noqa: N802
        options = [one.get("filterId") for one in arguments.get("filterOptions", ())]
        self._run.debugger.rules = "rules" in (*arguments.get("filters", ()), *options)
        return {}

    def _on_breakpointLocations(self, arguments: Message) -> Message:  # noqa: N802
        file, shift = str(arguments["source"].get("path", "")), 1 - self._run.base
        first = int(arguments["line"]) + shift
        last = int(arguments["endLine"]) + shift if "endLine" in arguments else first
        devices = self._run.machine.devices
        lines = self._run.places.lines(file, first, last)
        if devices is not None:
            lines = lines or [line for line in devices.lines(file) if first <= line <= last]
        return {"breakpoints": [{"line": line - shift} for line in lines]}

    def _on_dataBreakpointInfo(self, arguments: Message) -> Message:  # noqa: N802
        name = str(arguments["name"])
        reference = arguments.get("variablesReference")
        if reference:
            item, frame = self._views.opened(reference, name, arguments)
            text = (item.path if isinstance(item, Held) else "") or name
        else:
            frame, text = self._views.frame(arguments), name
        try:
            data = self._run.console.lasting(frame, text)
        except InputError as error:
            return {"dataId": None, "description": str(error)}
        return {
            "dataId": data,
            "description": f"{data} changes",
            "accessTypes": ["write"],
            "canPersist": True,
        }

    def _on_setDataBreakpoints(self, arguments: Message) -> Message:  # noqa: N802
        watches: list[DataWatch] = []
        told = []
        for wanted in arguments.get("breakpoints", ()):
            try:
                if wanted.get("accessType", "write") == "read":
                    raise InputError("only changes can be watched", hint="break on write")
                self._numbers += 1
                watches.append(self._run.console.watch(str(wanted["dataId"]), self._numbers))
                told.append({"id": self._numbers, "verified": True})
            except InputError as error:
                told.append(unverified(str(error)))
        for one in watches:
            one.begin()
        self._run.debugger.watches = watches
        return {"breakpoints": told}


def _counting(wanted: Message) -> Counting | None:
    return Counting.of(wanted["hitCondition"]) if wanted.get("hitCondition") else None
