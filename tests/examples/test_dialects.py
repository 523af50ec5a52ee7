"""The library behaves in the same way in each dialect, so the examples give the same trace."""

from __future__ import annotations

import pytest

from example_runs import EXAMPLES
from rcx_tools.docs.examples import Example
from structured_text.language.dialects import dialects, using


def _records(example: Example, dialect: str) -> list[str]:
    with using(dialect), example.build("builtin") as cell:
        assert cell.program.project.dialect == dialect  # type: ignore[attr-defined]
        cell.run(example.duration)
        return list(cell.trace.lines())


@pytest.mark.exhaustive
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_an_example_gives_the_same_trace_in_each_dialect(example: Example) -> None:
    """The trace of an example is the same in each dialect. Source: docs/reference/language.md."""
    usual = _records(example, "iec")
    for dialect in dialects():
        if dialect not in ("iec", "openplc"):
            assert _records(example, dialect) == usual, dialect
