"""The results as HTML: an overview, and a page with the source lines of each file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from importlib.resources import files

from structured_text.coverage.drawings import picture
from structured_text.coverage.measure import Condition, DecisionResult, FileResult, Item, Share
from structured_text.coverage.report import Gap, conditions, gaps, totals
from structured_text.errors import COMMAND
from structured_text.projects.diagrams.networks.draw.svg import STYLE

__all__ = ["pages"]

_COLUMNS = ("Statements", "Branches", "Conditions", "MC/DC", "Unique-cause")
#: Greatest number of vectors that a page shows for a decision.
_MOST_VECTORS = 64


def pages(results: Sequence[FileResult], title: str) -> dict[str, str]:
    """Return the texts of index.html and of a page per file, by file name.

    Each page is self-contained.
    """
    names = _names(results)
    found = {"index.html": _page(f"Coverage of {title}", "", _overview(results, names))}
    back = '<a id="back" href="index.html">all files</a>'
    for result in results:
        found[names[result.path]] = _page(result.path, back, _file(result))
    return found


def _names(results: Sequence[FileResult]) -> dict[str, str]:
    """Return the name of the HTML page for each source file."""
    names: dict[str, str] = {}
    taken = {"index.html"}
    for result in results:
        plain = re.sub(r"[^\w.-]+", "-", result.path.removesuffix(".st")).strip("-")
        name = next(
            one
            for number in range(1, len(results) + 2)
            if (one := f"{plain}{f'-{number}' if number > 1 else ''}.html").lower() not in taken
        )
        taken.add(name.lower())
        names[result.path] = name
    return names


def _page(title: str, back: str, body: Iterator[str]) -> str:
    style, script = (
        files(__package__).joinpath(name).read_text(encoding="utf-8")
        for name in ("page.css", "page.js")
    )
    lines = [
        "<!doctype html>",
        f"<!-- {COMMAND} coverage -->",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title><style>{style}</style></head><body>",
        f"<header><h1>{escape(title)}</h1>{back}</header><main>",
        *body,
        f"</main><script>{script}</script></body></html>",
    ]
    return "\n".join(lines) + "\n"


def _overview(results: Sequence[FileResult], names: Mapping[str, str]) -> Iterator[str]:
    demanded = [one for one in results if one.demands_mcdc]
    yield '<p class="note">Executed code, as counted by the built-in engine. MC/DC is masking'
    yield f"MC/DC{'; it is demanded where its bar is coloured' if demanded else ''}.</p>"
    yield f"<div class='wide'><table>{_head('Folder')}"
    for folder in sorted({result.folder for result in results if "/" in result.path}):
        some = [one for one in results if one.path.startswith(f"{folder}/")]
        yield _row(escape(folder), some, demanded=False)
    if demanded:
        yield _row("with MC/DC demanded", demanded, demanded=True)
    yield f"{_row('all', results, demanded=False)}</table></div>"
    yield f"<h2>Files</h2><div class='wide'><table>{_head('File')}"
    for result in results:
        link = f'<a href="{names[result.path]}">{escape(result.path)}</a>'
        yield _row(link, [result], demanded=result.demands_mcdc)
    yield "</table></div>"
    for title, justified in (("Not covered", False), ("Justified", True)):
        found = gaps(results, justified=justified)
        if found or not justified:
            yield f"<h2>{title}: {len(found) or 'nothing'}</h2><ul class='gaps'>"
            yield from (_gap(one, names[one.path], f"{one.path}:") for one in found)
            yield "</ul>"


def _gap(gap: Gap, page: str, path: str) -> str:
    reason = f"<br><span class='note'>{escape(gap.reason)}</span>" if gap.reason else ""
    link = f'<a href="{page}#L{gap.line}">{escape(path)}{gap.line}</a>'
    network = f"{escape(gap.network)}: " if gap.network else ""
    return f"<li>{link} {network}{escape(gap.text)}{reason}</li>"


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
    text = f"{share.shown} <small>{share.covered}/{share.total}{justified}</small>"
    bar = f'<div class="bar"><i style="width:{share.percent:.1f}%"></i></div>'
    return f'<td class="share{" free" if free else ""}">{text}{bar}</td>'


def _file(result: FileResult) -> Iterator[str]:
    yield f"<div class='wide'><table>{_head('')}"
    yield f"{_row('', [result], demanded=result.demands_mcdc)}</table></div>"
    found = gaps([result])
    if not result.demands_mcdc:
        found += [one for one in conditions(result) if not one.reason]
    yield f"<h2>Not covered: {len(found) or 'nothing'}</h2><ul class='gaps'>"
    yield from (_gap(one, "", "line ") for one in sorted(found, key=lambda one: one.line))
    yield "</ul><h2>Source</h2><p class='note'>Keys: <kbd>n</kbd> and <kbd>p</kbd> go to the next"
    yield "and the previous line that is not covered, <kbd>i</kbd> to all files. The columns before"
    yield "a line show how often it was executed, and its branches.</p>"
    if result.drawings:
        yield f"<style>{STYLE}</style><p class='note'>In a drawing, a contact is thick if it was"
        yield "closed at some time, and a coil or box if it was TRUE or executed at some time.</p>"
    yield "<div class='wide' tabindex='0'><table class='code'>"
    statements = _by_line(result.statements)
    branches = _by_line(result.branches)
    last = count = 0
    for network, numbers in _groups(result):
        if network:
            yield f'<tr class="network"><th colspan="4">{escape(network)}</th></tr>'
            for place in network.split("; "):
                if place in result.drawings:
                    count += 1
                    drawn = picture(result, place, f"drawing-{count}")
                    yield f"<tr><td colspan='4'>{drawn}</td></tr>"
        for number in numbers:
            if number != last + 1 and not network:
                yield '<tr class="gap"><td class="no">⋮</td><td></td><td></td><td></td></tr>'
            last = number
            items, ways = statements.get(number, []), branches.get(number, [])
            if network:
                yield from _translated(number, result.source[number], items, ways)
            else:
                yield _line(number, result.source[number], items, ways)
    yield "</table></div>"
    if result.decisions:
        yield "<h2>Decisions</h2><p class='note'>For each condition, its values, and whether it"
        yield "has decided the outcome as TRUE and as FALSE (unique: no other one differed).</p>"
    for decision in result.decisions:
        yield from _decision(decision, result.networks.get(decision.line, ""))


def _groups(result: FileResult) -> list[tuple[str, list[int]]]:
    """Return the numbers of the lines to show, in groups with the rung or network of each group.

    Elements of several networks may be mixed in the file. Each network is shown once, at the place
    of its first line.
    """
    groups: list[tuple[str, list[int]]] = []
    drawn: dict[str, list[int]] = {}
    for number in sorted(result.source):
        network = result.networks.get(number, "")
        if network in drawn:
            drawn[network].append(number)
        elif groups and groups[-1][0] == network:
            groups[-1][1].append(number)
        else:
            groups.append((network, [number]))
            if network:
                drawn[network] = groups[-1][1]
    return groups


def _translated(
    number: int, text: str, items: Sequence[Item], ways: Sequence[Item]
) -> Iterator[str]:
    """Yield the rows of an element of a drawing: each line of its translation, with its counts."""
    waiting = list(items)
    for row, line in enumerate(text.split("\n")):
        found = next((item for item in waiting if item.text == line.strip()), None)
        if found is not None:
            waiting.remove(found)
        own = [found] if found is not None else []
        yield _line(number, line, own, () if row else ways, row)


def _line(number: int, text: str, items: Sequence[Item], ways: Sequence[Item], row: int = 0) -> str:
    """Return a row of the table; links go to row 0 of a line."""
    style = _style([*items, *ways])
    hits = str(min(item.hits for item in items)) if items else ""
    chips = "".join(_chip(way) for way in ways)
    name = f"L{number}.{row}" if row else f"L{number}"
    return (
        f'<tr id="{name}" class="{style}"><td class="no">{number}</td>'
        f'<td class="hits">{hits}</td><td class="marks">{chips}</td>'
        f'<td class="text">{escape(text)}</td></tr>'
    )


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
    title = escape(title.removesuffix(". "))
    about = f'role="img" title="{title}" aria-label="{title}"'
    return f'<span class="chip {style}" {about}>{mark}</span>'


def _decision(decision: DecisionResult, network: str) -> Iterator[str]:
    complete = all(one.judged.masking for one in decision.conditions)
    excused = all(one.judged.masking or one.reason for one in decision.conditions)
    style, mark = ("yes", "✓") if complete else ("soft", "·") if excused else ("no-mark", "✗")
    opened = "" if complete else " open"
    yield f'<details{opened}><summary><span class="{style}">{mark}</span>'
    text = f"{network}: {decision.text}" if network else decision.text
    yield f'<a href="#L{decision.line}">{decision.line}</a> {escape(text)}</summary>'
    yield "<div class='wide'><table><tr><th></th><th>Condition</th><th>TRUE</th><th>FALSE</th>"
    yield "<th>MC/DC</th><th>Unique-cause</th><th></th></tr>"
    for letter, one in zip(_letters(), decision.conditions, strict=False):
        yield f"<tr><td>{letter}</td>{_condition(one)}</tr>"
    yield "</table>"
    if len(decision.conditions) > 1:
        yield from _vectors(decision)
    yield "</div></details>"


def _letters() -> Iterator[str]:
    for number in range(1000):
        yield chr(65 + number) if number < 26 else f"A{number - 26}"


def _condition(one: Condition) -> str:
    judged = one.judged
    holds = (True in judged.values, False in judged.values, judged.masking, judged.unique)
    cells = "".join(
        f'<td class="{"yes" if yes else "no-mark"}">{"yes" if yes else "no"}</td>' for yes in holds
    )
    return f"<td>{escape(one.text)}</td>{cells}<td class='soft'>{escape(one.reason)}</td>"


def _vectors(decision: DecisionResult) -> Iterator[str]:
    letters = [letter for letter, _ in zip(_letters(), decision.conditions, strict=False)]
    yield f"<table><tr>{''.join(f'<th>{letter}</th>' for letter in letters)}<th>outcome</th></tr>"
    for vector, outcome in list(decision.vectors.items())[:_MOST_VECTORS]:
        skipped = vector >> len(letters)
        bits = ["-" if skipped >> k & 1 else vector >> k & 1 for k in range(len(letters))]
        cells = "".join(f"<td>{bit}</td>" for bit in bits)
        yield f"<tr>{cells}<td>{int(outcome)}</td></tr>"
    yield "</table>"
    if len(decision.vectors) > _MOST_VECTORS:
        yield f"<p class='note'>and {len(decision.vectors) - _MOST_VECTORS} more</p>"
