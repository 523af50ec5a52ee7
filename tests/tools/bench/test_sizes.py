"""`make bench` reports the size of each block in bytes per instance."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness.cell.sources import default_lib
from rcx_tools.bench import sizes
from rcx_tools.bench.figure import Options
from structured_text.engines.matiec.build import MISSING, find_matiec
from structured_text.engines.native.toolchain import find_c_compiler, find_cxx_compiler
from structured_text.engines.strucpp.build import MISSING_STRUCPP, find_strucpp

_PAGE = Path(__file__).resolve().parents[3] / "docs/explanation/timing.md"
#: Folders of the library whose blocks contain other blocks.
_BUILT = ("motion", "operator", "points", "position")


def _printed() -> dict[str, int]:
    """Return a dictionary of names to bytes from the page's table of composite blocks."""
    page = _PAGE.read_text(encoding="utf-8")
    lines = page.split("| Block | Bytes | Block | Bytes |")[1].split("\n\n")[0].splitlines()
    cells = [cell for line in lines[2:] for cell in line.strip("|").split("|")]
    found: dict[str, int] = {}
    for block, taken in zip(cells[::2], cells[1::2], strict=True):
        names = re.findall(r"`(\w+)`", block)
        numbers = [int(number.replace(",", "")) for number in re.findall(r"\d[\d,]*\d", taken)]
        found.update(zip(names, numbers * len(names), strict=False))
    return found


def test_without_matiec_the_figures_are_said_to_be_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "find_matiec", lambda: None)
    measured = sizes.measure(Options())
    assert measured
    for figure in measured.values():
        assert (figure.value, figure.peer, figure.met) == (None, MISSING, False)


@pytest.fixture(scope="module")
def measured() -> list[sizes.Size]:
    """Return the sizes, which are measured once for this file."""
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        pytest.skip(MISSING)
    return sizes.sizes(matiec, compiler)


def test_rcx_ref_and_the_command_blocks_keep_to_their_sizes(measured: list[sizes.Size]) -> None:
    """RCX_REF and the command blocks keep their sizes. No block has two texts of 128 bytes."""
    limits = {size.name: size.limit for size in measured if size.limit}
    assert (limits["RCX_REF"], limits["FB_ReadProgramInfo"]) == (160, 500)
    assert [size.name for size in measured if size.limit and size.bytes > size.limit] == []


def test_the_page_names_every_block_that_contains_other_blocks() -> None:
    """Source: docs/explanation/timing.md, cost on the PLC."""
    blocks = {file.stem for folder in _BUILT for file in (default_lib() / folder).glob("FB_*.st")}
    assert blocks - _printed().keys() == set()


def test_the_page_prints_the_measured_sizes(measured: list[sizes.Size]) -> None:
    """Source: docs/explanation/timing.md, cost on the PLC."""
    found = {size.name: size.bytes for size in measured}
    printed = _printed()
    assert printed == {name: found[name] for name in printed}
    commands = [size.bytes for size in measured if size.folder == "command"]
    page = _PAGE.read_text(encoding="utf-8")
    assert f"| a command block | {min(commands)} to {max(commands)} bytes |" in page
    assert f"| `RCX_REF` | {found['RCX_REF']} bytes |" in page


@pytest.mark.skipif(find_strucpp() is None, reason=MISSING_STRUCPP)
def test_strucpp_reports_the_size_of_every_block_with_more_data_for_each_value() -> None:
    """STruC++ reports the size of every block, which is larger than on other engines.

    It stores a forced flag and a forced value for each value, so a BOOL takes three bytes.
    """
    strucpp, compiler = find_strucpp(), find_cxx_compiler()
    assert strucpp is not None
    assert compiler is not None
    found = {size.name: size.bytes for size in sizes.strucpp_sizes(strucpp, compiler)}
    assert {"RCX_REF", "FB_ReadArea", "FB_MovePtp", "FB_Operator"} <= set(found)
    assert found["RCX_REF"] > sizes.LARGEST_REF
