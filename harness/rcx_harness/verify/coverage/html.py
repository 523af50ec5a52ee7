"""The results as HTML: an overview, and a page with the source lines of each file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from rcx_harness.verify.coverage.measure import Condition, DecisionResult, FileResult, Item, Share
from rcx_harness.verify.coverage.report import gaps, totals

__all__ = ["write_pages"]

_COLUMNS = ("Statements", "Branches", "Conditions", "MC/DC", "Unique-cause")
#: A decision with more vectors shows its first ones only.
_MOST_VECTORS = 64


def write_pages(results: Sequence[FileResult], folder: Path, library: str) -> None:
    """Write index.html and a page per file.

    Args:
        results: All files.
        folder: Where to; it is made.
        library: What to call their folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / "index.html", f"Coverage of {library}", "", _overview(results))
    for result in results:
        back = '<a href="index.html">all files</a>'
        _write(folder / _page(result), result.path, back, _file(result))


def _page(result: FileResult) -> str:
    return result.path.replace("/", "-").removesuffix(".st") + ".html"


def _write(file: Path, title: str, back: str, body: Iterator[str]) -> None:
    style = files(__package__).joinpath("page.css").read_text(encoding="utf-8")
    lines = [
        "<!doctype html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>',
        f"<style>{style}</style></head><body>",
        f"<header><h1>{escape(title)}</h1>{back}</header><main>",
        *body,
        "</main></body></html>",
    ]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _overview(results: Sequence[FileResult]) -> Iterator[str]:
    yield '<p class="note">What the tests execute of each block, counted by the built-in engine.'
    yield "MC/DC is masking MC/DC; it is demanded where its bar is coloured.</p>"
    yield f"<table>{_head('Folder')}"
    for folder in sorted({result.folder for result in results}):
        yield _row(folder, [one for one in results if one.folder == folder], demanded=False)
    demanded = [one for one in results if one.demands_mcdc]
    yield _row("with MC/DC demanded", demanded, demanded=True)
    yield f"{_row('all', results, demanded=False)}</table>"
    for title, justified in (("Gaps", False), ("Justified", True)):
        found = gaps(results, justified=justified)
        yield f"<h2>{title}: {len(found) or 'none'}</h2><ul class='gaps'>"
        pages = {result.path: _page(result) for result in results}
        for gap in found:
            reason = f"<br><span class='note'>{escape(gap.reason)}</span>" if gap.reason else ""
            link = f'<a href="{pages[gap.path]}#L{gap.line}">{gap.path}:{gap.line}</a>'
            yield f"<li>{link} {escape(gap.text)}{reason}</li>"
        yield "</ul>"
    yield f"<h2>Files</h2><table>{_head('File')}"
    for result in results:
        link = f'<a href="{_page(result)}">{result.path}</a>'
        yield _row(link, [result], demanded=result.demands_mcdc)
    yield "</table>"


def _head(first: str) -> str:
    return f"<tr><th>{first}</th>{''.join(f'<th>{name}</th>' for name in _COLUMNS)}</tr>"


def _row(first: str, results: Sequence[FileResult], *, demanded: bool) -> str:
    cells = []
    for name, share in totals(results).items():
        free = name in ("conditions", "unique_cause") or (name == "mcdc" and not demanded)
        cells.append(_cell(share, free=free))
    return f"<tr><td>{first}</td>{''.join(cells)}</tr>"


def _cell(share: Share, *, free: bool) -> str:
    justified = f" +{share.justified}" if share.justified else ""
    text = f"{share.percent:.1f} % <small>{share.covered}/{share.total}{justified}</small>"
    bar = f'<div class="bar"><i style="width:{share.percent:.1f}%"></i></div>'
    return f'<td class="share{" free" if free else ""}">{text}{bar}</td>'


