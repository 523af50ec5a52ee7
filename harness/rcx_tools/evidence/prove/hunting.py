"""Search for runs from the start that show a seeded bug, with replay.

A run counts if it breaks a claim of a property on the broken library and breaks nothing on the
unchanged library. It is replayed from its stimulus as `rcx run` does it. Both libraries run side by
side. If no claim is broken, a run may count whose output differs from the proved library; the
properties that allow this are in `claims.CLAIMS`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Entry, Stimulus, stimulus_text
from rcx_harness.watch.calls_source import steady_instances
from rcx_tools.evidence.prove.claims import DIFFERS, HANG, QUIET, RESULT, STOPS, About, Judges
from rcx_tools.evidence.prove.client import Client
from rcx_tools.evidence.prove.environment import Environment, Hints, Moment, numbers_in
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.results import ROOT
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.errors import InputError
from structured_text.projects.needed import needed

__all__ = ["STANDING", "Found", "Hunted", "hunt"]

#: Blocks of a client besides those with the bug: of both channels, and of every kind.
STANDING = (
    *("FB_ServoOn", "FB_ServoOn", "FB_AutoStart", "FB_SequenceControl", "FB_AlarmReset"),
    *("FB_ProgramReset", "FB_EmergencyStop", "FB_ServoOnFromEmergencyStop", "FB_PowerUp"),
    *("FB_ProgramStop", "FB_ProgramContinue"),
    *("FB_RemoteCommand", "FB_RemoteCommand", "FB_ReadPositionPulses", "FB_ReadPositionPulses"),
    "FB_Jog",
)

#: Number of runs to try, and scans of each before the environment becomes quiet.
_RUNS, _SCANS = 300, 80
#: After a run that only differs, this many more runs are tried to find a broken claim.
_MORE = 12
#: Every second run has a quiet end, if a quiet end matters.
_LONG = 2


@dataclass(frozen=True)
class Found:
    """A run: the command that repeats it, its files, and the claim it breaks in its last scan."""

    command: str
    files: tuple[str, ...]
    scans: int
    breaks: str


@dataclass(frozen=True)
class Hunted:
    """A bug, as the search for a run needs it.

    Attributes:
        name: Its name, which is also the seed.
        file: The library file that the bug has changed.
        own: Blocks that contain the bug, or that its broken goals are about.
        kinds: Kinds of claims, see `claims.CLAIMS`.
        hints: Values of pins that break a goal.
    """

    name: str
    file: str
    own: tuple[str, ...]
    kinds: frozenset[str]
    hints: Hints


def hunt(
    bug: Hunted, broken: Library, sound: Library, folder: Path, runs: int = _RUNS
) -> Found | None:
    """Return a run that breaks one of these kinds of claims; None if none was found.

    Args:
        bug: The bug.
        broken: The copy of the library with the bug.
        sound: The unchanged library.
        folder: The files of the run are written here.
        runs: Number of runs to try.
    """
    functions: tuple[str, ...] = ()
    if RESULT in bug.kinds:
        pous = (broken.pou(name) for name in sorted(broken.in_file(bug.file)))
        functions = tuple(
            pou.name for pou in pous if pou.kind == "FUNCTION" and not pou.section("VAR_IN_OUT")
        )
    words = "Words" in bug.file
    own = tuple(block for block in bug.own for _ in range(2))[:6]
    standing = (*STANDING, "FB_WriteWordInWords" if words else "FB_WriteWord")
    out_of_place = "place" in bug.kinds
    clients = [Client((*own, *standing), False, words, functions, out_of_place)]
    if "contract" in bug.kinds:
        clients.insert(0, Client(own or STANDING[2:4], True, words))
    for client in clients:
        hunter = _Hunter(client, bug, broken, sound, folder)
        found = hunter.first(len(own), runs)
        if found is not None:
            return found
    return None


class _Hunter:
    def __init__(
        self, client: Client, bug: Hunted, broken: Library, sound: Library, folder: Path
    ) -> None:
        self._client, self._bug, self._folder = client, bug, folder
        self._libraries = broken, sound
        self._source = folder / "client.st"
        self._source.write_text(client.source(broken), encoding="utf-8")
        changed = sound.folder / bug.file, broken.folder / bug.file
        files = sorted(sound.folder.rglob("*.st"))
        every = [changed[1] if file == changed[0] else file for file in files]
        self._steady = steady_instances([self._source], every) if client.steady else set()
        self._broken, self._sound = (
            build([self._source, *needed([self._source], some)], "builtin").program
            for some in (every, files)
        )
        self._starts = self._broken.snapshot(), self._sound.snapshot()
        self._numbers = sorted(numbers_in(changed[1]))

    def first(self, own: int, runs: int) -> Found | None:
        """Return the first run that breaks a claim; else the first that differs, if that counts."""
        start = sum(self._bug.name.encode())
        differing: tuple[Found, list[Moment]] | None = None
        more = _MORE
        for seed in range(start, start + runs):
            if differing is not None:
                more -= 1
                if not more:
                    break
            long = HANG in self._bug.kinds and seed % _LONG == 0
            environment = Environment(
                self._libraries[0],
                self._client,
                seed,
                self._numbers,
                self._bug.hints,
                first=own,
                long=long,
            )
            moments, claimed = self._run(environment, long=long)
            if not moments or (differing is not None and not claimed):
                continue
            found = self._confirmed(moments, environment)
            if found is not None and claimed:
                return found
            differing = (found, moments) if found is not None else differing
        if differing is None:
            return None
        self._leave(differing[1])
        return differing[0]

    def _leave(self, moments: list[Moment]) -> Path:
        """Write a run to its file."""
        file = self._folder / "stimulus.toml"
        file.write_text(stimulus_text(_entries(moments)), encoding="utf-8")
        return file

    def _about(self, environment: Environment) -> About:
        kinds = self._bug.kinds
        blocks, n = environment.blocks, environment.n
        return About(self._libraries[0], self._client, blocks, self._steady, n, kinds)

    def _run(self, environment: Environment, *, long: bool) -> tuple[list[Moment], bool]:
        """Try one run; return its moments up to a broken claim or a difference."""
        # Both libraries get the same stimulus, which depends on the area that the broken library
        # writes. If the unchanged library breaks a claim, too, the run shows nothing about the bug
        # and ends. A difference alone is remembered, but the run goes on to look for a claim.
        self._broken.restore(self._starts[0])
        self._sound.restore(self._starts[1])
        about = self._about(environment)
        broken, sound = Judges(self._broken, about), Judges(self._sound, about)
        compared = bool(self._bug.kinds & set(DIFFERS))
        moments: list[Moment] = []
        differing = 0
        for number in range(_SCANS + (QUIET if long else 0)):
            moment = environment.before(number, broken.written, max(0, number - _SCANS + 1))
            moments.append(moment)
            found = _scan(self._broken, broken, moment)
            if _scan(self._sound, sound, moment):
                break  # the unchanged library breaks a claim, too
            if any(kind in self._bug.kinds for kind, _ in found):
                return moments, True
            if found:
                break
            if compared and not differing and broken.differs(sound):
                differing = len(moments)
        return moments[:differing], False

    def _confirmed(self, moments: list[Moment], environment: Environment) -> Found | None:
        """Replay the run from its file on both libraries; return None if it does not confirm."""
        file = self._leave(moments)
        about = self._about(environment)
        scan_us = environment.scan_us
        (broken, one), (sound, other) = (
            self._replayed(library.folder, file, scan_us, moments, about)
            for library in self._libraries
        )
        why = [text for kind, text in broken if kind in self._bug.kinds]
        if one is not None and other is not None and one.differs(other):
            why.append("what goes out is not what the proved library sends")
        if not why or sound:
            return None
        told = [_short(path) for path in (self._source, self._libraries[0].folder, file)]
        scan, whole = f"{scan_us}us", f"{scan_us * len(moments)}us"
        command = "rcx run {} --lib {} --stimulus {}".format(*told)
        files = tuple(str(path) for path in (self._source, file))
        return Found(f"{command} --scan {scan} --for {whole}", files, len(moments), why[0])

    def _replayed(
        self, lib: Path, file: Path, scan_us: int, moments: list[Moment], about: About
    ) -> tuple[list[tuple[str, str]], Judges | None]:
        """Return the findings in a cell, and the judges; None for these if a fault stopped it."""
        found: list[tuple[str, str]] = []
        scan = timedelta(microseconds=scan_us)
        with Cell.build(self._source, lib=lib, scan=scan, engine="builtin") as cell:
            Stimulus.load(file).schedule(cell)
            judges = Judges(cell.program, about)
            for moment in moments:
                try:
                    cell.scan(1)
                except InputError as error:
                    return [*found, (STOPS, str(error))], None
                found += judges.scan(moment)
        return found, judges


def _scan(program: Program, judges: Judges, moment: Moment) -> list[tuple[str, str]]:
    """Run a scan; return its findings."""
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
    """Return a path relative to the repository, if it is in there."""
    return str(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)


def _entries(moments: list[Moment]) -> Iterator[Entry]:
    """Yield the stimulus: the changes before each scan."""
    before: tuple[bytes, bool] | None = None
    for moment in moments:
        area = moment.area, moment.connected
        content, connected = (None, True) if area == before else area
        if moment.values or content is not None:
            yield Entry(moment.t_us, values=moment.values, area=content, connected=connected)
        before = area
