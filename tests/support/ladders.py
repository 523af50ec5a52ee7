"""Programs that are exported as ladder, read back and compared with their source scan by scan."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from exported import imported
from rcx_harness.cell.exports import export, sources_of
from structured_text.engines.builtin import BuiltinProgram
from structured_text.export.output import write
from structured_text.language import syntax as s
from structured_text.language.load import load
from structured_text.language.walk import declared, nodes

__all__ = ["Compared", "read_back", "written_ladder"]


def written_ladder(program: Sequence[Path], file: Path) -> tuple[str, ...]:
    """Export programs as ladder to a file, with the part of the library that they need.

    Return the notes of the export.
    """
    output = export("plcopen", program=program, only_needed=True, ladder=True)
    write(output, file)
    return output.notes


def read_back(program: Sequence[Path], folder: Path) -> list[Path]:
    """Return the files of Structured Text that are read from the exported ladder."""
    written_ladder(program, folder / "ladder.xml")
    return imported(folder / "ladder.xml", folder / "back")


class Compared:
    """A program from its source and from its ladder, which get the same inputs."""

    def __init__(self, program: Sequence[Path], folder: Path) -> None:
        sources = sources_of(program=program, only_needed=True)
        (part,) = sources.of("PROGRAM")
        assert isinstance(part.node, s.Pou)
        files = list(dict.fromkeys(one.file for one in sources.parts))
        self.source = BuiltinProgram.build(load(files))
        self.ladder = BuiltinProgram.build(load(read_back(program, folder)))
        specs = {name.text: one.spec for _, one, name in declared(part.node.sections)}
        self.names = list(specs)
        written = {
            found.target.key
            for found in nodes(part.node.body)
            if isinstance(found, s.Assign) and isinstance(found.target, s.Name)
        }
        self._given = {
            name: spec.name.key
            for name, spec in specs.items()
            if name.upper() not in written and isinstance(spec, s.NamedSpec)
        }

    def scans(self, count: int, seed: int) -> list[tuple[int, str, Any, Any]]:
        """Return the differences: scan, variable, value of the source and of the ladder.

        Before each scan, some variables that the program does not assign get random values.
        """
        chance = random.Random(seed)
        found = []
        for scan in range(count):
            for name, value in self._values(chance):
                for program in (self.source, self.ladder):
                    if isinstance(value, bytes):
                        program.write_bytes(f"Main.{name}", value)
                    else:
                        program.write(f"Main.{name}", value)
            for program in (self.source, self.ladder):
                program.scan(scan * 10_000)
            for name in self.names:
                one, other = (p.read(f"Main.{name}") for p in (self.source, self.ladder))
                if one != other:
                    found.append((scan, name, one, other))
        return found

    def _values(self, chance: random.Random) -> list[tuple[str, Any]]:
        found: list[tuple[str, Any]] = []
        for name, kind in self._given.items():
            if kind == "BOOL" and chance.random() < 0.3:
                found.append((name, chance.random() < 0.5))
            elif kind in ("INT", "WORD", "UINT", "DINT") and chance.random() < 0.3:
                found.append((name, chance.randrange(4)))
            elif kind == "RCX_IMAGE":
                # Few bytes change, so that a state of the robot lasts for some scans.
                data = bytearray(self.source.read_bytes(f"Main.{name}"))
                for _ in range(2):
                    data[chance.randrange(4)] ^= 1 << chance.randrange(8)
                found.append((name, bytes(data)))
        return found