def _file(result: FileResult) -> Iterator[str]:
    yield f"<table>{_head('')}{_row('', [result], demanded=result.demands_mcdc)}</table>"
    yield "<h2>Source</h2><table class='code'>"
    statements = _by_line(result.statements)
    branches = _by_line(result.branches)
    for number, line in enumerate(result.source, 1):
        items, ways = statements.get(number, []), branches.get(number, [])
        style = _style([*items, *ways])
        hits = str(min(item.hits for item in items)) if items else ""
        chips = "".join(_chip(way) for way in ways)
        yield (
            f'<tr id="L{number}" class="{style}"><td class="no">{number}</td>'
            f'<td class="hits">{hits}</td><td class="text">{escape(line)}</td>'
            f'<td class="marks">{chips}</td></tr>'
        )
    yield "</table>"
    if result.decisions:
        yield "<h2>Decisions</h2><p class='note'>Its conditions, the values each has had, and"
        yield "whether it has decided the outcome both ways (in other respects alike: unique).</p>"
    for decision in result.decisions:
        yield from _decision(decision)


def _by_line(items: Sequence[Item]) -> dict[int, list[Item]]:
    found: dict[int, list[Item]] = {}
    for item in items:
        found.setdefault(item.line, []).append(item)
    return found


def _style(items: Sequence[Item]) -> str:
    if any(not item.hits and not item.reason for item in items):
        return "bad"
    if any(not item.hits for item in items):
        return "why"
    return "good" if items else ""


def _chip(way: Item) -> str:
    style, mark = ("good", "✓") if way.hits else ("why", "·") if way.reason else ("bad", "✗")
    title = f"{way.text}: {way.hits} times" if way.hits else f"{way.text}: never. {way.reason}"
    return f'<span class="chip {style}" title="{escape(title)}">{mark}</span>'


def _decision(decision: DecisionResult) -> Iterator[str]:
    complete = all(one.masking for one in decision.conditions)
    excused = all(one.masking or one.reason for one in decision.conditions)
    style, mark = ("yes", "✓") if complete else ("soft", "·") if excused else ("no-mark", "✗")
    opened = "" if complete else " open"
    yield f'<details{opened}><summary><span class="{style}">{mark}</span>'
    yield f'<a href="#L{decision.line}">{decision.line}</a> {escape(decision.text)}</summary>'
    yield "<table><tr><th></th><th>Condition</th><th>TRUE</th><th>FALSE</th><th>MC/DC</th>"
    yield "<th>Unique-cause</th><th></th></tr>"
    for letter, one in zip(_letters(), decision.conditions, strict=False):
        yield f"<tr><td>{letter}</td>{_condition(one)}</tr>"
    yield "</table>"
    if len(decision.conditions) > 1:
        yield from _vectors(decision)
    yield "</details>"


def _letters() -> Iterator[str]:
    for number in range(1000):
        yield chr(65 + number) if number < 26 else f"A{number - 26}"


def _condition(one: Condition) -> str:
    holds = (True in one.values, False in one.values, one.masking, one.unique)
    cells = "".join(
        f'<td class="{"yes" if yes else "no-mark"}">{"yes" if yes else "no"}</td>' for yes in holds
    )
    return f"<td>{escape(one.text)}</td>{cells}<td class='soft'>{escape(one.reason)}</td>"


def _vectors(decision: DecisionResult) -> Iterator[str]:
    letters = [letter for letter, _ in zip(_letters(), decision.conditions, strict=False)]
    yield f"<table><tr>{''.join(f'<th>{letter}</th>' for letter in letters)}<th>outcome</th></tr>"
    for vector, outcome in list(decision.vectors.items())[:_MOST_VECTORS]:
        cells = "".join(f"<td>{vector >> k & 1}</td>" for k in range(len(letters)))
        yield f"<tr>{cells}<td>{int(outcome)}</td></tr>"
    yield "</table>"
    if len(decision.vectors) > _MOST_VECTORS:
        yield f"<p class='note'>and {len(decision.vectors) - _MOST_VECTORS} more</p>"
