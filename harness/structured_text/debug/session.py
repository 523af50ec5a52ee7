"""The debug adapter: the requests of the protocol, answered by the debugger.

https://microsoft.github.io/debug-adapter-protocol/specification
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from structured_text.debug.breakpoints import Breakpoint, Counting, DataWatch, message_of
from structured_text.debug.console import Console
from structured_text.debug.debugger import Back, Debugger, Forward, Order, Quit, Stop
from structured_text.debug.machine import Machine
from structured_text.debug.places import Places
from structured_text.debug.player import Player
from structured_text.debug.protocol import Client, Message
from structured_text.debug.scopes import Frame, Scopes
from structured_text.debug.values import Held, Item, ProgramVariables, Text
from structured_text.debug.watch_expressions import WatchExpressions
from structured_text.errors import COMMAND, InputError

__all__ = ["Launched", "Session"]

_CAPABILITIES = {
    "supportsConfigurationDoneRequest": True,
    "supportsConditionalBreakpoints": True,
    "supportsHitConditionalBreakpoints": True,
    "supportsLogPoints": True,
    "supportsFunctionBreakpoints": True,
    "supportsDataBreakpoints": True,
    "supportsBreakpointLocationsRequest": True,
    "supportsStepBack": True,
    "supportsSetVariable": True,
    "supportsSetExpression": True,
    "supportsEvaluateForHovers": True,
    "supportsCompletionsRequest": True,
    "supportsExceptionInfoRequest": True,
    "supportsTerminateRequest": True,
    "supportTerminateDebuggee": True,
    "completionTriggerCharacters": ["."],
    "exceptionBreakpointFilters": [
        {
            "filter": "rules",
            "label": "Broken rules",
            "description": "Stop behind the scan in which a rule of the manual is broken",
            "default": True,
        }
    ],
}


@dataclass(frozen=True)
class Launched:
    """A run that a client has launched.

    Attributes:
        machine: The machine to debug.
        notice: Lines to print at the start.
        last: Reason of the end of a recording: begin at its end with this text; empty to begin at
            the start.
    """

    machine: Machine
    notice: str = ""
    last: str = ""


class Session:
    """One client with one run.

    `launch` builds the machine from the arguments of `launch` or `attach`.
    """

    def __init__(self, client: Client, launch: Callable[[Mapping[str, Any]], Launched]) -> None:
        self._client, self._launch = client, launch
        self._launched: Launched | None = None
        self._configured = self._left = False
        self._arguments: Mapping[str, Any] = {}
        self._base = 1  # number of the client's first line
        self._stopped: Stop | None = None
        self._frames: list[Frame] = []
        self._opened: list[Callable[[], list[Item]]] = []
        self._held: list[Held | None] = []
        self._scope_frames: dict[int, Frame] = {}
        self._numbers = 0
        self._of_lines: dict[str, list[Breakpoint]] = {}
        self._of_functions: list[Breakpoint] = []
        self._exit = 0

    # --- the run ---

    def run(self) -> int:
        """Serve until the client leaves.

        Returns:
            The exit code: 0, or 2 if nothing could be debugged.
        """
        try:
            while self._launched is None or not self._configured:
                message = self._client.next(wait=True)
                if message is not None and isinstance(self._handle(message), Quit):
                    return self._exit
            self._debugger.run(self._first())
            self._client.event("terminated")
            self._client.event("exited", {"exitCode": self._exit})
            while not self._left and (message := self._client.next(wait=True)) is not None:
                self._handle(message)
        except EOFError:
            pass
        finally:
            if self._launched is not None:
                self._launched.machine.close()
        return self._exit

    def _first(self) -> Order:
        assert self._launched is not None
        if self._launched.last:
            self._to_the_end()
            return self.wait(Stop("exception", self._launched.last))
        return Forward("in") if self._arguments.get("stopOnEntry") else Forward()

    def _to_the_end(self) -> None:
        """Run the recording up to its end."""
        assert self._launched is not None
        machine = self._launched.machine
        while not machine.ended and not self.poll():
            try:
                self._player.plain()
            except InputError as error:
                self._client.say(str(error), "important")
                self._player.seek(machine.scans)
                return

    def _build(self, arguments: Mapping[str, Any]) -> None:
        self._launched = self._launch(arguments)
        machine = self._launched.machine
        self._arguments = arguments
        program = machine.program
        self._places = Places(program)
        self._memory = ProgramVariables(program)
        self._player = Player(machine, self._places)
        self._scopes = Scopes(machine, self._places, self._memory)
        self._expressions = WatchExpressions(program.module.project, program.module.names)
        self._debugger = Debugger(self._player, self._memory, self)
        self._console = Console(self._debugger, self._expressions, self._memory)

    # --- for the debugger ---

    def wait(self, stop: Stop) -> Order:
        """Report a stop to the client, and answer requests until one of them is an order."""
        self._stopped = stop
        self._frames, self._opened, self._held, self._scope_frames = [], [], [], {}
        tracer = self._player.tracer
        body: dict[str, Any] = {
            "reason": stop.reason,
            "threadId": self._scopes.running(tracer),
            "allThreadsStopped": True,
        }
        where = self._debugger.where()
        body["description"] = f"{stop.text or stop.reason} ({where})"
        if stop.text:
            body["text"] = stop.text
        if hits := [number for number in stop.hits if number]:
            body["hitBreakpointIds"] = hits
        self._client.event("stopped", body)
        if stop.text and stop.reason != "exception":
            self._client.say(f"{where}: {stop.text}")
        try:
            while True:
                message = self._client.next(wait=True)
                order = self._handle(message) if message is not None else None
                if order is not None:
                    return order
        except EOFError:
            return Quit()
        finally:
            self._stopped = None

    def poll(self) -> Quit | None:
        """Answer the requests that have arrived while the program runs."""
        try:
            while (message := self._client.next(wait=False)) is not None:
                if isinstance(self._handle(message), Quit):
                    return Quit()
        except EOFError:
            return Quit()
        return None

    def log(self, text: str) -> None:
        """Print the message of a logpoint."""
        self._client.say(text)

    # --- requests ---

    def _handle(self, message: Message) -> Order | None:
        if message.get("type") != "request":
            return None
        command = message.get("command", "")
        if not isinstance(command, str):
            self._client.refuse(message, "the command of a request is not a text")
            return None
        name = command.removeprefix(f"{COMMAND}/")
        handler = getattr(self, f"_on_{name}", None) if name.isidentifier() else None
        if handler is None:
            self._client.refuse(
                message, f"{COMMAND} debug does not know the request {command[:60]!r}"
            )
            return None
        arguments = message.get("arguments") or {}
        if not isinstance(arguments, dict):
            self._client.refuse(message, f"the arguments of {command!r} are not an object")
            return None
        if name not in _ALWAYS and self._launched is None:
            self._client.refuse(message, "nothing is debugged yet: launch comes first")
            return None
        if name not in _RUNNING and self._stopped is None:
            self._client.refuse(message, "the program runs: pause it first")
            return None
        try:
            body = handler(arguments)
        except InputError as error:
            self._client.refuse(message, str(error))
            if name in ("launch", "attach"):
                self._exit = 2
                self._client.event("terminated")
            return None
        except _MISTYPED:
            self._client.refuse(
                message, f"the arguments of {command!r} are not as the protocol says"
            )
            return None
        order = body if isinstance(body, (Forward, Back, Quit)) else None
        answered: Message | None = None
        if name == "continue":
            answered = {"allThreadsContinued": True}
        elif name == "evaluate":
            answered = {"result": "", "variablesReference": 0}
        self._client.answer(message, answered if order is not None else body)
        if name in ("launch", "attach"):
            self._client.event("initialized")
            assert self._launched is not None
            if self._launched.notice:
                self._client.say(self._launched.notice)
        if isinstance(order, (Forward, Back)) and name in ("evaluate", "backToChange", "stepScan"):
            self._client.event("continued", {"threadId": 1, "allThreadsContinued": True})
        return order

    def _on_initialize(self, arguments: Message) -> Message:
        self._base = 1 if arguments.get("linesStartAt1", True) else 0
        return dict(_CAPABILITIES)

    def _on_launch(self, arguments: Message) -> None:
        if self._launched is not None:
            raise InputError("there is a run already", hint="one client debugs one run")
        self._build(arguments)

    _on_attach = _on_launch

    def _on_configurationDone(self, _: Message) -> None:  # noqa: N802 (as the protocol has it)
        self._configured = True

    def _on_disconnect(self, _: Message) -> Quit:
        self._left = True
        return Quit()

    def _on_terminate(self, _: Message) -> Quit:
        return Quit()

    def _on_pause(self, _: Message) -> None:
        self._debugger.pausing = True

    # --- breakpoints ---

    def _on_setBreakpoints(self, arguments: Message) -> Message:  # noqa: N802
        file = str(arguments.get("source", {}).get("path", ""))
        wanted = arguments.get("breakpoints")
        if wanted is None:
            wanted = [{"line": line} for line in arguments.get("lines", ())]
        made: list[Breakpoint] = []
        told = [self._line_breakpoint(file, one, made) for one in wanted]
        self._of_lines[os.path.normcase(os.path.realpath(file))] = made
        self._set()
        return {"breakpoints": told}

    def _line_breakpoint(self, file: str, wanted: Message, made: list[Breakpoint]) -> Message:
        line = int(wanted["line"]) + 1 - self._base
        if not self._places.is_source(file):
            return _unverified(f"the running program has no declaration in {file}")
        found = self._places.line(file, line)
        if found is None:
            return _unverified("there is no statement from this line on")
        at, pous = found
        try:
            made.append(self._breakpoint(wanted, at, pous))
        except InputError as error:
            return _unverified(str(error))
        shown = {"line": at - 1 + self._base, "source": _source(file)}
        return {"id": self._numbers, "verified": True, **shown}

    def _breakpoint(
        self, wanted: Message, at: int, pous: tuple[str, ...], *, entry: bool = False
    ) -> Breakpoint:
        conditions, messages = {}, {}
        for key in pous:
            pou = self._places.project.pous[key]
            if text := wanted.get("condition"):
                conditions[key] = self._expressions.condition(pou, text)
            if text := wanted.get("logMessage"):
                messages[key] = message_of(text, partial(self._expressions.compiled, pou))
        counting = Counting.of(wanted["hitCondition"]) if wanted.get("hitCondition") else None
        lines = {key: self._places.code_lines(key, at) for key in pous}
        self._numbers += 1
        return Breakpoint(self._numbers, lines, conditions, counting, messages, entry)

    def _on_setFunctionBreakpoints(self, arguments: Message) -> Message:  # noqa: N802
        self._of_functions = []
        told = []
        for wanted in arguments.get("breakpoints", ()):
            key = str(wanted.get("name", "")).strip().upper()
            pou = self._places.project.pous.get(key)
            if pou is None or not pou.body:
                told.append(_unverified(f"there is no POU {wanted.get('name')} with statements"))
                continue
            at = self._places.first_line(pou)
            try:
                self._of_functions.append(self._breakpoint(wanted, at, (key,), entry=True))
            except InputError as error:
                told.append(_unverified(str(error)))
                continue
            shown = {"line": at - 1 + self._base, "source": _source(pou.file)}
            told.append({"id": self._numbers, "verified": True, **shown})
        self._set()
        return {"breakpoints": told}

    def _set(self) -> None:
        every = [one for some in self._of_lines.values() for one in some]
        self._debugger.breakpoints = [*every, *self._of_functions]

    def _on_setExceptionBreakpoints(self, arguments: Message) -> Message:  # noqa: N802
        options = [one.get("filterId") for one in arguments.get("filterOptions", ())]
        self._debugger.rules = "rules" in (*arguments.get("filters", ()), *options)
        return {}

    def _on_breakpointLocations(self, arguments: Message) -> Message:  # noqa: N802
        file, shift = str(arguments["source"].get("path", "")), 1 - self._base
        first = int(arguments["line"]) + shift
        last = int(arguments["endLine"]) + shift if "endLine" in arguments else first
        lines = self._places.lines(file, first, last)
        return {"breakpoints": [{"line": line - shift} for line in lines]}

    def _on_dataBreakpointInfo(self, arguments: Message) -> Message:  # noqa: N802
        name = str(arguments["name"])
        reference = arguments.get("variablesReference")
        if reference:
            found = [one for one in self._of(reference)() if one.name == name]
            item = found[0] if found else None
            path = item.path if isinstance(item, Held) else ""
            frame = self._scope_frames.get(reference) or self._frame(arguments)
            text = path or name
        else:
            frame, text = self._frame(arguments), name
        try:
            data = self._console.lasting(frame, text)
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
                watches.append(self._console.watch(str(wanted["dataId"]), self._numbers))
                told.append({"id": self._numbers, "verified": True})
            except InputError as error:
                told.append(_unverified(str(error)))
        for one in watches:
            one.begin()
        self._debugger.watches = watches
        return {"breakpoints": told}

    # --- going on ---

    def _on_continue(self, _: Message) -> Order:
        return Forward()

    def _on_next(self, _: Message) -> Order:
        return Forward("over")

    def _on_stepIn(self, _: Message) -> Order:  # noqa: N802
        return Forward("in")

    def _on_stepOut(self, _: Message) -> Order:  # noqa: N802
        return Forward("out")

    def _on_stepScan(self, arguments: Message) -> Order:  # noqa: N802
        scans = int(arguments.get("scans", 1))
        return Forward("scan", scans) if scans > 0 else Back("scan", -scans)

    def _on_stepBack(self, _: Message) -> Order:  # noqa: N802
        return Back("step")

    def _on_reverseContinue(self, _: Message) -> Order:  # noqa: N802
        return Back("continue")

    def _on_backToChange(self, arguments: Message) -> Order:  # noqa: N802
        frame = self._frame(arguments)
        data = self._console.lasting(frame, str(arguments["variable"]))
        return Back("change", watch=self._console.watch(data, 0))

    # --- looking ---

    def _on_threads(self, _: Message) -> Message:
        return {"threads": [{"id": k, "name": name} for k, name in self._scopes.threads()]}

    def _on_stackTrace(self, arguments: Message) -> Message:  # noqa: N802
        frames = self._scopes.stack(self._player.tracer, int(arguments.get("threadId", 1)))
        first = int(arguments.get("startFrame") or 0)
        count = int(arguments.get("levels") or len(frames))
        shown = []
        for frame in frames[first : first + count]:
            self._frames.append(frame)
            line = frame.line - 1 + self._base
            shown.append(
                {
                    "id": len(self._frames),
                    "name": frame.title,
                    "line": line,
                    "column": self._base,
                    "source": _source(frame.pou.file),
                }
            )
        return {"stackFrames": shown, "totalFrames": len(frames)}

    def _frame(self, arguments: Message) -> Frame:
        """Return the requested frame; without a number the innermost one."""
        number = arguments.get("frameId")
        if number:
            if not 1 <= int(number) <= len(self._frames):
                raise IndexError(number)
            return self._frames[int(number) - 1]
        tracer = self._player.tracer
        return self._scopes.stack(tracer, self._scopes.running(tracer))[0]

    def _on_scopes(self, arguments: Message) -> Message:
        frame = self._frame(arguments)
        scopes = self._scopes
        every: list[tuple[str, Callable[[], list[Item]], str]] = [
            ("Inputs, outputs", lambda: scopes.pins(frame), "arguments"),
            ("Variables", lambda: scopes.locals(frame), "locals"),
            ("Globals", scopes.globals, ""),
            *((name, items, "") for name, items in self._player.machine.around),
            ("Run", lambda: scopes.moment(self._player.tracer.step), ""),
        ]
        shown = []
        for name, items, hint in every:
            if name in ("Inputs, outputs", "Globals") and not items():
                continue
            scope: dict[str, Any] = {"name": name, "expensive": not hint}
            scope["variablesReference"] = self._open(items)
            self._scope_frames[scope["variablesReference"]] = frame
            if hint:
                scope["presentationHint"] = hint
            shown.append(scope)
        return {"scopes": shown}

    def _open(self, items: Callable[[], list[Item]]) -> int:
        self._opened.append(items)
        self._held.append(None)
        return len(self._opened)

    def _of(self, reference: int) -> Callable[[], list[Item]]:
        """Return the getter of an opened item's parts; raise IndexError for a wrong number."""
        if not 1 <= reference <= len(self._opened):
            raise IndexError(reference)
        return self._opened[reference - 1]

    def _on_variables(self, arguments: Message) -> Message:
        reference = int(arguments["variablesReference"])
        opened, of = self._of(reference), self._held[reference - 1]
        frame = self._scope_frames.get(reference)
        if of is not None:
            first, count = int(arguments.get("start") or 0), int(arguments.get("count") or 0)
            items: list[Item] = list(self._memory.parts(of, first, count or None))
        else:
            items = opened()
        return {"variables": [self._variable(one, frame) for one in items]}

    def _variable(self, item: Item, frame: Frame | None) -> Message:
        if isinstance(item, Text):
            reference = 0 if item.below is None else self._open(item.below)
            hint = {"attributes": ["readOnly"]}
            return {
                "name": item.name,
                "value": item.text,
                "type": item.type,
                "variablesReference": reference,
                "presentationHint": hint,
            }
        shown = self._memory.shown(item)
        body = {"name": item.name, "value": shown.text, "type": shown.type}
        body |= self._below(item, frame)
        if item.path:
            body["evaluateName"] = item.path
        return body

    def _below(self, item: Held, frame: Frame | None) -> Message:
        shown = self._memory.shown(item)
        reference = 0
        if shown.named or shown.numbered:
            reference = self._open(lambda: list(self._memory.parts(item)))
            self._held[reference - 1] = item
            if frame is not None:
                self._scope_frames[reference] = frame
        body: Message = {"variablesReference": reference}
        if shown.numbered > _PAGED:
            body["indexedVariables"] = shown.numbered
        return body

    def _on_setVariable(self, arguments: Message) -> Message:  # noqa: N802
        reference, name = int(arguments["variablesReference"]), arguments["name"]
        found = [one for one in self._of(reference)() if one.name == name]
        if not found or not isinstance(found[0], Held):
            raise InputError(f"{name} is not a variable of the program and cannot be set")
        frame = self._scope_frames.get(reference) or self._frame({})
        return self._put(found[0], str(arguments["value"]), frame)

    def _on_setExpression(self, arguments: Message) -> Message:  # noqa: N802
        frame = self._frame(arguments)
        found = self._console.place(frame, str(arguments["expression"]))
        return self._put(found, str(arguments["value"]), frame)

    def _put(self, of: Held, text: str, frame: Frame) -> Message:
        self._client_says(self._console.put(frame, of, text))
        shown = self._memory.shown(of)
        return {"value": shown.text, "type": shown.type, **self._below(of, frame)}

    def _client_says(self, text: str) -> None:
        if text:
            self._client.say(text)

    def _on_evaluate(self, arguments: Message) -> Message | Order:
        text, context = str(arguments["expression"]).strip(), arguments.get("context", "")
        frame = self._frame(arguments)
        if context in ("repl", "") and (text.startswith(".") or ":=" in text):
            done = self._console.command(frame, text)
            if isinstance(done, (Forward, Back, Quit)):
                return done
            return {"result": done, "variablesReference": 0}
        found = self._console.look(frame, text)
        shown = self._memory.shown(found)
        return {"result": shown.text, "type": shown.type, **self._below(found, frame)}

    def _on_completions(self, arguments: Message) -> Message:
        frame = self._frame(arguments)
        column = int(arguments["column"]) - self._base
        found = self._console.completions(frame, str(arguments["text"])[:column])
        return {"targets": [{"label": label, "type": kind} for label, kind in found]}

    def _on_exceptionInfo(self, _: Message) -> Message:  # noqa: N802
        text = self._stopped.text if self._stopped is not None else ""
        return {"exceptionId": COMMAND, "description": text, "breakMode": "always"}

    def _on_source(self, _: Message) -> Message:
        raise InputError("only files have sources", hint="open them in the editor")

    def _on_loadedSources(self, _: Message) -> Message:  # noqa: N802
        files = dict.fromkeys(str(file) for file in self._places.project.files)
        return {"sources": [_source(file) for file in files]}


#: Arrays with more elements are shown in pages.
_PAGED = 100

#: Exceptions due to a request with arguments of wrong types, or nested too deep.
_MISTYPED = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)

#: Requests that need no program, and requests that are allowed while it runs.
_ALWAYS = ("initialize", "launch", "attach", "disconnect", "terminate", "configurationDone")
_RUNNING = (
    *_ALWAYS,
    *("setBreakpoints", "setFunctionBreakpoints", "setExceptionBreakpoints", "pause"),
    *("setDataBreakpoints", "breakpointLocations", "threads", "source", "loadedSources"),
)


def _source(file: str) -> Message:
    whole = os.path.abspath(file)
    return {"name": os.path.basename(whole), "path": whole}


def _unverified(text: str) -> Message:
    return {"verified": False, "message": text}
