"""Memory size of a robot and of each block on a PLC, with each available compiler.

The sizes are not estimated. matiec or STruC++ translates the whole library, the C or C++ compiler
compiles the result, and `sizeof` gives the size of every block.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from rcx_harness.cell.sources import default_lib
from rcx_tools.bench.figure import Figure, Options, at_most, missing
from structured_text.engines.matiec.build import MISSING, Matiec, find_matiec
from structured_text.engines.matiec.source import join_sources
from structured_text.engines.native.toolchain import find_c_compiler, find_cxx_compiler
from structured_text.engines.strucpp.build import NAMESPACE, Strucpp, compile_project, find_strucpp
from structured_text.errors import InputError
from structured_text.language.load import load

__all__ = ["LARGEST_COMMAND", "LARGEST_REF", "Size", "measure", "sizes", "strucpp_sizes", "table"]

#: Greatest permitted sizes [byte].
LARGEST_REF, LARGEST_COMMAND = 160, 500

_MAIN = """
PROGRAM RcxSizes
  VAR
    Robot : RCX_REF;
  END_VAR
  Robot.Connected := TRUE;
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : RcxSizes;
  END_RESOURCE
END_CONFIGURATION
"""
_PRINT = """
#include <stdio.h>
#include "iec_std_lib.h"
#include "accessor.h"
#include "POUS.h"
TIME __CURRENT_TIME;
BOOL __DEBUG;
int main(void) {
%s
  return 0;
}
"""


@dataclass(frozen=True)
class Size:
    """The size of an instance of a type, with the type's folder in the library.

    Attributes:
        name: Name of the block or structure.
        folder: Folder in the library: `area`, `command`, `sequence`, `types` and so on.
        bytes: Size of an instance [byte].
    """

    name: str
    folder: str
    bytes: int

    @property
    def limit(self) -> int | None:
        """Return the greatest permitted size [byte], or None if the type has no target."""
        if self.name == "RCX_REF":
            return LARGEST_REF
        return LARGEST_COMMAND if self.folder == "command" else None


def sizes(matiec: Matiec, compiler: str) -> list[Size]:
    """Return the sizes of all blocks and of RCX_REF on matiec, by folder and name.

    Raises:
        InputError: the library has an error, or the C compiler fails.
        TranslationError: iec2c refuses the library.
    """
    places = _places()
    with tempfile.TemporaryDirectory(prefix="rcx-") as name:
        folder = Path(name)
        source, target = folder / "all.st", folder / "c"
        target.mkdir()
        text = join_sources(load(_sources(folder))).text
        source.write_text(text, encoding="utf-8")
        matiec.translate(source, target)
        rows = [f'  printf("%zu\\n", sizeof({one.upper()}));' for one in places]
        printing = target / "rcx_sizes.c"
        printing.write_text(_PRINT % "\n".join(rows), encoding="utf-8")
        program = folder / "sizes"
        command = [compiler, "-w", "-I", str(matiec.headers), str(printing), "-lm", "-o"]
        done = subprocess.run([*command, str(program)], capture_output=True, text=True, check=False)
        if done.returncode:
            raise InputError(f"{compiler} refuses matiec's C: {done.stderr.strip()[:200]}")
        printed = subprocess.run([str(program)], capture_output=True, text=True, check=True)
    return _sorted(places, map(int, printed.stdout.split()))


def strucpp_sizes(strucpp: Strucpp, compiler: str) -> list[Size]:
    """Return the sizes of all blocks and of RCX_REF on STruC++, like `sizes`.

    Raises:
        InputError: the library has an error, or one of the compilers refuses it.
    """
    places = _places()
    wanted = [f"sizeof({NAMESPACE}::{one.upper()})" for one in places]
    with tempfile.TemporaryDirectory(prefix="rcx-") as name:
        folder = Path(name)
        project = load(_sources(folder))
        shared = folder / "sizes.so"
        shared.write_bytes(compile_project(project, wanted, strucpp, compiler))
        found = (ctypes.c_size_t * len(wanted)).in_dll(ctypes.CDLL(str(shared)), "shim_layout")
        return _sorted(places, found)


def _sources(folder: Path) -> list[Path]:
    """Write a minimal program into the folder. Return its path and the files of the library."""
    main = folder / "main.st"
    main.write_text(_MAIN, encoding="utf-8")
    return [main, *sorted(default_lib().rglob("*.st"))]


def _places() -> dict[str, str]:
    """Return the folder of RCX_REF and of each block, by name."""
    home = default_lib()
    blocks = sorted(home.rglob("FB_*.st"))
    return {"RCX_REF": "types"} | {one.stem: one.relative_to(home).parts[0] for one in blocks}


def _sorted(places: Mapping[str, str], found: Iterable[int]) -> list[Size]:
    every = [Size(name, places[name], size) for name, size in zip(places, found, strict=True)]
    return sorted(every, key=lambda size: (size.folder, size.name))


def measure(options: Options) -> dict[str, Figure]:
    """Return the sizes that have a target, and print all of them."""
    del options
    strucpp, beside = find_strucpp(), find_cxx_compiler()
    other = strucpp_sizes(strucpp, beside) if strucpp and beside else []
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        why = MISSING if matiec is None else "no C compiler found"
        return {
            "size RCX_REF": missing("byte", f"<= {LARGEST_REF}", why),
            "size largest command block": missing("byte", f"<= {LARGEST_COMMAND}", why),
        }
    every = sizes(matiec, compiler)
    Console().print(table(every, other))
    commands = [size for size in every if size.folder == "command"]
    large = max(commands, key=lambda size: size.bytes)
    ref = next(size for size in every if size.name == "RCX_REF")
    return {
        "size RCX_REF": at_most(ref.bytes, "byte", LARGEST_REF),
        "size largest command block": at_most(large.bytes, "byte", LARGEST_COMMAND, large.name),
    }


def table(every: Sequence[Size], other: Sequence[Size] = ()) -> Table:
    """Return a table of all sizes, for people.

    Args:
        every: Sizes on matiec.
        other: Sizes on STruC++; empty if STruC++ is not available.
    """
    drawn = Table(title="Bytes per instance")
    for heading in ("folder", "block", "matiec", "target", "STruC++"):
        drawn.add_column(heading, justify="left" if heading in ("folder", "block") else "right")
    beside = {size.name: str(size.bytes) for size in other}
    for size in every:
        limit = "" if size.limit is None else f"<= {size.limit}"
        drawn.add_row(size.folder, size.name, str(size.bytes), limit, beside.get(size.name, ""))
    return drawn
