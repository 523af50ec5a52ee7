"""Outcomes of earlier runs: nothing is explored again while its inputs are unchanged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from rcx_tools.evidence.explore.interlock import InterlockModel
from rcx_tools.evidence.explore.model import Model
from rcx_tools.evidence.explore.models import MODELS
from rcx_tools.evidence.explore.search import LIBRARY
from rcx_tools.evidence.explore.seeded import Seeded
from rcx_tools.evidence.results import ROOT
from structured_text.explore.search import Result
from structured_text.output.results import Results, digest
from structured_text.projects.needed import needed

__all__ = ["OWN", "AnyModel", "Done", "Found", "Known", "defined_by"]

#: A model of the blocks on one robot, or of robots at one area.
AnyModel = Model | InterlockModel

_HERE = Path(__file__).parent
#: Inputs of a result beside blocks and models: the engine, and modules of this package.
_ENGINE = ("engines", "language", "projects")
_KINDS = ("*.py", "*.lark")
#: The modules in this folder that determine the result; below, those of all explorations.
OWN = ("model", "contract", "oracle", "search", "stages", "models")
_SHARED = (
    "structured_text/explore/abstraction.py",
    "structured_text/explore/kept.py",
    "rcx_harness/verify/explore/state_tables.py",
    "structured_text/explore/search.py",
)


class Done(NamedTuple):
    """An exploration, and the processor time that it took [s]."""

    result: Result
    seconds: float


class Found(NamedTuple):
    """The outcome of a seeded bug: scans (0: not found), and the rules broken in the replay."""

    bug: Seeded
    scans: int
    states: int
    rules: tuple[str, ...]


class Known:
    """Saved outcomes: complete models without a broken rule, and bugs that were found.

    Args:
        file: The file of the outcomes.
        seed: Seed of the checks of the abstraction.
        library: Files of the library; nothing is saved for another library than this package's.
        fresh: Forget the saved outcomes.
    """

    def __init__(
        self, file: Path, seed: int, library: Sequence[Path] = LIBRARY, *, fresh: bool = False
    ) -> None:
        self._seed, self._library = seed, library
        self._kept = Results(file, fresh=fresh) if tuple(library) == LIBRARY else None
        self._keys: dict[str, str] = {}

    def model(self, model: AnyModel) -> Done | None:
        """Return the saved outcome of a model, or None."""
        found = self._kept.get(self._key(model, model.name)) if self._kept else None
        return Done(Result(**found["result"]), found["seconds"]) if found else None

    def bug(self, bug: Seeded, model: AnyModel) -> Found | None:
        """Return the saved outcome of a seeded bug in its model, or None."""
        found = self._kept.get(self._key(model, repr(bug))) if self._kept else None
        return Found(bug, found["scans"], found["states"], tuple(found["rules"])) if found else None

    def keep(self, outcome: Done | Found, model: AnyModel) -> None:
        """Save an outcome if it is good."""
        if self._kept is None:
            return
        if isinstance(outcome, Found):
            if outcome.scans:
                key = self._key(model, repr(outcome.bug))
                entry = {"scans": outcome.scans, "states": outcome.states, "rules": outcome.rules}
                self._kept.add({"key": key, **entry})
        elif outcome.result.met:
            key = self._key(model, model.name)
            self._kept.add(
                {"key": key, "seconds": outcome.seconds, "result": asdict(outcome.result)}
            )

    def _key(self, model: AnyModel, name: str) -> str:
        if name not in self._keys:
            with TemporaryDirectory() as folder:
                files = needed([model.write(Path(folder))], self._library)
            rooms = [ROOT / "harness/structured_text" / name for name in _ENGINE]
            found = (file for room in rooms for kind in _KINDS for file in room.rglob(kind))
            rules = list(found)
            own = [_HERE / f"{part}.py" for part in defined_by(model)]
            shared = [ROOT / "harness" / part for part in _SHARED]
            state = digest(ROOT, [*files, *rules, *own, *shared])
            self._keys[name] = f"{model.name} {state} {self._seed} {name}"
        return self._keys[name]


def defined_by(model: AnyModel) -> tuple[str, ...]:
    """Return the modules in this folder that determine the results of a model."""
    if isinstance(model, InterlockModel):
        return ("interlock", "search")
    return OWN if model in MODELS else (*OWN, "models_small")
