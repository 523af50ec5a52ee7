"""Command `python -m rcx_tools.evidence.report`: run or reuse every check, and write the page.

A result is reused if the check was met and its sources have not changed since then. The command
writes out/verification.json (every figure), docs/explanation/verification.json (the figures of the
page) and docs/explanation/verification.md.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rcx_tools.evidence import page
from rcx_tools.evidence.checks import CHECKS, Check, digest, library_state
from rcx_tools.evidence.results import FOLDER, ROOT
from structured_text.errors import InputError

__all__ = ["is_current", "kept_figures", "main", "result_of", "stale", "stamped_run", "update"]

#: Folder of verification.md and verification.json.
DOCS = ROOT / "docs/explanation"

Run = Callable[[Check, Sequence[str]], int]


def _run(check: Check, arguments: Sequence[str]) -> int:
    module = f"rcx_tools.evidence.{check.name}"
    return subprocess.run(
        [sys.executable, "-m", module, *arguments], cwd=ROOT, check=False
    ).returncode


def result_of(check: Check, folder: Path) -> dict[str, Any] | None:
    """Return the last result of a check, even if its sources have changed.

    Without a result return None.
    """
    file = folder / f"{check.name}.json"
    if not file.is_file():
        return None
    result: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return result


def stamped_run(check: Check, arguments: Sequence[str], folder: Path, run: Run) -> int:
    """Run a check, and record the state of its sources.

    The state is not recorded if the sources have changed during the run, if the check has left no
    new result, or if its arguments may have limited the run. The check then runs again next time.
    """
    stamp = folder / f"{check.name}.state"
    stamp.unlink(missing_ok=True)
    state, begin = digest(check.sources), time.monotonic()
    before = _written(check, folder)
    code = run(check, arguments)
    new = _written(check, folder) != before
    if new and not arguments and digest(check.sources) == state:
        seconds = round(time.monotonic() - begin)
        note = {"sources": state, "library": library_state(), "seconds": seconds}
        stamp.write_text(json.dumps(note) + "\n", encoding="utf-8")
    return code


def _written(check: Check, folder: Path) -> int:
    """Return the time at which the result of a check was written. Without a result return 0."""
    file = folder / f"{check.name}.json"
    return file.stat().st_mtime_ns if file.is_file() else 0


def is_current(check: Check, folder: Path) -> bool:
    """Return whether the check was met with the present sources."""
    stamp, result = folder / f"{check.name}.state", result_of(check, folder)
    if result is None or not result["met"] or not stamp.is_file():
        return False
    noted = json.loads(stamp.read_text(encoding="utf-8"))["sources"]
    return bool(noted == digest(check.sources))


def kept_figures(results: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the figures for verification.md.

    Raises:
        InputError: a check does not give a figure that the page shows.
    """
    checks = {
        check.name: {
            "met": results[check.name]["met"],
            "library": results[check.name].get("state", {}).get("library", ""),
            **_told(check, results[check.name]["figures"]),
        }
        for check in CHECKS
        if check.name in results
    }
    return {"library": library_state(), "checks": checks}


def _told(check: Check, figures: dict[str, Any]) -> dict[str, Any]:
    told: dict[str, Any] = {"rows": _rows(check, figures)}
    if check.tables:
        told["tables"] = [
            [heads, *lines] for heads, lines in (one(figures) for one in check.tables)
        ]
    return told


def _rows(check: Check, figures: dict[str, Any]) -> list[list[str]]:
    rows = []
    for label, told in check.rows:
        try:
            rows.append([label, told(figures)])
        except (KeyError, TypeError) as error:
            text = f"out/verification/{check.name}.json does not give: {label}"
            raise InputError(text, hint=f"run `{check.command}` again") from error
    return rows


