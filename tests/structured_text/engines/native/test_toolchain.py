"""C code is compiled to a shared object, also on systems without signals for faults."""

from __future__ import annotations

import ctypes
from pathlib import Path

import pytest

from structured_text.engines.native.toolchain import compile_shared, find_c_compiler

_UNIT = """#include "faults.h"
static const char *scan(void) { return "scanned"; }
const char *rcx_try(void) { return shim_guarded(scan); }
"""


@pytest.mark.parametrize("options", [(), ("-D_WIN32", "-Werror=implicit-function-declaration")])
def test_a_scan_is_guarded_with_and_without_signals(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    compiler = find_c_compiler()
    if compiler is None:
        pytest.skip("no C compiler: set CC or PATH")
    unit = tmp_path / "unit.c"
    unit.write_text(_UNIT, encoding="utf-8")
    compile_shared(compiler, options, unit)
    (made,) = (file for file in tmp_path.iterdir() if file != unit)
    library = ctypes.CDLL(str(made))
    library.rcx_try.restype = ctypes.c_char_p
    assert library.rcx_try() == b"scanned"
    symbols = b"sigaction" in made.read_bytes()
    assert symbols is (not options)
