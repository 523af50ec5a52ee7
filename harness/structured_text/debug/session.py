"""The debug adapter: the requests of the protocol, answered by the debugger.

https://microsoft.github.io/debug-adapter-protocol/specification
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from structured_text.debug.breakpoint_requests import BreakpointRequests
from structured_text.debug.debuggee import Debuggee
from structured_text.debug.machine import Machine
from structured_text.debug.orders import Back, Forward, Order, Quit, Stop
from structured_text.debug.protocol import Client, Message
from structured_text.debug.view_requests import ViewRequests
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
            "description": "Stop after the scan in which a rule is broken",
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
        last: If it is not empty, the session begins at the end of the recording, and this text is
            the reason of the stop.
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
        self._base = 1  # number of the first line, as the client counts lines
        self._stopped: Stop | None = None
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
            self._run.debugger.run(self._first())
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
        """Run the recording up to its last scan."""
        assert self._launched is not None
        machine = self._launched.machine
        while not machine.ended and not self.poll():
            try:
                self._run.player.plain()
            except InputError as error:
                self._client.say(str(error), "important")
                self._run.player.seek(machine.scans)
                return

    def _build(self, arguments: Mapping[str, Any]) -> None:
        self._launched = self._launch(arguments)
        self._arguments = arguments
        self._run = Debuggee.of(self._launched.machine, self, self._base)
        self._views = ViewRequests(self._run, self._client.say)
        self._parts = (self._views, BreakpointRequests(self._run, self._views))

    # --- for the debugger ---

    def wait(self, stop: Stop) -> Order:
        """Report a stop to the client, and answer requests until one of them is an order."""
        self._stopped = stop
        self._views.forget()
        body: dict[str, Any] = {
            "reason": stop.reason,
            "threadId": self._views.thread,
            "allThreadsStopped": True,
        }
        where = self._run.debugger.where()
        if network := self._views.network:
            where = f"{where}, {network}"
        body["description"] = f"{stop.text or stop.reason} ({where})"
        if stop.text:
            body["text"] = stop.text
        if hits := [number for number in stop.hits if number]:
            body["hitBreakpointIds"] = hits
        self._client.event("stopped", body)
        if stop.text and stop.reason != "exception":
            self._client.say(f"{where}: {stop.text}")
        if self._launched is not None and self._launched.machine.devices is not None:
            self._client.say(self._run.console.positions())
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
        """Answer the requests that have arrived while the program runs.

        Return Quit to end the run.
        """
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
        if not _is_known(name):
            self._client.refuse(
                message, f"{COMMAND} debug does not know the request {command[:60]!r}"
            )
            return None
        arguments = message.get("arguments") or {}
        if not isinstance(arguments, dict):
            self._client.refuse(message, f"the arguments of {command!r} are not an object")
            return None
        if name not in _ALWAYS and self._launched is None:
            self._client.refuse(message, "no program is being debugged yet: send launch first")
            return None
        if name not in _RUNNING and self._stopped is None:
            self._client.refuse(message, "the program runs: pause it first")
            return None
        try:
            body = self._handler(name)(arguments)
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

    def _handler(self, name: str) -> Callable[[Message], Any]:
        """Return the handler of a known request."""
        own: Callable[[Message], Any] | None = getattr(self, f"_on_{name}", None)
        return own or next(filter(None, (part.handler(name) for part in self._parts)))

    def _on_initialize(self, arguments: Message) -> Message:
        self._base = 1 if arguments.get("linesStartAt1", True) else 0
        return dict(_CAPABILITIES)

    def _on_launch(self, arguments: Message) -> None:
        if self._launched is not None:
            raise InputError(
                "a program has been launched already", hint="start a second session for it"
            )
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
        self._run.debugger.pausing = True

    # --- continuing and stepping ---

    def _on_continue(self, _: Message) -> Order:
        return Forward()

    def _on_next(self, arguments: Message) -> Order:
        return Forward("over", task=self._views.task(arguments))

    def _on_stepIn(self, arguments: Message) -> Order:  # noqa: N802
        return Forward("in", task=self._views.task(arguments))

    def _on_stepOut(self, arguments: Message) -> Order:  # noqa: N802
        return Forward("out", task=self._views.task(arguments))

    def _on_stepScan(self, arguments: Message) -> Order:  # noqa: N802
        scans = int(arguments.get("scans", 1))
        return Forward("scan", scans) if scans > 0 else Back("scan", -scans)

    def _on_stepBack(self, arguments: Message) -> Order:  # noqa: N802
        return Back("step", task=self._views.task(arguments))

    def _on_reverseContinue(self, _: Message) -> Order:  # noqa: N802
        return Back("continue")

    def _on_backToChange(self, arguments: Message) -> Order:  # noqa: N802
        frame, console = self._views.frame(arguments), self._run.console
        data = console.lasting(frame, str(arguments["variable"]))
        return Back("change", watch=console.watch(data, 0))

    def _on_exceptionInfo(self, _: Message) -> Message:  # noqa: N802
        text = self._stopped.text if self._stopped is not None else ""
        return {"exceptionId": COMMAND, "description": text, "breakMode": "always"}


#: Exceptions caused by a request with arguments of wrong types or with too deep nesting.
_MISTYPED = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)

#: Requests that need no program, and requests that are allowed while the program runs.
_ALWAYS = ("initialize", "launch", "attach", "disconnect", "terminate", "configurationDone")
_RUNNING = (
    *_ALWAYS,
    *("setBreakpoints", "setFunctionBreakpoints", "setExceptionBreakpoints", "pause"),
    *("setDataBreakpoints", "breakpointLocations", "threads", "source", "loadedSources"),
)


def _is_known(name: str) -> bool:
    """Return whether there is a handler for a request."""
    parts = Session, ViewRequests, BreakpointRequests
    return name.isidentifier() and any(hasattr(part, f"_on_{name}") for part in parts)
