"""docs/how-to/cluster.md uses only options that the help of dask contains."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture
def page(repository: Path) -> str:
    """Return the text of the page."""
    return (repository / "docs/how-to/cluster.md").read_text(encoding="utf-8")


@pytest.mark.exhaustive
@pytest.mark.parametrize("which", ["scheduler", "worker"])
def test_what_is_told_of_dask_is_in_its_help(page: str, which: str) -> None:
    pytest.importorskip("distributed", reason="needs the extra cluster")
    command = [sys.executable, "-m", f"distributed.cli.dask_{which}", "--help"]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = re.findall(rf"dask {which} [^`\n]*", page)
    options = {option for line in lines for option in re.findall(r"--[a-z-]+", line)}
    assert len(options) >= 3
    assert {one for one in options if f"{one} " not in told} == set()
