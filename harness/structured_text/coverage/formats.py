"""The results for other tools: lcov tracefile and Cobertura XML."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

from structured_text.coverage.measure import DecisionResult, FileResult, Item, Share
from structured_text.coverage.report import totals
from structured_text.errors import COMMAND, DISTRIBUTION
from structured_text.output.paths import real

__all__ = ["cobertura", "tracefile"]


def _counting(items: Sequence[Item]) -> list[Item]:
    return [item for item in items if item.hits or not item.reason]


def _lines(result: FileResult) -> dict[int, int]:
    """Return how often each line was executed: the lowest count of its statements."""
    lines: dict[int, int] = {}
    for item in _counting(result.statements):
        lines[item.line] = min(item.hits, lines.get(item.line, item.hits))
    return dict(sorted(lines.items()))


def tracefile(
    results: Sequence[FileResult], folder: Path | None = None, *, mcdc: bool = False
) -> str:
    """Return the tracefile of lcov, without items that are justified in the source.

    Programs that read the file expect lines with statements. Therefore a block has the line of its
    first statement, and a branch has the line of its IF, CASE or loop. With a `folder` paths are
    absolute. With `mcdc` the tracefile includes conditions, which only lcov 2.2 and later can read.
    """
    lines = []
    for result in results:
        path = str(folder / result.path) if folder else result.path
        lines += [
            f"TN:{COMMAND}_coverage",
            f"SF:{path}",
            *_records(result, mcdc=mcdc),
            "end_of_record",
        ]
    return "\n".join(lines) + "\n"


def _records(result: FileResult, *, mcdc: bool) -> Iterator[str]:
    lines = _lines(result)
    for (name, _, _), body in zip(result.pous, result.bodies, strict=True):
        yield f"FN:{body[0]},{name}"
    for name, _, calls in result.pous:
        yield f"FNDA:{calls},{name}"
    yield f"FNF:{len(result.pous)}"
    yield f"FNH:{sum(1 for _, _, calls in result.pous if calls)}"
    branches = _counting(result.branches)
    reached = {item.fork for item in result.branches if item.hits}
    for number, item in enumerate(branches):
        taken = str(item.hits) if item.fork in reached else "-"
        yield f"BRDA:{item.at},{item.fork},{number},{taken}"
    yield f"BRF:{len(branches)}"
    yield f"BRH:{sum(1 for item in branches if item.hits)}"
    if mcdc:
        yield from _conditions(result)
    for line, hits in lines.items():
        yield f"DA:{line},{hits}"
    yield f"LF:{len(lines)}"
    yield f"LH:{sum(1 for hits in lines.values() if hits)}"


def _conditions(result: FileResult) -> Iterator[str]:
    """Yield the MC/DC records.

    The conditions of a line form a group, and each condition has a record for TRUE and for FALSE.
    """
    lines: dict[int, list[DecisionResult]] = {}
    for decision in result.decisions:
        lines.setdefault(decision.at, []).append(decision)
    found = hit = 0
    for line, decisions in sorted(lines.items()):
        every = [(one, of) for of in decisions for one in of.conditions if not one.reason]
        for index, (one, of) in enumerate(every):
            shown = one.text if len(of.conditions) == 1 else f"{one.text} in {of.text}"
            for sense in (False, True):
                taken = int(sense in one.judged.deciding)
                found, hit = found + 1, hit + taken
                yield f"MCDC:{line},{len(every)},{'ft'[sense]},{taken},{index},{shown}"
    if found:
        yield f"MCF:{found}"
        yield f"MCH:{hit}"


def cobertura(results: Sequence[FileResult], home: Path) -> bytes:
    """Return the results as XML of Cobertura; its DTD (coverage-04) does not provide for MC/DC."""
    lines, branches = _shares(results)
    root = ET.Element("coverage", _rates(results))
    for name, share in (("lines", lines), ("branches", branches)):
        root.attrib |= {f"{name}-covered": str(share.covered), f"{name}-valid": str(share.total)}
    # A constant instead of the current time, so that the same results give the same file.
    root.attrib |= {"complexity": "0", "version": DISTRIBUTION, "timestamp": "0"}
    ET.SubElement(ET.SubElement(root, "sources"), "source").text = str(real(home))
    packages = ET.SubElement(root, "packages")
    folders: dict[str, list[FileResult]] = {}
    for result in results:
        folders.setdefault(result.path.rpartition("/")[0], []).append(result)
    for folder, files in sorted(folders.items()):
        rates = {"name": folder.replace("/", ".") or ".", **_rates(files), "complexity": "0"}
        classes = ET.SubElement(ET.SubElement(packages, "package", rates), "classes")
        for result in files:
            _class(ET.SubElement(classes, "class"), result)
    ET.indent(root)
    head = f'<?xml version="1.0" ?>\n<!-- {COMMAND} coverage -->\n<!DOCTYPE coverage SYSTEM '
    dtd = "http://cobertura.sourceforge.net/xml/coverage-04.dtd"
    return f'{head}"{dtd}">\n{ET.tostring(root, encoding="unicode")}\n'.encode(
        "utf-8", "backslashreplace"
    )


def _shares(results: Sequence[FileResult]) -> tuple[Share, Share]:
    """Return the shares of executed lines and branches."""
    lines = [hits for result in results for hits in _lines(result).values()]
    return Share(sum(map(bool, lines)), len(lines)), totals(results)["branches"]


def _rates(results: Sequence[FileResult]) -> dict[str, str]:
    lines, branches = _shares(results)
    return {
        "line-rate": f"{lines.percent / 100:.4g}",
        "branch-rate": f"{branches.percent / 100:.4g}",
    }


def _class(node: ET.Element, result: FileResult) -> None:
    name = result.path.rpartition("/")[2].partition(".")[0]
    node.attrib |= {"name": name, "filename": result.path, **_rates([result]), "complexity": "0"}
    ET.SubElement(node, "methods")
    lines = ET.SubElement(node, "lines")
    forks: dict[int, list[Item]] = {}
    for item in _counting(result.branches):
        forks.setdefault(item.at, []).append(item)
    for number, hits in _lines(result).items():
        line = ET.SubElement(lines, "line", number=str(number), hits=str(hits))
        ways = forks.get(number)
        if ways:
            taken = sum(bool(way.hits) for way in ways)
            shown = f"{100 * taken // len(ways)}% ({taken}/{len(ways)})"
            line.attrib |= {"branch": "true", "condition-coverage": shown}
