"""Users' cells with faults to insert: tests/data/planted and planted_handshakes."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.output.toml_files import load_toml

PLANTED = Path(__file__).resolve().parents[1] / "data/planted"
HANDSHAKES = PLANTED.with_name("planted_handshakes")


@dataclass(frozen=True)
class Fault:
    """A row of faults.toml: a fault that replaces `before` in `file` by `after`.

    `before` occurs once.
    """

    name: str
    file: str
    what: str
    breaks: str
    before: str
    after: str


FAULTS = tuple(Fault(**row) for row in load_toml(PLANTED / "faults.toml")["fault"])
OF_HANDSHAKES = {
    row["name"]: Fault(**row) for row in load_toml(HANDSHAKES / "faults.toml")["fault"]
}


def planted(folder: Path, fault: Fault | None = None, home: Path = PLANTED) -> Path:
    """Copy the project into a new folder `cell` in `folder`, with the fault in it.

    Returns:
        The project's folder.

    Raises:
        ValueError: `before` does not occur exactly once in the file.
    """
    project = Path(shutil.copytree(home / "cell", folder / "cell"))
    if fault:
        file = folder / fault.file
        text = file.read_text(encoding="utf-8")
        if text.count(fault.before) != 1:
            raise ValueError(f"{fault.name}: `before` does not stand once in {fault.file}")
        file.write_text(text.replace(fault.before, fault.after), encoding="utf-8")
    return project


def found_by(fault: Fault, told: Sequence[str]) -> bool:
    """Return whether the failures include the property that the fault breaks."""
    kinds = (fault.breaks, f"always {fault.breaks}")
    return any(one.startswith(tuple(f"{kind} at " for kind in kinds)) for one in told)
