"""The results as an lcov tracefile, which `genhtml` and editors read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from rcx_harness.verify.coverage.measure import FileResult, Item

__all__ = ["tracefile"]


def tracefile(results: Sequence[FileResult], library: Path) -> str:
    """The tracefile; what is justified in place is left out of it.

    Args:
        results: All files.
        library: Their folder.
    """
    lines = []
    for result in results:
        lines += ["TN:", f"SF:{library / result.path}", *_records(result), "end_of_record"]
    return "\n".join(lines) + "\n"


def _records(result: FileResult) -> Iterator[str]:
    for name, line, _ in result.pous:
        yield f"FN:{line},{name}"
    for name, _, calls in result.pous:
        yield f"FNDA:{calls},{name}"
    yield f"FNF:{len(result.pous)}"
    yield f"FNH:{sum(1 for _, _, calls in result.pous if calls)}"
    branches = list(map(_counting, result.branches))
    reached = {item.fork for item in result.branches if item.hits}
    for number, item in enumerate(result.branches):
        if branches[number]:
            taken = str(item.hits) if item.fork in reached else "-"
            yield f"BRDA:{item.line},{item.fork},{number},{taken}"
    yield f"BRF:{sum(branches)}"
    yield f"BRH:{sum(1 for item in result.branches if item.hits)}"
    lines: dict[int, int] = {}
    for item in filter(_counting, result.statements):
        lines[item.line] = min(item.hits, lines.get(item.line, item.hits))
    for line, hits in sorted(lines.items()):
        yield f"DA:{line},{hits}"
    yield f"LF:{len(lines)}"
    yield f"LH:{sum(1 for hits in lines.values() if hits)}"


def _counting(item: Item) -> bool:
    return bool(item.hits) or not item.reason
