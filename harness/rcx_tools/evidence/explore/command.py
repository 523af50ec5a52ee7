"""Explore the models in several processes, print the figures and write them to a file.

Each good outcome is saved at once. A later run reuses an outcome if its inputs are unchanged.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Console
from rich.table import Table

from rcx_tools.evidence.explore import interlock
from rcx_tools.evidence.explore.interlock import InterlockModel
from rcx_tools.evidence.explore.model import Model
from rcx_tools.evidence.explore.models import MODELS
from rcx_tools.evidence.explore.replay import replay
from rcx_tools.evidence.explore.search import LIBRARY, Explorer
from rcx_tools.evidence.explore.seeded import SEEDED, Seeded
from rcx_tools.evidence.results import FOLDER, ROOT, write_result
from structured_text.explore.search import Broken, Result
from structured_text.farm import Farm
from structured_text.language.compiling import uncollected
from structured_text.output.results import Results, digest
from structured_text.output.system import processors
from structured_text.projects.needed import needed

__all__ = ["EVERY_BUG", "EVERY_MODEL", "OUT", "Item", "Known", "items", "main"]

#: A model of blocks on one robot, or a model of several robots at one area.
AnyModel = Model | InterlockModel
#: The outcome of an item: the fields of `Result`, broken rules, number of scans to the first of
#: them, and processor time [s].
Outcome = dict[str, Any]

#: Folder of the saved outcomes.
OUT = FOLDER
EVERY_MODEL: dict[str, AnyModel] = {model.name: model for model in (*MODELS, *interlock.MODELS)}
EVERY_BUG = (*SEEDED, *interlock.SEEDED)
#: Besides the blocks, a saved outcome depends on these modules and on the grammar. A change in one
#: of these makes the outcome invalid.
RULES = (
    *(f"structured_text/{name}" for name in ("engines", "explore", "language", "projects")),
    "rcx_harness/verify/explore/state_tables.py",
    "rcx_tools/evidence/explore",
)


@dataclass(frozen=True)
class Item:
    """A model to explore, or a seeded bug to find in a model."""

    model: str
    bug: Seeded | None = None

    @property
    def name(self) -> str:
        """Return the name of the item in texts for people."""
        return f"seeded: {self.bug.name}" if self.bug else self.model

    def is_good(self, outcome: Outcome) -> bool:
        """Return whether the model is complete without a broken rule, or the bug was found."""
        if self.bug is not None:
            return any(rule.startswith(self.bug.rule) for rule in outcome["rules"])
        return outcome["complete"] and not outcome["rules"]


def items(models: Iterable[AnyModel]) -> list[Item]:
    """Return all items, the slow items first.

    The models on one robot come first, in decreasing order of the number of choices.
    """

    def size(model: AnyModel) -> int:
        return 0 if isinstance(model, InterlockModel) else len(model.choices())

    found = [Item(model.name) for model in sorted(models, key=size, reverse=True)]
    names = {item.model for item in found}
    return [*found, *(Item(bug.model, bug) for bug in EVERY_BUG if bug.model in names)]


class Known:
    """Saved outcomes: of complete models without a broken rule, and of bugs that were found.

    Args:
        file: File with the saved outcomes.
        seed: Seed of the random values that check the abstraction.
        fresh: Whether to ignore the outcomes of earlier runs.
    """

    def __init__(self, file: Path, seed: int, *, fresh: bool = False) -> None:
        self._seed, self._results = seed, Results(file, fresh=fresh)
        places = [ROOT / "harness" / name for name in RULES]
        every = (one for place in places for one in [place, *place.rglob("*")])
        self._rules = [one for one in every if one.suffix in (".py", ".lark")]

    def get(self, item: Item) -> Outcome | None:
        """Return the saved outcome of an item, or None."""
        return self._results.get(self._key(item))

    def keep(self, item: Item, outcome: Outcome) -> None:
        """Save the outcome of an item if it is good."""
        if item.is_good(outcome):
            self._results.add({"key": self._key(item), **outcome})

    def _key(self, item: Item) -> str:
        with TemporaryDirectory() as folder:
            files = needed([EVERY_MODEL[item.model].write(Path(folder))], LIBRARY)
        return f"{item} {digest(ROOT, [*files, *self._rules])} {self._seed}"


@dataclass(frozen=True)
class _Exploring:
    """Worker that explores a model or searches for a seeded bug (see the command's arguments)."""

    library: tuple[Path, ...]
    limit: int
    seed: int

    def __call__(self, item: Item) -> Outcome:
        began, model, library = time.process_time(), EVERY_MODEL[item.model], self.library
        with TemporaryDirectory() as folder, uncollected():
            if item.bug is not None:
                library = tuple(item.bug.library(Path(folder), library))
            result = _search(model, library, 0 if item.bug else self.limit, self.seed)
            broken, result.broken = result.broken, None
            replayed = () if broken is None else _draw(item, model, broken, library)
        return {
            **asdict(result),
            "rules": replayed if item.bug or broken is None else broken.rules,
            "scans": len(broken.path) if broken else 0,
            "seconds": round(time.process_time() - began, 1),
        }


def _search(model: AnyModel, library: Sequence[Path], limit: int, seed: int) -> Result:
    """Explore a model completely, or up to a number of states."""
    if isinstance(model, InterlockModel):
        return interlock.explored(model, library, limit, seed)
    return Explorer(model, library, seed).run(limit)


def _draw(item: Item, model: AnyModel, broken: Broken, library: Sequence[Path]) -> tuple[str, ...]:
    """Replay a trace, write it with its chart, and return the rules that the replay breaks.

    For several robots at one area, the trace is a description in words.
    """
    folder = OUT / "explore"
    folder.mkdir(parents=True, exist_ok=True)
    name = f"seeded_{EVERY_BUG.index(item.bug) + 1:02}" if item.bug else item.model
    if isinstance(model, InterlockModel):
        rules = interlock.replay(model, broken, library)
        text = "\n".join([*interlock.told(broken.path), *rules])
        (folder / f"{name}.txt").write_text(text + "\n", encoding="utf-8")
        return rules
    shown = replay(model, broken, library, folder / f"{name}.jsonl")
    title = f"{model.name}: {broken.rules[0].partition(':')[0]}"
    (folder / f"{name}.svg").write_text(shown.chart(title), encoding="utf-8")
    return tuple(shown.rules)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 if every model is complete and no rule is broken."""
    parser = argparse.ArgumentParser(
        prog="python -m rcx_tools.evidence.explore", description=__doc__
    )
    names = list(EVERY_MODEL)
    parser.add_argument("models", nargs="*", metavar="MODEL", help=f"of {', '.join(names)}; all")
    parser.add_argument("--jobs", type=int, default=min(2, processors()))
    parser.add_argument("--limit", type=int, default=0, help="most states of a model; 0 = all")
    parser.add_argument("--lib", type=Path, help="another copy of plc/lib; nothing is saved")
    parser.add_argument("--fresh", action="store_true", help="forget the outcomes of earlier runs")
    parser.add_argument("--seed", type=int, default=1, help="of the checks of the abstraction")
    chosen = parser.parse_args(arguments)
    unknown = set(chosen.models) - set(names)
    if unknown:
        parser.error(f"no model {', '.join(sorted(unknown))}; there are {', '.join(names)}")
    wanted = chosen.models or names
    work = items(one for name, one in EVERY_MODEL.items() if name in wanted)
    console = Console(highlight=False)
    started = time.monotonic()
    outcomes = _outcomes(work, chosen, console)
    _print(console, outcomes)
    seconds = time.monotonic() - started
    console.print(f"{seconds:.0f} s; traces and charts of broken rules: out/verification/explore")
    met = all(item.is_good(outcome) for item, outcome in outcomes.items())
    if not chosen.models and not chosen.limit:
        write_result("explore", _figures(outcomes), met=met)
    return 0 if met else 1


def _outcomes(
    work: Sequence[Item], chosen: argparse.Namespace, console: Console
) -> dict[Item, Outcome]:
    """Return the outcome of every item in their order; run items without a saved outcome."""
    own = chosen.lib is None
    library = LIBRARY if own else tuple(sorted(chosen.lib.rglob("*.st")))
    known = Known(OUT / "explore.jsonl", chosen.seed, fresh=chosen.fresh) if own else None
    found = {item: one for item in work if known and (one := known.get(item)) is not None}
    for item, outcome in found.items():
        console.print(f"{item.name}: known from an earlier run; {_verdict(item, outcome)}")
    missing = [item for item in work if item not in found]
    exploring = _Exploring(library, chosen.limit, chosen.seed)
    for item, outcome in Farm(chosen.jobs).as_ready(exploring, missing):
        found[item] = outcome
        if known is not None:
            known.keep(item, outcome)
        console.print(f"{item.name} ({len(found)} of {len(work)}): {_verdict(item, outcome)}")
    return {item: found[item] for item in work}


def _verdict(item: Item, outcome: Outcome) -> str:
    if item.bug is not None:
        told = "" if item.is_good(outcome) else "NOT FOUND "
        return f"{told}after {outcome['scans']} scans: {' '.join(outcome['rules'][:1])}"
    if outcome["rules"]:
        return f"BROKEN after {outcome['scans']} scans: {outcome['rules'][0]}"
    return "all states, no rule broken" if outcome["complete"] else "not complete"


def _print(console: Console, outcomes: Mapping[Item, Outcome]) -> None:
    table = Table("model", "states", "transitions", "depth", "quiet after", "processor", "result")
    for column in table.columns[1:6]:
        column.justify = "right"
    for item, one in outcomes.items():
        bound = max(one["bounds"].values(), default=0)
        told = f"{bound} scans, {bound * EVERY_MODEL[item.model].tick_ms} ms" if bound > 0 else "-"
        numbers = (f"{one['states']:,}", f"{one['transitions']:,}", str(one["depth"]))
        table.add_row(item.name, *numbers, told, f"{one['seconds']:.0f} s", _verdict(item, one))
    console.print(table)


def _end(item: Item) -> str:
    """Return the event that ends a wait, as text: the channel is free, or a robot gets the area."""
    return "granted" if isinstance(EVERY_MODEL[item.model], InterlockModel) else "free"


def _figures(outcomes: Mapping[Item, Outcome]) -> dict[str, Any]:
    models = {item: one for item, one in outcomes.items() if item.bug is None}
    bugs = {item: one for item, one in outcomes.items() if item.bug is not None}

    def longest(end: str) -> int:
        bounds = [one["bounds"].values() for item, one in models.items() if _end(item) == end]
        return max((bound for some in bounds for bound in some), default=0)

    return {
        "states": sum(one["states"] for one in models.values()),
        "transitions": sum(one["transitions"] for one in models.values()),
        "checked_abstractions": sum(one["checked"] for one in models.values()),
        **{f"longest_until_{end}_scans": longest(end) for end in ("free", "granted")},
        "broken_rules": sum(bool(one["rules"]) for one in models.values()),
        "seeded_bugs": len(bugs),
        "seeded_bugs_found": sum(item.is_good(one) for item, one in bugs.items()),
        "processor_seconds": round(sum(one["seconds"] for one in models.values())),
        "models": {
            item.model: {
                **one,
                "title": EVERY_MODEL[item.model].title,
                "tick_ms": EVERY_MODEL[item.model].tick_ms,
                "bounds_scans": one["bounds"],
                "until": _end(item),
            }
            for item, one in models.items()
        },
        "seeded": {item.name: one for item, one in bugs.items()},
    }
