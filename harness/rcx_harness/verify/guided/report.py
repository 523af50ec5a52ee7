"""What a guided campaign has never exercised."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.verify.guided.novelty import Met
from rcx_harness.verify.storm.cells import Cells
from rcx_harness.verify.storm.moments import own_variables
from structured_text.language.types import EnumType

__all__ = ["never_exercised"]


def never_exercised(cells: Cells, seed: int, met: Collection[Met]) -> Iterator[str]:
    """Yield a line for each of the user's states: the values and faults that were never met.

    A value that was never met is not listed again with the faults.
    """
    with cells.cell(seed, keep=0) as cell:
        program = cell.program
        own = list(own_variables(program, cells.library))
        kinds = {path: program.type_of(path) for path in own}
    for path, kind in kinds.items():
        if not isinstance(kind, EnumType):
            continue
        reached = {value for where, value, fault in met if where == path and not fault}
        values = [name for name in kind.members if name in reached]
        if missing := [name for name in kind.members if name not in reached]:
            yield f"{path} was never {' or '.join(missing)}"
        for fault in cells.demands.faults:
            without = [name for name in values if (path, name, fault) not in met]
            if without:
                yield f"{fault} never occurred while {path} was {' or '.join(without)}"
