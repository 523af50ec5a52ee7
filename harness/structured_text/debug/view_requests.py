"""The requests of the protocol that show the run: threads, stack, variables, expressions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from structured_text.debug.debuggee import Debuggee, Requests, source_of
from structured_text.debug.devices import DeviceFrame
from structured_text.debug.orders import Back, Forward, Order, Quit
from structured_text.debug.protocol import Message
from structured_text.debug.scopes import Frame
from structured_text.debug.values import Held, Item, Text
from structured_text.errors import InputError
from structured_text.language.source import NetworkLine

__all__ = ["ViewRequests"]

#: An array with more elements than this number is shown in pages.
_PAGED = 100


class ViewRequests(Requests):
    """Shows the run at its current moment, and sets variables.

    The first threads are the programs of the PLC; the other threads are the tasks of devices.

    Args:
        run: The run.
        say: Prints a line in the client's console.
    """

    def __init__(self, run: Debuggee, say: Callable[[str], None]) -> None:
        super().__init__(run)
        self._say = say
        self.forget()

    def forget(self) -> None:
        """Forget all frames and references, which are valid for one stop only."""
        self._frames: list[Frame | DeviceFrame] = []
        self._opened: list[Callable[[], list[Item]]] = []
        self._held: list[Held | None] = []
        self._scope_frames: dict[int, Frame] = {}

    # --- threads and frames ---

    @property
    def thread(self) -> int:
        """Return the thread that is about to run a statement."""
        tracer = self._run.player.tracer
        if tracer.device is not None:
            return self._programs + tracer.device.task
        return self._run.scopes.running(tracer)

    @property
    def network(self) -> str:
        """Return POU and rung or network of the current statement; empty for a line of text."""
        tracer = self._run.player.tracer
        line = tracer.stack[-1].line if tracer.stack and tracer.device is None else 0
        return line.place if isinstance(line, NetworkLine) else ""

    def task(self, arguments: Message) -> int:
        """Return the number of the device's task in a request, or 0 for a program of the PLC."""
        thread = int(arguments.get("threadId") or 1)
        devices = self._run.machine.devices
        known = [number for number, _ in devices.tasks] if devices is not None else []
        return thread - self._programs if thread - self._programs in known else 0

    @property
    def _programs(self) -> int:
        """Return the number of threads that are programs of the PLC."""
        return len(self._run.scopes.threads())

    def _on_threads(self, _: Message) -> Message:
        threads = self._run.scopes.threads()
        devices = self._run.machine.devices
        if devices is not None:
            threads = [*threads, *((len(threads) + k, name) for k, name in devices.tasks)]
        return {"threads": [{"id": k, "name": name} for k, name in threads]}

    def _on_stackTrace(self, arguments: Message) -> Message:  # noqa: N802 (as the protocol)
        run, devices = self._run, self._run.machine.devices
        task = self.task(arguments)
        frames: list[Frame | DeviceFrame]
        if task and devices is not None:
            frames = list(devices.stack(task))
        else:
            thread = int(arguments.get("threadId") or 1)
            frames = list(run.scopes.stack(run.player.tracer, thread))
        first = int(arguments.get("startFrame") or 0)
        count = int(arguments.get("levels") or len(frames))
        shown = [self._frame_as_shown(frame) for frame in frames[first : first + count]]
        return {"stackFrames": shown, "totalFrames": len(frames)}

    def _frame_as_shown(self, frame: Frame | DeviceFrame) -> Message:
        self._frames.append(frame)
        file = frame.file if isinstance(frame, DeviceFrame) else frame.pou.file
        body: Message = {
            "id": len(self._frames),
            "name": frame.title,
            "line": frame.line - 1 + self._run.base,
            "column": self._run.base,
        }
        return {**body, "source": source_of(file)} if file else body

    def frame(self, arguments: Message) -> Frame:
        """Return the requested frame of the PLC, by default the innermost frame.

        For a frame of a device, return the innermost frame of the PLC, in which the PLC's
        expressions are evaluated.
        """
        found = self._any_frame(arguments)
        if isinstance(found, Frame):
            return found
        tracer = self._run.player.tracer
        return self._run.scopes.stack(tracer, self._run.scopes.running(tracer))[0]

    def _any_frame(self, arguments: Message) -> Frame | DeviceFrame | None:
        number = arguments.get("frameId")
        if not number:
            return None
        if not 1 <= int(number) <= len(self._frames):
            raise IndexError(number)
        return self._frames[int(number) - 1]

    # --- scopes and variables ---

    def _on_scopes(self, arguments: Message) -> Message:
        run, scopes = self._run, self._run.scopes
        of = self._any_frame(arguments)
        frame = self.frame(arguments)
        every: list[tuple[str, Callable[[], list[Item]], str]] = [
            ("Inputs, outputs", lambda: scopes.pins(frame), "arguments"),
            ("Variables", lambda: scopes.locals(frame), "locals"),
            ("Globals", scopes.globals, ""),
        ]
        if isinstance(of, DeviceFrame):
            every = [
                (name, items, "" if number else "locals")
                for number, (name, items) in enumerate(of.scopes)
            ]
        every += [(name, items, "") for name, items in run.machine.around]
        every.append(("Run", lambda: scopes.moment(run.player.tracer.step), ""))
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
        """Return the function that reads the parts of an opened item.

        Raise IndexError if no item with this reference is open.
        """
        if not 1 <= reference <= len(self._opened):
            raise IndexError(reference)
        return self._opened[reference - 1]

    def opened(self, reference: int, name: str, arguments: Message) -> tuple[Item | None, Frame]:
        """Return the part of an opened item that has this name, and the frame of the item."""
        found = [one for one in self._of(reference)() if one.name == name]
        frame = self._scope_frames.get(reference) or self.frame(arguments)
        return found[0] if found else None, frame

    def _on_variables(self, arguments: Message) -> Message:
        reference = int(arguments["variablesReference"])
        opened, of = self._of(reference), self._held[reference - 1]
        frame = self._scope_frames.get(reference)
        if of is not None:
            first, count = int(arguments.get("start") or 0), int(arguments.get("count") or 0)
            items: list[Item] = list(self._run.memory.parts(of, first, count or None))
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
        shown = self._run.memory.shown(item)
        body = {"name": item.name, "value": shown.text, "type": shown.type}
        body |= self._below(item, frame)
        if item.path:
            body["evaluateName"] = item.path
        return body

    def _below(self, item: Held, frame: Frame | None) -> Message:
        shown = self._run.memory.shown(item)
        reference = 0
        if shown.named or shown.numbered:
            reference = self._open(lambda: list(self._run.memory.parts(item)))
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
        frame = self._scope_frames.get(reference) or self.frame({})
        return self._put(found[0], str(arguments["value"]), frame)

    def _on_setExpression(self, arguments: Message) -> Message:  # noqa: N802
        frame = self.frame(arguments)
        found = self._run.console.place(frame, str(arguments["expression"]))
        return self._put(found, str(arguments["value"]), frame)

    def _put(self, of: Held, text: str, frame: Frame) -> Message:
        if said := self._run.console.put(frame, of, text):
            self._say(said)
        shown = self._run.memory.shown(of)
        return {"value": shown.text, "type": shown.type, **self._below(of, frame)}

    # --- expressions ---

    def _on_evaluate(self, arguments: Message) -> Message | Order:
        text, context = str(arguments["expression"]).strip(), arguments.get("context", "")
        frame = self.frame(arguments)
        if context in ("repl", "") and (text.startswith(".") or ":=" in text):
            done = self._run.console.command(frame, text)
            if isinstance(done, (Forward, Back, Quit)):
                return done
            return {"result": done, "variablesReference": 0}
        of = self._any_frame(arguments)
        if isinstance(of, DeviceFrame) and (held := _value_in(of, text)) is not None:
            return {"result": held, "variablesReference": 0}
        try:
            found = self._run.console.look(frame, text)
        except InputError as error:
            if not isinstance(of, DeviceFrame):
                raise
            text = f"{text} has no value in {of.title}; in the PLC: {error.message}"
            raise InputError(text, hint=error.hint) from None
        shown = self._run.memory.shown(found)
        return {"result": shown.text, "type": shown.type, **self._below(found, frame)}

    def _on_completions(self, arguments: Message) -> Message:
        frame = self.frame(arguments)
        column = int(arguments["column"]) - self._run.base
        found = self._run.console.completions(frame, str(arguments["text"])[:column])
        return {"targets": [{"label": label, "type": kind} for label, kind in found]}

    # --- sources ---

    def _on_source(self, _: Message) -> Message:
        raise InputError("the debugger sends no sources", hint="open the file in the editor")

    def _on_loadedSources(self, _: Message) -> Message:  # noqa: N802
        files = dict.fromkeys(str(file) for file in self._run.places.project.files)
        devices = self._run.machine.devices
        if devices is not None:
            files |= dict.fromkeys(devices.files)
        return {"sources": [source_of(file) for file in files]}


def _value_in(frame: DeviceFrame, name: str) -> str | None:
    """Return the text of a variable in a frame of a device.

    The result is None if the frame has no such variable.
    """
    for _, items in frame.scopes:
        for one in items():
            if isinstance(one, Text) and one.name.upper() == name.upper():
                return one.text
    return None
