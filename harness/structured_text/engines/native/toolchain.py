"""Compilation of C or C++ text to a shared object: the compilers, and the cache of results."""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import subprocess
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from subprocess import CompletedProcess

from structured_text.errors import InputError
from structured_text.language import cache
from structured_text.output import programs
from structured_text.output.limits import MOST_TOOL_S
from structured_text.output.system import DLL, WHOLE

__all__ = [
    "CompilerError",
    "compile_shared",
    "find_c_compiler",
    "find_cxx_compiler",
    "fingerprint",
    "from_cache",
    "run_tool",
    "version",
]

_HERE = Path(__file__).parent
_FLAGS = ("-O1", "-w", "-fPIC", "-shared", *WHOLE)
# Signed overflow wraps and floats are not contracted, at any level of optimization.
_ARITHMETIC = ("-fwrapv", "-fno-strict-aliasing", "-ffp-contract=off")
# With RCX_SANITIZE=on, undefined behaviour and accesses out of bounds end the process. The process
# must have been started with the library of the address sanitizer preloaded.
_SANITIZERS = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


class CompilerError(Exception):
    """The error for a C or C++ compiler that produced no shared object."""

    def __init__(self, output: str) -> None:
        self.output = output
        lines = output.splitlines()
        self.reason = next((line for line in lines if "error" in line), "no message")
        super().__init__(self.reason)


def find_c_compiler() -> str | None:
    """Return the C compiler: `CC`, then cc, gcc or clang on `PATH`; None if there is none."""
    return _first(os.environ.get("CC"), "cc", "gcc", "clang")


def find_cxx_compiler() -> str | None:
    """Return the C++ compiler: `CXX`, then c++, g++ or clang++ on `PATH`; None if there is none."""
    return _first(os.environ.get("CXX"), "c++", "g++", "clang++")


def _first(*names: str | None) -> str | None:
    return next((path for name in names if name and (path := shutil.which(name))), None)


def from_cache(compiler: str, parts: Sequence[str], make: Callable[[], bytes]) -> bytes:
    """Return a shared object from the cache, or the result of `make`, which is then cached.

    The key of the cache is a hash of `parts`, the compiler's version, the flags and the files of
    this folder. `parts` must contain every other input of `make`.
    """
    folder = cache.folder()
    if folder is None:
        return make()
    own = fingerprint(_HERE.iterdir())
    every = "\0".join([*parts, version(compiler), *_flags(), own])
    entry = folder / f"{hashlib.sha256(every.encode()).hexdigest()}.so"
    with suppress(OSError, ValueError):
        return cache.content(entry)
    image = make()
    with suppress(OSError):
        cache.put(entry, image)
    return image


def compile_shared(compiler: str, options: Sequence[str], unit: Path) -> bytes:
    """Compile one file; the shared object is also left in the file's folder.

    Raise CompilerError if the compiler reports an error. The file may include `faults.h`. `options`
    are the version of the language and the folders of the headers.

    Returns:
        The contents of the shared object.
    """
    shared = unit.with_suffix(DLL)
    command = [compiler, *_flags(), *options, "-I", str(_HERE), str(unit), "-lm", "-o", str(shared)]
    done = run_tool(command)
    if done.returncode != 0:
        raise CompilerError(done.stderr.decode("utf-8", "replace"))
    return shared.read_bytes()


def run_tool(command: Sequence[str], folder: Path | None = None) -> CompletedProcess[bytes]:
    """Run a compiler and capture its output.

    Raise InputError if it does not end within `MOST_TOOL_S`.
    """
    try:
        return programs.run(command, cwd=folder, timeout=MOST_TOOL_S)
    except subprocess.TimeoutExpired:
        raise InputError(
            f"{Path(command[0]).name} has not compiled this program within {MOST_TOOL_S} s",
            hint="make the program smaller, or use --engine builtin",
        ) from None


def fingerprint(files: Iterable[Path]) -> str:
    """Return a hash of some files with their names, as part of a cache key."""
    digest = hashlib.sha256()
    for path in sorted(file for file in files if file.is_file()):
        digest.update(f"\0{path.name}\0".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _flags() -> tuple[str, ...]:
    wanted = os.environ.get("RCX_SANITIZE", "").lower() == "on"
    return _FLAGS + _ARITHMETIC + (_SANITIZERS if wanted else ())


@functools.lru_cache(maxsize=8)
def version(compiler: str) -> str:
    """Return the path of a compiler and its output for `--version`, as part of a cache key."""
    done = programs.run([compiler, "--version"])
    said: bytes = done.stdout
    return compiler + said.decode("utf-8", "replace")
