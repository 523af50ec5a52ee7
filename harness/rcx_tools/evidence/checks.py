"""The checks of verification.md, in their order, each with its text, figures and inputs."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcx_tools.evidence.results import ROOT

__all__ = ["CHECKS", "Check", "Row", "Table", "digest", "library_state"]

Figures = Mapping[str, Any]
#: A row of verification.md: a label, and a function that formats the figure.
Row = tuple[str, Callable[[Figures], str]]
#: A table of verification.md: a function that makes headings and rows from the figures.
Table = Callable[[Figures], tuple[list[str], list[list[str]]]]

#: Inputs of every check: the library, its tables, and the code that compiles and runs the library.
_BASE = (
    "plc/lib",
    "spec",
    "harness/rcx_tools/library",
    *(f"harness/rcx_harness/{name}" for name in ("cell", "robot", "spec", "trace", "watch")),
    *(f"harness/structured_text/{name}" for name in ("bench", "engines", "errors", "language")),
    "harness/structured_text/projects",
    "harness/structured_text/output/units.py",
)
#: Modules of this package that several checks use.
_SHARED = ("broken", "results", "running_tests")
_KINDS = {".py", ".st", ".toml", ".lark", ".c", ".jsonl"}


@dataclass(frozen=True)
class Check:
    """One of the checks behind `make verification`.

    Attributes:
        name: Name as in `make NAME` and out/verification/NAME.json.
        title: Title for people.
        kind: `proved` if every case of a given model was checked, otherwise `tested`.
        about: Meaning of the figures, and their limits.
        rows: Figures of the check on the page.
        inputs: Files and folders that the check depends on, in addition to the library and the code
            that runs it. A name without ending means all files that begin with this name.
        tables: Additional tables of the page.
    """

    name: str
    title: str
    kind: str
    about: str
    rows: tuple[Row, ...]
    inputs: tuple[str, ...]
    tables: tuple[Table, ...] = ()

    @property
    def command(self) -> str:
        """Return the command that runs the check."""
        return f"make {self.name}"

    @property
    def sources(self) -> tuple[str, ...]:
        """Return all files and folders that the check depends on."""
        rooms = (
            "harness/structured_text",
            "harness/rcx_harness/verify",
            "harness/rcx_tools/evidence",
        )
        own = (f"{room}/{self.name}" for room in rooms if any((ROOT / room).glob(f"{self.name}*")))
        shared = (f"harness/rcx_tools/evidence/{name}.py" for name in _SHARED)
        return (*_BASE, *own, *shared, *self.inputs)


def _files(root: Path, names: tuple[str, ...]) -> Iterator[Path]:
    for name in names:
        start = root / name
        for found in [start] if start.exists() else start.parent.glob(f"{start.name}*"):
            inside = found.rglob("*") if found.is_dir() else [found]
            yield from (one for one in inside if one.suffix in _KINDS and one.is_file())


def digest(names: tuple[str, ...], root: Path = ROOT) -> str:
    """Return a digest of names and contents of files and folders: 12 hexadecimal digits."""
    state = hashlib.sha256()
    for file in sorted(set(_files(root, names))):
        state.update(file.relative_to(root).as_posix().encode() + b"\0")
        state.update(hashlib.sha256(file.read_bytes()).digest())
    return state.hexdigest()[:12]


def library_state(root: Path = ROOT) -> str:
    """Return the digest of plc/lib. It is stored with the figures."""
    return digest(("plc/lib",), root)


def _number(*path: str) -> Callable[[Figures], str]:
    """Return a formatter of a figure with thousands separators."""

    def told(figures: Figures) -> str:
        value: Any = figures
        for key in path:
            value = value[key]
        return f"{value:,}" if isinstance(value, (int, float)) else str(value)

    return told


def _count(key: str) -> Callable[[Figures], str]:
    """Return a formatter of a count: the length of a list, or the sum of a table of numbers."""
    return lambda figures: (
        f"{sum(figures[key].values()):,}"
        if isinstance(figures[key], dict)
        else f"{len(figures[key])}"
    )


def _share(*path: str) -> Callable[[Figures], str]:
    """Return a formatter of coverage, such as `99.5 % (199 of 200, 1 justified)`."""

    def told(figures: Figures) -> str:
        share: Any = figures
        for key in path:
            share = share[key]
        more = f", {share['justified']} justified" if share["justified"] else ""
        return f"{share['percent']:.2f} % ({share['covered']:,} of {share['total']:,}{more})"

    return told


def _of(found: str, every: str) -> Callable[[Figures], str]:
    return lambda figures: f"{figures[found]} of {figures[every]}"


def _models(figures: Figures) -> str:
    models = figures["models"].values()
    complete = sum(bool(one["complete"]) for one in models)
    return f"{complete} of {len(models)}"


def _longest(figures: Figures) -> str:
    bounds = [
        (bound * one["tick_ms"], bound)
        for one in figures["models"].values()
        for bound in one["bounds_scans"].values()
        if one["until"] == "free"
    ]
    time, scans = max(bounds, default=(0, 0))
    return f"{scans} scans, {time:,} ms"


def _survivors(figures: Figures) -> str:
    return f"{len(figures['survivors'])}, {figures['survivors_with_a_reason']} with a reason"


#: The kinds of mutants outside the library.
_HARNESS_KINDS = (
    ("controller", "the virtual controller"),
    ("monitors", "the monitors"),
    ("engine", "the built-in engine"),
    ("tables", "the tables"),
)


def _mutants_of(kind: str) -> Callable[[Figures], str]:
    """Return a formatter such as `270 of 280 killed, 96.4 %; survivors 10, 10 with a reason`."""

    def told(figures: Figures) -> str:
        one = figures["kinds"][kind]
        killed = f"{one['killed']:,} of {one['mutants']:,} killed, {one['score']:.1f} %"
        return f"{killed}; survivors {_survivors(one)}"

    return told


def _seeded(figures: Figures) -> str:
    found = figures["kinds"]["seeded"]
    return f"{found['killed']} of {found['mutants']}"


def _total(key: str) -> Callable[[Figures], str]:
    """Return a formatter for the sum of a figure over all properties."""
    return lambda figures: f"{round(sum(item[key] for item in figures['properties'])):,}"


def _proved(figures: Figures) -> str:
    items = figures["properties"]
    return f"{sum(item['status'] == 'proved' for item in items)} of {len(items)}"


def _of_seeded(key: str) -> Callable[[Figures], str]:
    return lambda figures: f"{figures['seeded'][key]} of {figures['seeded']['tried']}"


def _agreement(figures: Figures) -> str:
    """Return a text about the number of scans in which formulas and engines agree."""
    if "agreement" not in figures:
        return "not run"
    one = figures["agreement"]
    told = f"{one['scans']:,} of {one['blocks']} blocks, at least {one['least_of_a_block']} of each"
    told += " (blocks that call SIN, COS or ATAN are left out)"
    return f"{told}; {one['matiec']['says']}; differences {len(one['disagreements'])}"


def _properties(figures: Figures) -> tuple[list[str], list[list[str]]]:
    """Return the table of the proved properties.

    The assumptions of a property include the assumptions of the properties that it uses.
    """
    heads = ["Property", "What is proved", "Manual", "Assumes", "Uses", "Goals", "Solver [s]"]
    return heads, [
        [
            f"`{item['name']}`" + ("" if item["status"] == "proved" else f" **{item['status']}**"),
            item["says"],
            item["section"],
            ", ".join(item["assumes"]),
            ", ".join(f"`{name}`" for name in item["uses"]),
            f"{item['goals']:,}",
            f"{item['seconds']:,}",
        ]
        for item in figures["properties"]
    ]


def _assumptions(figures: Figures) -> tuple[list[str], list[list[str]]]:
    """Return the table of the assumptions of the proofs, by name."""
    return ["Assumption", "Taken for granted"], [[*one] for one in figures["assumptions"].items()]


CHECKS: tuple[Check, ...] = (
    Check(
        "prove",
        "Proved for every program",
        "proved",
        "The library's Structured Text is translated for an SMT solver, with the arithmetic of "
        "the machine. Each property holds in every scan of any program between FB_ReadArea and "
        "FB_WriteArea, for any scan time and any pins, as long as the program meets the "
        "assumptions below. The proof is an induction over one call from any state. The results "
        "of functions with long loops are proved once (`functions`); the other proofs use them. "
        "In the proofs of FB_MoveTable, FB_PickPlace and FB_WorkCycle the inner blocks may do "
        "anything that is proved of them. Bugs are put into copies of the library, and break "
        "the properties that they should. For every other property two parts that depend on the "
        "changed file are proved again; slow parts are left out (prove/seeded.py lists them, and "
        "out/prove.json names properties that are left out as a whole).",
        (
            ("properties proved", _proved),
            ("goals", _total("goals")),
            ("time of the solver [s]", _total("seconds")),
            ("scans in which translation and engine agree", _agreement),
            ("seeded bugs that break exactly what they should", _of_seeded("as_expected")),
        ),
        ("tests/tools/evidence/proof_bugs",),
        (_properties, _assumptions),
    ),
    Check(
        "explore",
        "Exhaustive exploration",
        "proved",
        "Small programs of the real compiled blocks run through every state that they can reach, "
        "with every choice of the environment in each scan. No rule of the wire or of the "
        "contract is broken, and from every state the channel becomes free once the inputs are "
        "quiet. Four of the programs use FB_Interlock for one area: three robots that request, "
        "enter and leave it, or two robots with losses, intruders and a time limit. There are "
        "never two robots in the area; they enter in turn, within 5 scans once the area is free. "
        "From every state a robot that keeps its request without a time limit is let in when the "
        "others leave, with one changed input per scan. This is a proof for these programs and "
        "this abstraction of time, not for any program.",
        (
            ("models explored to the end", _models),
            ("states", _number("states")),
            ("transitions", _number("transitions")),
            ("longest until the channel is free", _longest),
            (
                "longest wait of a robot for an area, in scans after the others begin to leave",
                _number("longest_until_granted_scans"),
            ),
            ("broken rules", _number("broken_rules")),
            ("seeded bugs found, with a shortest trace", _of("seeded_bugs_found", "seeded_bugs")),
            ("processor time of the models [s]", _number("processor_seconds")),
        ),
        ("tests/tools/evidence/bugs/explore.toml", "tests/tools/evidence/bugs/interlock.toml"),
    ),
    Check(
        "contract",
        "Contract monitor",
        "tested",
        "Every block with Robot and Execute or Enable runs with patterns of these pins, with "
        "different answers of the controller, and with faults at each scan. The contract of the "
        "block, the interval of 100 ms and the handshake are checked in every scan. "
        "`make test-all` includes all of these cases. FB_Operator (keys), FB_PackMl (commands, "
        "acting states) and blocks without Robot do not have these pins. For them it is proved "
        "above that Error is TRUE exactly with an ErrorID; their own tests check the rest.",
        (
            ("cases: block x Execute x answer x moment", _number("instances")),
            ("on a bench, all of these blocks", _number("instances_on_the_bench")),
            ("on the virtual controller", _number("instances_on_the_virtual_controller")),
            ("blocks on the bench", _number("blocks")),
            ("scans judged on the bench", _number("scans_on_the_bench")),
            ("failed", _count("failed")),
            ("broken blocks found", _of("broken_blocks_found", "broken_blocks")),
            ("run time [s]", _number("seconds")),
        ),
        ("tests/contract", "tests/faults", "tests/support"),
    ),
    Check(
        "coverage",
        "Coverage of the Structured Text",
        "tested",
        "The built-in engine counts what the tests execute. Masking MC/DC is required for area, "
        "core, sequence and FB_RemoteCommand; gaps have a reason in "
        "[conditions.toml](../../tests/tools/evidence/conditions.toml) or in the line itself.",
        (
            ("statements", _share("all", "statements")),
            ("branches", _share("all", "branches")),
            ("conditions", _share("all", "conditions")),
            ("MC/DC where it is required", _share("mcdc_demanded", "mcdc")),
            ("tests", _number("tests")),
            ("gaps without a reason", _number("gaps")),
        ),
        tuple(
            f"tests/{name}"
            for name in (
                *("area", "sequence", "command", "motion", "position", "points", "operator"),
                *("diagnosis", "chapters", "cell"),
                *("contract", "watch"),
                *("faults", "examples", "support", "data", "tools/evidence/conditions.toml"),
            )
        ),
    ),
    Check(
        "mutants",
        "Mutation testing",
        "tested",
        "The tests run on copies with one small, typical fault each: in the library, the virtual "
        "controller, the monitors, the built-in engine, and the tables in spec/ from which "
        "plc/lib is generated. A mutant is killed when a test fails. Generated command blocks are "
        "alike, so they are sampled, as is everything outside the library (`MUTANTS=all` takes "
        "all). Survivors, and why no test can find them: "
        "[survivors.toml](../../tests/tools/evidence/survivors.toml), "
        "[survivors_harness.toml](../../tests/tools/evidence/survivors_harness.toml). "
        "Bugs that were written by hand: [seeded.toml](../../tests/tools/evidence/seeded.toml).",
        (
            ("mutants", _number("mutants")),
            ("killed", _number("killed")),
            ("score [%]", _number("score")),
            ("survivors", _survivors),
            *((f"mutants of {what}", _mutants_of(kind)) for kind, what in _HARNESS_KINDS),
            ("seeded bugs found", _seeded),
            ("mutants of each generated block", _number("of_each_generated_block")),
            ("time of the last run, which reuses known outcomes [s]", _number("run_time_s")),
        ),
        (
            *(f"tests/{name}" for name in ("area", "sequence", "command", "motion", "position")),
            *(f"tests/{name}" for name in ("points", "operator", "diagnosis")),
            *(
                f"tests/{name}"
                for name in (
                    *("chapters", "faults", "examples"),
                    *("tools/library", "support", "data"),
                )
            ),
            *(f"tests/{name}" for name in ("robot", "cell", "contract", "engine", "spec", "watch")),
            "tests/tools/evidence/survivors",
            "tests/tools/evidence/seeded.toml",
        ),
    ),
    Check(
        "campaign",
        "Fault campaign",
        "tested",
        "Long random runs contain lost, late and doubled packets, scan overruns, power cycles, "
        "alarms and operators. No rule is broken, no command is executed twice or lost without "
        "an error, and the cell recovers each time. Every run can be repeated by its seed.",
        (
            ("virtual hours", _number("virtual hours")),
            ("seeds", _number("seeds")),
            ("scans", _number("scans")),
            ("requests of command blocks", _number("requests of command blocks")),
            ("executions in the controller", _number("executions in the controller")),
            ("faults", _count("faults")),
            ("longest until at rest [s]", _number("longest until the cell is at rest [s]")),
            ("longest recovery [s]", _number("longest recovery with work [s]")),
            ("failing seeds", _count("failing seeds")),
            ("broken blocks found", _number("broken blocks found")),
            ("engine", _number("engine")),
        ),
        ("tests/tools/evidence/bugs/campaign.toml",),
    ),
)
