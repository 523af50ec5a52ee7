"""`rcx points`: back up, restore and compare points and other stored data of a controller."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import check_ipv4, check_port, duration_us, interval_us
from rcx_harness.cli.progress import progress_bar
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.points.all_sections import as_all, beyond_all, from_file, is_all
from rcx_harness.look.points.carry import TIMEOUT_US, UNDEFINED, Carrier, RefusedError
from rcx_harness.look.points.stored import (
    KINDS,
    Key,
    Stored,
    as_csv,
    as_toml,
    shown,
    without_foreign,
)
from rcx_harness.look.probe.line import LostError, NetworkLine, NotConnectedError
from rcx_harness.robot.stored import COUNTS, ROBOTS
from rcx_harness.spec.wire import SIZE, check_size
from structured_text.errors import InputError, legible
from structured_text.output.files import NewFiles

__all__ = ["Action", "points"]

_SAFETY = """\
SAFETY. This program becomes the master of a real robot: disconnect the PLC from it first. All
dedicated inputs stay OFF, SI(00) among them: the controller is in emergency stop while it works."""


class Action(str, Enum):
    """The action: backup, restore or compare."""

    backup = "backup"
    restore = "restore"
    compare = "compare"


#: Maps an action to the text about the state after an interruption.
_LEFT = {
    Action.backup: "no file was written",
    Action.compare: "nothing was compared",
    Action.restore: "what was being written may be stored; run it again to go on",
}
_SHORTEST_US = 100_000


def points(
    action: Annotated[Action, typer.Argument(help="Action: backup, restore or compare.")],
    host: Annotated[str, typer.Argument(help="Address of the controller, real or virtual.")],
    file: Annotated[Path, typer.Argument(help="TOML or .ALL file, which only backup writes.")],
    kind: Annotated[
        list[str] | None,
        typer.Option(help=f"Only this kind: {', '.join(KINDS)}; may be repeated."),
    ] = None,
    numbers: Annotated[
        str,
        typer.Option(
            help=(
                "Numbers of points and comments, such as 0-99 or 5. Default of a backup: 0-999; a "
                "comparison adds them to the numbers in the file."
            )
        ),
    ] = "",
    robot: Annotated[
        list[int] | None, typer.Option(help="Robot whose hands are backed up; may be repeated.")
    ] = None,
    csv: Annotated[
        Path | None, typer.Option(help="Also write points and comments of a backup as CSV.")
    ] = None,
    write: Annotated[
        bool,
        typer.Option("--write", help="Required for restore: change the data in the controller."),
    ] = False,
    undefined: Annotated[
        list[str] | None,
        typer.Option(help="Alarm that means undefined data; may be repeated."),
    ] = None,
    timeout: Annotated[
        str,
        typer.Option(help="Longest wait for each answer of the controller."),
    ] = f"{TIMEOUT_US // 1_000_000}s",
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE,
    rpi: Annotated[str, typer.Option(help="Packet interval.")] = "10ms",
    port: Annotated[int, typer.Option(help="TCP port of the controller.")] = PORT,
    address: Annotated[str, typer.Option("--from", help="Local address for the connection.")] = "",
) -> None:
    """Back up, restore or compare points, comments, shifts, hands and pallets of a controller.

    The file has the tables of a robot file, which `rcx run --robot` and `rcx serve --robot` read.
    A name that ends with .ALL stands for the data sections of a file with all data of a controller.
    A restore reads first, writes only what differs, and compares again. After an interruption the
    same command completes it. It deletes nothing.

    Exit code: 0; 1 if data differ or were left out, the controller refused a command or did not
    answer in time, or the connection was lost; 130 after Ctrl-C; 2 on bad input.
    """
    check_size(size)
    check_port("--port", port)
    if address:
        check_ipv4("--from", address)
    rpi_us = interval_us("--rpi", rpi)
    timeout_us = _timeout_us(timeout)
    kinds = _kinds(kind or [])
    alarms = _alarms(undefined or [])
    given = Stored()
    if action is Action.backup:
        asked = _keys(kinds or KINDS, _range(numbers or "0-999"), _robots(robot or [1]))
        if write:
            raise InputError("--write is for restore only")
    else:
        _check_options(action, csv, robot or (), numbers, write)
        read, passed_over = from_file(file)
        for text in passed_over:
            print(legible(f"skipped: {text}"), file=sys.stderr)
        given = _only(read, kinds, file)
        if numbers:
            here = [kind for kind in ("points", "comments") if not kinds or kind in kinds]
            more = _keys(here, _range(numbers), ())
            given.asked = sorted({*given.asked, *more}, key=lambda key: (KINDS.index(key[0]), key))
        asked = given.asked
    with ExitStack() as stack:
        if action is Action.backup:
            files = stack.enter_context(NewFiles([file, csv] if csv else [file]))
        print(_SAFETY, flush=True)
        line = stack.enter_context(_connected(host, size, rpi_us, port, address, action))
        carrier = Carrier(line, alarms, timeout_us)
        with progress_bar("reading", shown=True) as progress:
            found = carrier.read(asked, progress)
        if action is Action.backup:
            _save(found, files, file, csv, [f"rcx points backup {host}", *line.identity])
            return
        different = _different(given, found)
        if action is Action.restore and different:
            wanted = [key for key in different if key in given.values or key[0] == "comments"]
            with progress_bar("writing", shown=True) as progress:
                carrier.write(given, wanted, progress)
            with progress_bar("reading again", shown=True) as progress:
                found = carrier.read(asked, progress)
            print(f"{len(wanted)} written")
            different = _different(given, found)
    _tell(given, found, different)
    if different:
        raise typer.Exit(1)


@contextmanager
def _connected(
    host: str, size: int, rpi_us: int, port: int, address: str, action: Action
) -> Iterator[NetworkLine]:
    """Yield the connection to the controller and close it at the end; an error ends the command."""
    try:
        line = NetworkLine(host, size, rpi_us, port, address)
    except EnipError as error:
        raise InputError(error.message, hint=error.hint) from None
    code, reason = 0, ""
    try:
        yield line
    except NotConnectedError as error:
        raise InputError(f"no connection to {host}: {error.text}", hint=error.hint) from None
    except LostError as error:
        code, reason = 1, f"the connection is lost: {error}; {_LEFT[action]}"
    except RefusedError as error:
        code, reason = 1, str(error)
    except KeyboardInterrupt:
        code, reason = 130, f"stopped by Ctrl-C; {_LEFT[action]}"
    finally:
        line.close()
    if code:
        print(f"rcx: {reason}", file=sys.stderr)
        raise typer.Exit(code)


def _check_options(
    action: Action, csv: Path | None, robot: Sequence[int], numbers: str, write: bool
) -> None:
    """Raise InputError if an option belongs to another action than the given action."""
    if csv or robot:
        raise InputError(f"{'--csv' if csv else '--robot'} is for backup only")
    if action is Action.restore and numbers:
        raise InputError("--numbers is for backup and compare only", hint="use --kind")
    if action is Action.restore and not write:
        hint = "look at the differences with compare, then add --write"
        raise InputError("restore changes the data of the controller", hint=hint)
    if action is Action.compare and write:
        raise InputError("--write is for restore only")


def _kinds(names: Sequence[str]) -> list[str]:
    for name in names:
        if name not in KINDS:
            raise InputError(
                f"--kind {name!r:.40} is not a kind of data", hint=f"use {', '.join(KINDS)}"
            )
    return [kind for kind in KINDS if kind in names]


def _alarms(given: Sequence[str]) -> Sequence[str]:
    for alarm in given:
        if not re.fullmatch(r"\d{1,5}\.\d{1,5}", alarm):
            raise InputError(f"--undefined {alarm!r:.40} is not an alarm", hint="write 6.204")
    return given or UNDEFINED


def _timeout_us(text: str) -> int:
    given_us = duration_us("--timeout", text)
    if given_us < _SHORTEST_US:
        raise InputError(f"--timeout {text} is too short", hint="use 100ms to 365d")
    return given_us


def _robots(given: Sequence[int]) -> list[int]:
    for robot in given:
        if not 1 <= robot <= ROBOTS:
            raise InputError(f"--robot {robot} is not a robot", hint=f"use 1 to {ROBOTS}")
    return sorted(set(given))


def _range(text: str) -> range:
    found = re.fullmatch(r"(\d{1,5})(?:-(\d{1,5}))?", text)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (1, 0)
    if not first <= last < COUNTS["points"]:
        hint = f"write 0-99 or 5; the last number is {COUNTS['points'] - 1}"
        raise InputError(f"--numbers {text!r:.40} is not a range of points", hint=hint)
    return range(first, last + 1)


def _keys(kinds: Sequence[str], numbers: range, robots: Sequence[int]) -> list[Key]:
    """Return the keys of the stored data that a backup reads from the controller."""
    keys: list[Key] = []
    for kind in kinds:
        which = numbers if kind in ("points", "comments") else range(COUNTS[kind])
        for robot in robots if kind == "hands" else (0,):
            keys += [(kind, robot, number) for number in which]
    return keys


def _only(stored: Stored, kinds: Sequence[str], file: Path) -> Stored:
    """Return the stored data of the kinds that `--kind` requests."""
    asked = [key for key in stored.asked if not kinds or key[0] in kinds]
    if not asked:
        raise InputError(
            "contains none of the requested data", file=file, hint="use another --kind"
        )
    return Stored({key: stored.values[key] for key in asked if key in stored.values}, asked)


def _save(
    found: Stored, files: NewFiles, file: Path, csv: Path | None, head: Sequence[str]
) -> None:
    kept, foreign = without_foreign(found)
    left = f"left out: comments of {', '.join(map(str, foreign))}" if foreign else ""
    why = "characters other than 16#20 to 16#7E"
    tables = [as_toml(kept, [*head, f"{left}: {why}"] if left else head)]
    others = beyond_all(kept) if is_all(file) else []
    if is_all(file):
        tables = [as_all(kept)]
    tables += [as_csv(kept)] if csv else []
    files.write(*(text for text in tables))
    for kind in KINDS:
        asked = sum(key[0] == kind for key in found.asked)
        if asked:
            print(f"{kind}: {len(found.of(kind))} of {asked} are defined")
    print(f"written: {', '.join(map(str, [file, csv] if csv else [file]))}")
    if left:
        print(f"rcx: {left}: {why}", file=sys.stderr)
    if others:
        robots = ", ".join(str(robot) for robot in sorted({key[1] for key in others}))
        text = f"left out: hands of robot {robots}: a .ALL file has only those of robot 1"
        print(f"rcx: {text}", file=sys.stderr)
    if left or others:
        raise typer.Exit(1)


def _different(given: Stored, found: Stored) -> list[Key]:
    return [key for key in given.asked if given.values.get(key) != found.values.get(key)]


def _tell(given: Stored, found: Stored, different: Sequence[Key]) -> None:
    for key in different:
        kind, robot, number = key
        owner = f" of robot {robot}" if robot else ""
        print(f"{kind[:-1]} {number}{owner}")
        print(f"  file        {shown(given.values.get(key))}")
        print(f"  controller  {shown(found.values.get(key))}")
    print(f"{len(different)} of {len(given.asked)} differ")
