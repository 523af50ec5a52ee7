"""What `make bench` says of the blocks: bytes per instance and, on matiec, cost per scan."""

from __future__ import annotations

import pytest

from rcx_harness.engine.load import (
    MISSING,
    find_c_compiler,
    find_cxx_compiler,
    find_matiec,
    find_strucpp,
)
from rcx_harness.engine.strucpp.build import MISSING_STRUCPP
from rcx_tools.bench import cost, sizes
from rcx_tools.bench.figure import Options

_HERE = find_matiec() is not None and find_c_compiler() is not None


@pytest.mark.parametrize("module", [sizes, cost])
def test_without_matiec_the_figures_are_said_to_be_missing(
    monkeypatch: pytest.MonkeyPatch, module: object
) -> None:
    monkeypatch.setattr(module, "find_matiec", lambda: None)
    measured = module.measure(Options())  # type: ignore[attr-defined]
    assert measured
    for figure in measured.values():
        assert (figure.value, figure.peer, figure.met) == (None, MISSING, False)


@pytest.mark.skipif(not _HERE, reason=MISSING)
def test_rcx_ref_and_the_command_blocks_keep_to_their_sizes() -> None:
    """A text alone takes 128 bytes; therefore no block has more than one."""
    matiec, compiler = find_matiec(), find_c_compiler()
    assert matiec is not None
    assert compiler is not None
    every = sizes.sizes(matiec, compiler)
    limits = {size.name: size.limit for size in every if size.limit}
    assert (limits["RCX_REF"], limits["FB_ReadProgramInfo"]) == (160, 500)
    assert [size.name for size in every if size.limit and size.bytes > size.limit] == []


@pytest.mark.skipif(find_strucpp() is None, reason=MISSING_STRUCPP)
def test_strucpp_tells_the_size_of_every_block_and_keeps_more_of_each_value() -> None:
    """Beside each value it keeps whether it is forced, and to what: a BOOL takes three bytes."""
    strucpp, compiler = find_strucpp(), find_cxx_compiler()
    assert strucpp is not None
    assert compiler is not None
    found = {size.name: size.bytes for size in sizes.strucpp_sizes(strucpp, compiler)}
    assert {"RCX_REF", "FB_ReadArea", "FB_MovePtp", "FB_Operator"} <= set(found)
    assert found["RCX_REF"] > sizes.LARGEST_REF
