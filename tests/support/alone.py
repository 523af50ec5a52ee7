"""A bench for a single block of the library: the test sets the fields of the robot."""

from __future__ import annotations

from collections.abc import Mapping

from plc_bench import compiled
from structured_text.engines.base import Value


class Alone:
    """A program that calls one block of the library, its instance `Block`, once in each scan.

    The program increments the block's scan number. For FB_RcxJob, `Placed` says whether the job is
    called inside of a scan.

    Args:
        block: The block's type.
        in_outs: The type of each of its VAR_IN_OUT variables, which the program declares under
            the same name.
        engine: The engine that runs the program.
    """

    def __init__(self, block: str, in_outs: Mapping[str, str], engine: str = "auto") -> None:
        declared = "".join(f"    {name} : {kind};\n" for name, kind in in_outs.items())
        given = ", ".join(f"{name} := {name}" for name in in_outs)
        counted = ""
        if block == "FB_RcxJob":
            declared += "    Placed : BOOL := TRUE;\n"
            counted = "  Block.Scan := Block.Scan + UINT#1;\n  Block.InScan := Placed;\n"
        if "Robot" in in_outs:
            reads = block.startswith(("FB_ReadArea", "FB_RcxTakeHead"))
            counted = "" if reads else "  Robot.Inner.Scan := Robot.Inner.Scan + UINT#1;\n"
            counted += f"  Robot.Inner.InScan := {str(not reads).upper()};\n"
        self._program = compiled(
            f"PROGRAM Alone\n  VAR\n{declared}    Block : {block};\n  END_VAR\n"
            f"{counted}  Block({given});\nEND_PROGRAM\n",
            engine,
        )
        self._start = self._program.snapshot()

    def __getitem__(self, path: str) -> Value:
        return self._program.read(f"Main.{path}")

    def __setitem__(self, path: str, value: Value) -> None:
        self._program.write(f"Main.{path}", value)

    def restart(self) -> None:
        """Restore the state before the first scan."""
        self._program.restore(self._start)

    def scan(self, now_ms: int) -> None:
        """Run one scan at this time."""
        self._program.scan(now_ms * 1000)
