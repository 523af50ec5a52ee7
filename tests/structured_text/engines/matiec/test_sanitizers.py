"""The library's C code from matiec passes AddressSanitizer and UBSan."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from structured_text.engines.matiec.build import Matiec
from structured_text.engines.native.toolchain import find_c_compiler

_SUPPORT = Path(__file__).parents[3] / "support"

BEYOND = """
PROGRAM Main
  VAR
    Area : ARRAY [0..3] OF INT;
    k    : INT := 30000;
  END_VAR
  Area[k] := 1;
END_PROGRAM
"""


def _run(*arguments: str) -> subprocess.CompletedProcess[str]:
    compiler = find_c_compiler()
    assert compiler is not None
    command = [compiler, "-print-file-name=libasan.so"]
    library = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    if not Path(library).is_absolute():
        pytest.skip("the C compiler has no address sanitizer to preload (libasan.so)")
    wanted = {"LD_PRELOAD": library, "ASAN_OPTIONS": "detect_leaks=0", "RCX_SANITIZE": "on"}
    return subprocess.run(
        [sys.executable, str(_SUPPORT / "sanitized_run.py"), *arguments],
        env=os.environ | wanted,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_library_leaves_nothing_undefined_and_never_leaves_its_arrays(matiec: Matiec) -> None:
    """The library runs 5,000 scans without a report of the sanitizers.

    Areas, Execute pins, offsets and sizes are random, and some are illegal.
    """
    done = _run()
    assert done.returncode == 0, done.stderr
    assert done.stdout == "no finding\n"


def test_an_access_beyond_an_array_is_found(matiec: Matiec, tmp_path: Path) -> None:
    source = tmp_path / "main.st"
    source.write_text(BEYOND, encoding="utf-8")
    done = _run(str(source))
    assert done.returncode != 0
    assert "Sanitizer" in done.stderr or "runtime error" in done.stderr
