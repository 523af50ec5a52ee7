"""Bytes that a robot and a block take on a PLC: matiec's C, laid out by the C compiler.

No figure is assumed: iec2c translates the whole library, and a C program that includes its headers
prints `sizeof` of every block.
"""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from rcx_harness.cell.build import default_lib
from rcx_harness.engine.frontend import load
from rcx_harness.engine.load import MISSING, Matiec, find_c_compiler, find_matiec
from rcx_harness.engine.matiec.source import join_sources
from rcx_harness.errors import InputError
from rcx_tools.bench.figure import Figure, Options, at_most, missing

__all__ = ["LARGEST_COMMAND", "LARGEST_REF", "Size", "measure", "sizes", "table"]

#: Targets [byte].
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
    """One type: where it lies in the library, and what an instance takes.

    Attributes:
        name: Of the block or structure.
        folder: `area`, `command`, `sequence`, `types` and so on.
        bytes: Per instance.
    """

    name: str
    folder: str
    bytes: int

    @property
    def limit(self) -> int | None:
        """The target, where there is one."""
        if self.name == "RCX_REF":
            return LARGEST_REF
        return LARGEST_COMMAND if self.folder == "command" else None


def sizes(matiec: Matiec, compiler: str) -> list[Size]:
    """What every block of the library and RCX_REF take, by folder and name.

    Raises:
        InputError: the library has an error, or the C compiler fails.
        TranslationError: iec2c refuses the library.
    """
    home = default_lib()
    library = sorted(home.rglob("*.st"))
    blocks = [path for path in library if path.stem.startswith("FB_")]
    with tempfile.TemporaryDirectory(prefix="rcx-") as name:
        folder = Path(name)
        source, target = folder / "all.st", folder / "c"
        target.mkdir()
        main = folder / "main.st"
        main.write_text(_MAIN, encoding="utf-8")
        text = join_sources(load([main, *library])).text
        source.write_text(text, encoding="utf-8")
        matiec.translate(source, target)
        names = ["RCX_REF", *(path.stem for path in blocks)]
        rows = [f'  printf("%zu\\n", sizeof({one.upper()}));' for one in names]
        printing = target / "rcx_sizes.c"
        printing.write_text(_PRINT % "\n".join(rows), encoding="utf-8")
        program = folder / "sizes"
        command = [compiler, "-w", "-I", str(matiec.headers), str(printing), "-lm", "-o"]
        done = subprocess.run([*command, str(program)], capture_output=True, text=True, check=False)
        if done.returncode:
            raise InputError(f"{compiler} refuses matiec's C: {done.stderr.strip()[:200]}")
        printed = subprocess.run([str(program)], capture_output=True, text=True, check=True)
    found = dict(zip(names, map(int, printed.stdout.split()), strict=True))
    every = [Size("RCX_REF", "types", found["RCX_REF"])]
    every += [Size(path.stem, path.relative_to(home).parts[0], found[path.stem]) for path in blocks]
    return sorted(every, key=lambda size: (size.folder, size.name))


def measure(options: Options) -> dict[str, Figure]:
    """The sizes that have a target; all of them are printed.

    Args:
        options: Nothing of it matters here.
    """
    del options
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        why = MISSING if matiec is None else "no C compiler found"
        return {
            "size RCX_REF": missing("byte", f"<= {LARGEST_REF}", why),
            "size largest command block": missing("byte", f"<= {LARGEST_COMMAND}", why),
        }
    every = sizes(matiec, compiler)
    Console().print(table(every))
    commands = [size for size in every if size.folder == "command"]
    large = max(commands, key=lambda size: size.bytes)
    ref = next(size for size in every if size.name == "RCX_REF")
    return {
        "size RCX_REF": at_most(ref.bytes, "byte", LARGEST_REF),
        "size largest command block": at_most(large.bytes, "byte", LARGEST_COMMAND, large.name),
    }


def table(every: list[Size]) -> Table:
    """All sizes, for people."""
    drawn = Table(title="Bytes per instance on matiec")
    for heading in ("folder", "block", "bytes", "target"):
        drawn.add_column(heading, justify="right" if heading in ("bytes", "target") else "left")
    for size in every:
        limit = "" if size.limit is None else f"<= {size.limit}"
        drawn.add_row(size.folder, size.name, str(size.bytes), limit)
    return drawn
