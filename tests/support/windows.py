"""The environment for a process that behaves nearly as on Windows."""

from __future__ import annotations

import json
import os
from pathlib import Path

from system_names import absent_on, hidden_on

_FOLDER = Path(__file__).with_name("as_windows")
_SEEN = (
    *("_ctypes", "asyncio", "ctypes", "mmap", "os", "select"),
    *("signal", "socket", "subprocess", "sys"),
)


def as_windows(folder: Path) -> dict[str, str]:
    """Return the environment. The process and its children then load as_windows/sitecustomize.py.

    The processes print in code page 1252, as Python does on Windows into a file or a pipe.
    """
    told = folder / "windows.json"
    lacks = {name: sorted(hidden_on(name, "win32")) for name in _SEEN}
    told.write_text(json.dumps({"lacks": lacks, "absent": sorted(absent_on("win32"))}))
    ways = [str(_FOLDER), *filter(None, [os.environ.get("PYTHONPATH")])]
    return dict(os.environ) | {
        "RCX_AS_WINDOWS": str(told),
        "PYTHONPATH": os.pathsep.join(ways),
        "PYTHONIOENCODING": "cp1252",
        "PYTHONWARNDEFAULTENCODING": "1",
        "LOCALAPPDATA": str(folder / "local"),
    }
