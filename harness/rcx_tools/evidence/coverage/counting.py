"""Plugin of pytest for `make coverage`. It counts how often code of the library is executed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from structured_text.coverage.parts import Part
from structured_text.engines.builtin.collector import Collector
from structured_text.testing.coverage import Gathering

__all__ = ["pytest_addoption", "pytest_configure"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options for the sources to count and for the output file."""
    parser.addoption("--count-below", type=Path, help="folder of the measured sources")
    parser.addoption("--counts", type=Path, help="file for the counts")


def pytest_configure(config: pytest.Config) -> None:
    """Start counting."""
    _Library(config, Collector(config.getoption("count_below")))


class _Library(Gathering):
    def report(self, session: pytest.Session, parts: list[Part], lost: list[str]) -> None:
        """Write the counts.

        The counts of a worker that has died are missing. Its tests are reported as failed.
        """
        session.config.getoption("counts").write_text(json.dumps(parts), encoding="utf-8")
