"""Runs from the start that show what a seeded bug does, found by trying, and replayed.

A run counts when it breaks a claim of a property on the broken library, replayed from its
stimulus as `rcx run` does it, and breaks nothing on the library as it is.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.engine.base import Program
from rcx_harness.engine.load import build
from rcx_harness.errors import InputError
from rcx_harness.watch.calls_source import steady_instances
from rcx_tools.evidence.prove.claims import DIFFERS, HANG, QUIET, STOPS, Judges
from rcx_tools.evidence.prove.client import Client, Environment, Moment, numbers_in
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.results import ROOT

__all__ = ["CLIENTS", "Found", "hunt"]

#: Blocks of clients for what no block alone is about.
CLIENTS = (
    ("FB_ServoOn", "FB_AutoStart", "FB_SequenceControl"),
    ("FB_ServoOn", "FB_AlarmReset", "FB_RemoteCommand"),
    ("FB_RemoteCommand", "FB_ReadPositionPulses", "FB_ReadPositionPulses", "FB_Jog"),
    ("FB_SequenceControl", "FB_ProgramReset", "FB_AutoStart", "FB_EmergencyStop", "FB_ProgramStop"),
)

#: Runs that are tried, and scans of each before the environment becomes quiet.
_RUNS, _SCANS = 50, 60


@dataclass(frozen=True)
class Found:
    """A run: what repeats it, its files, and which claim it breaks in its last scan."""

    command: str
    files: tuple[str, ...]
    scans: int
    breaks: str


def hunt(
    name: str,
    file: str,
    blocks: Sequence[str],
    kinds: Sequence[str],
    folder: Path,
    library: Path,
    runs: int = _RUNS,
) -> Found | None:
    """A run that breaks one of these kinds of claims; None where none was found.

    Args:
        name: Of the bug; it is the seed.
        file: What the bug has changed, in the library.
        blocks: Those of the client.
        kinds: See `claims.CLAIMS`.
        folder: Where the copy with the bug is, in lib/; the run is left here.
        library: The library as it is.
        runs: How many are tried.
    """
    steady = "contract" in kinds
    client = Client(tuple(blocks), steady, "Words" in file)
    source = folder / "client.st"
    source.write_text(client.source(Library(folder / "lib")), encoding="utf-8")
    hunter = _Hunter(client, source, folder / "lib", library, kinds)
    numbers = sorted(numbers_in(folder / "lib" / file))
    start = sum(name.encode())
    for differs in (False, True) if set(kinds) & set(DIFFERS) else (False,):
        for seed in range(start, start + runs):
            moments = hunter.run(seed, numbers, differs=differs)
            if moments is not None and (found := hunter.confirmed(moments, folder)):
                return found
    return None


class _Hunter:
    def __init__(
        self, client: Client, source: Path, broken: Path, sound: Path, kinds: Sequence[str]
    ) -> None:
        self._client, self._source, self._kinds = client, source, kinds
        self._folders = broken, sound
        self._library = Library(broken)
        self._steady = steady_instances([source], sorted(broken.rglob("*.st")))
        self._broken = _built(source, broken)
        self._start = self._broken.snapshot()
        self._sound = _built(source, sound) if set(kinds) & set(DIFFERS) else None
        self._sound_start = self._sound.snapshot() if self._sound else None

    def _judges(self, program: Program) -> Judges:
        return Judges(program, self._library, self._client, self._steady)

    def run(self, seed: int, numbers: list[int], *, differs: bool) -> list[Moment] | None:
        """Try one run; what happens in it up to a broken claim, or to a difference."""
        self._broken.restore(self._start)
        judges = self._judges(self._broken)
        long = HANG in self._kinds
        environment = Environment(self._library, self._client, seed, numbers, long=long)
        moments: list[Moment] = []
        for number in range(_SCANS + (QUIET if long else 0)):
            moment = environment.before(number, judges.written, max(0, number - _SCANS + 1))
            moments.append(moment)
            found = _scan(self._broken, judges, moment)
            if any(kind in self._kinds for kind, _ in found):
                return moments
            if any(kind == STOPS for kind, _ in found):
                return None
        if self._sound is None or not differs:
            return None
        self._sound.restore(self._sound_start)
        other = self._judges(self._sound)
        for moment in moments:
            _scan(self._sound, other, moment)
        last = judges.differs(other, self._kinds)
        return None if last is None else moments[: last + 1]

    def confirmed(self, moments: list[Moment], folder: Path) -> Found | None:
        """Replay it from its file, on both copies of the library."""
        file = folder / "stimulus.toml"
        file.write_text("\n".join(_entries(moments)), encoding="utf-8")
        scan_us = moments[1].t_us if len(moments) > 1 else 10_000
        (broken, one), (sound, other) = (
            self._replayed(lib, file, scan_us, moments) for lib in self._folders
        )
        why = [text for kind, text in broken if kind in self._kinds]
        if one.differs(other, self._kinds) is not None:
            why.append("what goes out is not what the proved library sends")
        if not why or any(kind in (*self._kinds, STOPS) for kind, _ in sound):
            return None
        told = [_short(path) for path in (self._source, self._folders[0], file)]
        scan, whole = f"{scan_us / 1000:g}ms", f"{scan_us * len(moments) / 1000:g}ms"
        command = "rcx run {} --lib {} --stimulus {}".format(*told)
        files = tuple(str(path) for path in (self._source, file))
        return Found(f"{command} --scan {scan} --for {whole}", files, len(moments), why[0])

    def _replayed(
        self, lib: Path, file: Path, scan_us: int, moments: list[Moment]
    ) -> tuple[list[tuple[str, str]], Judges]:
        """What breaks in a cell, with all of its monitors."""
        found: list[tuple[str, str]] = []
        scan = timedelta(microseconds=scan_us)
        with Cell.build(self._source, lib=lib, scan=scan, engine="builtin") as cell:
            Stimulus.load(file).schedule(cell)
            judges = self._judges(cell.program)
            for moment in moments:
                try:
                    cell.scan(1)
                except InputError as error:
                    return [*found, (STOPS, str(error))], judges
                found += judges.scan(moment)
        return found, judges


def _built(source: Path, library: Path) -> Program:
    return build([source, *sorted(library.rglob("*.st"))], "builtin").program


def _scan(program: Program, judges: Judges, moment: Moment) -> list[tuple[str, str]]:
    """Run a scan; what it breaks."""
    for path, value in moment.values.items():
        program.write(path, value)
    program.write_bytes("Main.InputArea", moment.area)
    program.write("Main.Connected", moment.connected)
    try:
        program.scan(moment.t_us)
    except InputError as error:
        return [(STOPS, str(error))]
    return judges.scan(moment)


def _short(path: Path) -> str:
    """As from the repository, where it is there."""
    return str(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)


def _entries(moments: list[Moment]) -> Iterator[str]:
    """The stimulus: what changes before which scan."""
    area: tuple[bytes, bool] | None = None
    for moment in moments:
        lines = []
        if moment.values:
            told = [f"{json.dumps(path)} = {_told(value)}" for path, value in moment.values.items()]
            lines.append(f"set = {{ {', '.join(told)} }}")
        if (moment.area, moment.connected) != area:
            area = moment.area, moment.connected
            lines.append(f'area = "{moment.area.rstrip(bytes(1)).hex(" ") or "00"}"')
            lines.append(f"connected = {_told(moment.connected)}")
        if lines:
            yield "\n".join(["[[at]]", f'time = "{moment.t_us / 1000:g}ms"', *lines, ""])


def _told(value: Any) -> str:
    if isinstance(value, timedelta):
        return f'"{value // timedelta(milliseconds=1)}ms"'
    if isinstance(value, list):
        return f"[{', '.join(_told(one) for one in value)}]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {_told(one)}" for name, one in value.items()) + " }"
    return json.dumps(value)
