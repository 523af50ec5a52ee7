"""What is kept of earlier compilations: in this process, and in a folder of the user.

The folder is `rcx-harness` in the system's folder for that, `~/.cache` on Linux, or in
`XDG_CACHE_HOME`; `RCX_CACHE=off` does without it. Entries are written under another name and
renamed, so that several processes may work at once.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import tempfile
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from rcx_harness.errors import InputError
from rcx_harness.output.limits import SOURCE
from rcx_harness.output.reading import file_bytes
from rcx_harness.output.system import cache_root

__all__ = ["folder", "is_lasting", "kept", "made_of", "memory", "put", "remembered", "sources_key"]

#: Entries of one kind in the folder, and of all kinds in this process.
IN_FOLDER, IN_PROCESS = 256, 48

_T = TypeVar("_T")
memory: OrderedDict[tuple[str, str], Any] = OrderedDict()
"""What this process remembers, the latest used last."""


def folder() -> Path | None:
    """Where entries are kept; None where nothing can or shall be."""
    if os.environ.get("RCX_CACHE", "").lower() == "off":
        return None
    try:
        found = cache_root() / "rcx-harness"
        found.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return found


def put(entry: Path, content: bytes) -> None:
    """Write an entry, and remove the oldest of its kind, which is its suffix.

    Raises:
        OSError: it cannot be written.
    """
    with tempfile.NamedTemporaryFile(dir=entry.parent, delete=False) as file:
        file.write(content)
    try:
        os.replace(file.name, entry)
    except OSError:  # on Windows, while another process reads that one
        os.unlink(file.name)
        raise
    entries = sorted(entry.parent.glob(f"*{entry.suffix}"), key=lambda path: path.stat().st_mtime)
    for old in entries[:-IN_FOLDER]:
        old.unlink(missing_ok=True)


def sources_key(paths: Sequence[Path]) -> str:
    """A name for these files with their contents, as this engine understands them.

    Empty where one cannot be read: whoever needs it says so.
    """
    digest = hashlib.sha256(_engine().encode())
    try:
        for path in paths:
            lines = getattr(path, "lines", None)
            content = file_bytes(path, SOURCE) if lines is None else repr(lines).encode()
            digest.update(b"\0" + os.fsencode(path) + b"\0" + content)
    except InputError:
        return ""
    return digest.hexdigest()


def is_lasting(paths: Sequence[Path]) -> bool:
    """Are these files to be there tomorrow? What is made of temporary ones is not kept."""
    temporary = Path(tempfile.gettempdir()).resolve()
    folders = [folder.resolve() for folder in {path.parent for path in paths}]
    return not any(temporary in (folder, *folder.parents) for folder in folders)


def remembered(kind: str, key: str, make: Callable[[], _T]) -> _T:
    """What `make` gave for this key before in this process, or gives now.

    Args:
        kind: What it is.
        key: What it was made of; empty for what cannot be remembered.
        make: Makes it; nothing may change it afterwards.
    """
    if not key:
        return make()
    if (kind, key) in memory:
        memory.move_to_end((kind, key))
    else:
        memory[kind, key] = make()
        if len(memory) > IN_PROCESS:
            memory.popitem(last=False)
    found: _T = memory[kind, key]
    return found


def kept(kind: str, key: str, make: Callable[[], _T]) -> _T:
    """What `make` gave for this key before, in any process, or gives now; it must be picklable."""
    place = folder() if key else None
    if place is None:
        return make()
    entry = place / f"{key}.{kind}"
    with suppress(Exception):  # not there, or not whole: it is made anew
        found: _T = pickle.loads(entry.read_bytes())
        os.utime(entry)
        return found
    made = make()
    with suppress(OSError, RecursionError):  # a full disk; more depth than pickle can write
        put(entry, pickle.dumps(made, protocol=5))
    return made


def made_of(kind: str, key: str, files: Sequence[Path], make: Callable[[], _T]) -> _T:
    """What was made of these files before, in this process or an earlier one; else it is made.

    Args:
        kind: What it is.
        key: Of the files, and of what else decides.
        files: They; what is made of temporary ones is forgotten with the process.
        make: Makes it; picklable, and nothing may change it afterwards.
    """
    lasting = key if is_lasting(files) else ""
    return remembered(kind, key, lambda: kept(kind, lasting, make))


@lru_cache(maxsize=1)
def _engine() -> str:
    """A name for the engine's own code: another one understands sources differently."""
    digest = hashlib.sha256(sys.version.encode())
    here = Path(__file__).parent
    for file in sorted([*here.rglob("*.py"), *here.rglob("*.lark")]):
        digest.update(file.read_bytes())
    return digest.hexdigest()
