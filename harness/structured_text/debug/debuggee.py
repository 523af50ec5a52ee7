"""The parts of a debugged run, and the base of the classes that answer requests about the run."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from structured_text.debug.console import Console
from structured_text.debug.debugger import Debugger
from structured_text.debug.machine import Machine
from structured_text.debug.orders import Front, Order
from structured_text.debug.places import Places
from structured_text.debug.player import Player
from structured_text.debug.protocol import Message
from structured_text.debug.scopes import Scopes
from structured_text.debug.values import ProgramVariables
from structured_text.debug.watch_expressions import WatchExpressions

__all__ = ["Debuggee", "Requests", "source_of", "unverified"]

#: A function that answers a request: it returns a body, or an order for the debugger.
Handler = Callable[[Message], Message | Order | None]


@dataclass(frozen=True)
class Debuggee:
    """A run that is debugged.

    Attributes:
        machine: The program with the devices around it.
        base: The number of the first line of a file in the client, 0 or 1.
    """

    machine: Machine
    places: Places
    memory: ProgramVariables
    player: Player
    scopes: Scopes
    expressions: WatchExpressions
    debugger: Debugger
    console: Console
    base: int

    @classmethod
    def of(cls, machine: Machine, front: Front, base: int) -> Debuggee:
        """Return the debugger, views and other parts for a machine; `front` receives the stops."""
        program = machine.program
        places, memory = Places(program), ProgramVariables(program)
        player = Player(machine, places)
        scopes = Scopes(machine, places, memory)
        expressions = WatchExpressions(program.module.project, program.module.names)
        debugger = Debugger(player, memory, front)
        console = Console(debugger, expressions, memory, scopes)
        return cls(machine, places, memory, player, scopes, expressions, debugger, console, base)


class Requests:
    """The base of classes that handle requests about a run; `_on_NAME` handles the request NAME."""

    def __init__(self, run: Debuggee) -> None:
        self._run = run

    def handler(self, name: str) -> Handler | None:
        """Return the handler of a request; None if this class does not handle the request."""
        found: Any = getattr(self, f"_on_{name}", None)
        return found  # type: ignore[no-any-return]


def source_of(file: str) -> Message:
    """Return the description of a source file in the protocol."""
    whole = os.path.abspath(file)
    return {"name": os.path.basename(whole), "path": whole}


def unverified(text: str) -> Message:
    """Return the answer for a breakpoint that is not set, with the reason."""
    return {"verified": False, "message": text}
