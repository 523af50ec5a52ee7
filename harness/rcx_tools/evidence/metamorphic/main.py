"""Command `python -m rcx_tools.evidence.metamorphic`: try the changes that must not matter."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from rcx_tools.evidence.broken import library_copy
from rcx_tools.evidence.metamorphic.course import Options, follow
from rcx_tools.evidence.metamorphic.programs import Subject, subjects
from rcx_tools.evidence.metamorphic.relations import RELATIONS
from rcx_tools.evidence.metamorphic.seeded import SEEDED, find
from rcx_tools.evidence.results import write_result
from structured_text.errors import InputError
from structured_text.farm import Farm

__all__ = ["main"]

#: The engine of all runs except those that compare the engines: every machine has it.
_ENGINE = "builtin"


class _Job(NamedTuple):
    """A relation to try on a program; or, with `seeded`, a broken block to find."""

    subject: str
    relation: str
    seed: int
    lib: Path
    seeded: int = -1


class _Result(NamedTuple):
    job: _Job
    variants: int
    scans: int
    differences: tuple[str, ...]
    against: str


def _subject(name: str) -> Subject:
    return next(one for one in subjects() if one.name == name)


def _run(job: _Job) -> _Result:
    subject, relation = _subject(job.subject), RELATIONS[job.relation]
    if job.seeded >= 0:
        found = find(SEEDED[job.seeded], subject)
        return _Result(job, 1, 0, (found,) if found else (), "")
    if against := relation.against(subject):
        return _Result(job, 0, 0, (), against)
    options = Options(engine=_ENGINE, lib=job.lib)
    differences, count, scans = [], 0, 0
    try:
        base = follow(relation.basis(subject), options)
        for variant in relation.variants(subject, options, job.seed):
            course = follow(variant.subject, variant.options)
            count += 1
            scans += len(course.scans)
            if difference := relation.differs(base, course):
                differences.append(f"{variant.name}: {difference}")
    except InputError as error:
        differences.append(str(error))
    return _Result(job, count, scans, tuple(differences), "")


def _options(arguments: list[str] | None) -> Namespace:
    parser = ArgumentParser(prog="python -m rcx_tools.evidence.metamorphic", description=__doc__)
    parser.add_argument("--only", default="", help="programs whose name has this text")
    parser.add_argument("--relation", choices=list(RELATIONS), help="this relation only")
    parser.add_argument("--seed", type=int, default=0, help="of the offsets that are drawn")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    return parser.parse_args(arguments)


def _jobs(options: Namespace, lib: Path) -> list[_Job]:
    """Return the jobs, the longest first."""
    named = [one.name for one in reversed(subjects()) if options.only in one.name]
    relations = [options.relation] if options.relation else list(RELATIONS)
    jobs = [_Job(name, relation, options.seed, lib) for name in named for relation in relations]
    if not options.only and not options.relation:
        jobs += [_Job(one.subject, one.relation, 0, lib, k) for k, one in enumerate(SEEDED)]
    return jobs


def main(arguments: list[str] | None = None) -> int:
    """Try every relation on every program; return 0 if all hold, else 1."""
    options = _options(arguments)
    with library_copy() as lib:
        whole = not (options.only or options.relation)
        return _main(_jobs(options, lib), options.jobs, Console(), whole=whole)


def _main(jobs: list[_Job], workers: int, console: Console, *, whole: bool) -> int:
    variants: Counter[str] = Counter()
    programs: Counter[str] = Counter()
    scans, found = 0, 0
    broken: list[str] = []
    against: set[str] = set()
    for job, result in Farm(workers, console=console).run(_run, jobs, title="metamorphic"):
        if job.seeded >= 0:
            found += bool(result.differences)
            if not result.differences:
                broken.append(f"the broken block is not found: {SEEDED[job.seeded].name}")
            continue
        scans += result.scans
        variants[job.relation] += result.variants
        programs[job.relation] += not result.against
        if result.against:
            against.add(f"{job.relation}, {job.subject}: {result.against}")
        broken += [f"{job.subject}, {job.relation}, {one}" for one in result.differences]
    table = Table("relation", "programs", "variants", "the same means", title="Metamorphic checks")
    for name in sorted(variants, key=list(RELATIONS).index):
        statement = RELATIONS[name].statement
        table.add_row(name, str(programs[name]), str(variants[name]), statement)
    console.print(table)
    for text in [*sorted(against), *sorted(broken)]:
        console.print(text, highlight=False)
    figures = {
        "relations": {
            name: {
                "programs": programs[name],
                "variants": variants[name],
                "the same means": RELATIONS[name].statement,
            }
            for name in RELATIONS
        },
        "scans compared": scans,
        "not applicable": sorted(against),
        "differences": sorted(broken),
        "broken blocks found": f"{found} of {len(SEEDED)}",
    }
    if whole:
        write_result("metamorphic", figures, met=not broken)
    return 1 if broken else 0