def stale(kept: Path) -> str:
    """Return the reason why `make verification` must run before a release, or an empty text."""
    if not kept.is_file():
        return "there are no figures yet"
    figures = json.loads(kept.read_text(encoding="utf-8"))
    if figures["library"] != library_state():
        return f"its figures are of library state {figures['library']}, not {library_state()}"
    open_ones = [one.name for one in CHECKS if not page.is_met(figures, one)]
    return f"not met, not run or older: {', '.join(open_ones)}" if open_ones else ""


def update(folder: Path, docs: Path) -> bool:
    """Write page and figures from existing results. Return whether all checks are met."""
    found = {check.name: result_of(check, folder) for check in CHECKS}
    results = {name: result for name, result in found.items() if result is not None}
    for name in results:
        stamp = folder / f"{name}.state"
        if stamp.is_file():
            results[name]["state"] = json.loads(stamp.read_text(encoding="utf-8"))
    kept = kept_figures(results)
    met = all(page.is_met(kept, check) for check in CHECKS)
    every = {"library": kept["library"], "met": met, "checks": results}
    _write(folder.parent / "verification.json", every)
    _write(docs / "verification.json", kept)
    text = page.verification_page(docs / "verification.json")
    (docs / "verification.md").write_text(text, encoding="utf-8")
    return met


def _write(file: Path, content: Any) -> None:
    text = json.dumps(content, indent=1, ensure_ascii=False)
    file.write_text(text + "\n", encoding="utf-8")


def _options(arguments: Sequence[str] | None) -> tuple[Namespace, list[str]]:
    parser = ArgumentParser(prog="python -m rcx_tools.evidence.report", description=__doc__)
    names = [check.name for check in CHECKS]
    parser.add_argument("--only", choices=names, help="run only this check; must be the first")
    parser.add_argument("--fresh", action="store_true", help="do not reuse results")
    parser.add_argument("--page", action="store_true", help="only write the page and its figures")
    parser.add_argument("--check", action="store_true", help="exit code 1 if the page is old")
    parser.add_argument("--remind", action="store_true", help="only report whether the page is old")
    given = list(sys.argv[1:] if arguments is None else arguments)
    own = 2 if given[:1] == ["--only"] else len(given)
    return parser.parse_args(given[:own]), given[own:]


def main(arguments: Sequence[str] | None = None, run: Run = _run) -> int:
    """Run or reuse the checks. Return 0 if every check is met, 1 if not, 130 after Ctrl-C."""
    options, rest = _options(arguments)
    try:
        return _main(options, rest, run)
    except KeyboardInterrupt:
        print("stopped; the next run goes on from here", file=sys.stderr)
        return 130


def _main(options: Namespace, rest: list[str], run: Run) -> int:
    console = Console(highlight=False)
    if options.check or options.remind:
        why = stale(DOCS / "verification.json")
        if why:
            console.print(
                f"docs/explanation/verification.md: {why}; `make verification`", soft_wrap=True
            )
        return int(bool(why) and options.check)
    FOLDER.mkdir(parents=True, exist_ok=True)
    if options.only:
        check = next(one for one in CHECKS if one.name == options.only)
        return stamped_run(check, rest, FOLDER, run)
    told = {check.name: "" if options.page else "run" for check in CHECKS}
    for number, check in enumerate(CHECKS, 1):
        if not options.fresh and is_current(check, FOLDER):
            told[check.name] = "reused"
        if not options.page:
            console.print(f"{number}/{len(CHECKS)} {check.title}: {told[check.name]}")
        if told[check.name] == "run":
            stamped_run(check, (), FOLDER, run)
    try:
        met = update(FOLDER, DOCS)
    except InputError as error:
        console.print(str(error), markup=False, soft_wrap=True)
        return 2
    table = Table("check", "", "result", "command", box=None)
    for check in CHECKS:
        result = result_of(check, FOLDER)
        verdict = "no result" if result is None else "met" if result["met"] else "NOT MET"
        table.add_row(check.title, told[check.name], verdict, check.command)
    console.print(table)
    console.print("docs/explanation/verification.md, out/verification.json")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
