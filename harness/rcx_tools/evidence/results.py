"""Results of the checks. Each check writes its figures to out/verification/NAME.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

__all__ = ["FOLDER", "ROOT", "write_result"]

#: Root of the repository.
ROOT = Path(__file__).resolve().parents[3]
#: The folder of the results of the checks.
FOLDER = ROOT / "out" / "verification"


def write_result(name: str, figures: Mapping[str, object], *, met: bool) -> Path:
    """Write the figures of `make NAME`. `met` says whether the check has passed."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    file = FOLDER / f"{name}.json"
    content = {"command": f"make {name}", "figures": dict(figures), "met": met}
    file.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return file
