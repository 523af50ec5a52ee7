"""`rcx run --connect`: the controller's address, and the question before a real robot is driven."""

from __future__ import annotations

import ipaddress
import socket
import sys
from typing import TYPE_CHECKING

import typer

from structured_text.errors import InputError
from structured_text.output.throttle import Throttle
from structured_text.output.units import format_us

__all__ = ["Teller", "confirm", "no_connection"]

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere

_QUESTION = """\
The program will drive the controller at {name}. If that is a real one, its robot moves.
These blocks are no safety function: try the program on the virtual controller first, keep the speed
low, clear the cell, and have a hand on the emergency stop.
Go on?"""


def confirm(where: Elsewhere, *, yes: bool) -> None:
    """Ask for confirmation before a controller outside this computer is driven.

    `yes` means that the user has agreed on the command line already.

    Raises:
        InputError: there is no terminal for the question, or the answer is no.
    """
    if yes or _is_here(where.host):
        return
    if not sys.stdin.isatty():
        raise InputError(
            f"--connect {where.name} drives a controller that may be a real one",
            hint="clear the cell, then add --yes",
        )
    if not typer.confirm(_QUESTION.format(name=where.name)):
        raise InputError("nothing was sent", hint="try it on a virtual controller first: rcx serve")


def _is_here(host: str) -> bool:
    """Return whether the host is a loopback address."""
    try:
        return ipaddress.ip_address(socket.gethostbyname(host)).is_loopback
    except (OSError, ValueError, UnicodeError):  # the connection reports an unknown host
        return False


def no_connection(reason: str) -> InputError:
    """Return the error for a run in which no packet of the controller was accepted.

    `reason` is the last failure that the connection has reported.
    """
    from rcx_harness.enip.originator.persistent_connection import WAITS

    hint = "check that no firewall blocks UDP port 2222" if reason.endswith(WAITS) else ""
    return InputError(f"there was no connection in the whole run: {reason}", hint=hint)


class Teller:
    """Prints a message when the connection opens or ends, on stderr and with a limited rate."""

    def __init__(self) -> None:
        self._throttle = Throttle()
        self.last = ""

    def __call__(self, now_us: int, text: str) -> None:
        """Print a message with the time of the run; drop the message if there are too many."""
        self.last = text
        for line in self._throttle.let_pass("connection", [text], now_us):
            print(f"{format_us(now_us)}: {line}", file=sys.stderr, flush=True)
