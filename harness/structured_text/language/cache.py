"""What is kept of earlier compilations: in this process, and in a folder of the user.

The folder is that of the distribution in the system's folder for that, `~/.cache` on Linux, or in
`XDG_CACHE_HOME`; `RCX_CACHE=off` does without it. Entries are written under another name and
renamed, so that several processes may work at once.

What is in an entry is executed. So each is signed with a key that lies in another folder of the
user, and one that somebody else has put there, or that is damaged, is made anew.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import pickle
import sys
import tempfile
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from structured_text.errors import DISTRIBUTION, InputError
from structured_text.output.limits import SOURCE
from structured_text.output.paths import real
from structured_text.output.reading import file_bytes
from structured_text.output.system import cache_root, settings_root

__all__ = [
    "SETTLED_NS",
    "content",
    "file_state",
    "folder",
    "is_lasting",
    "kept",
    "made_of",
    "memory",
]
__all__ += ["put", "remembered", "sources_key"]

#: Entries of one kind in the folder, and in this process.
IN_FOLDER, IN_PROCESS = 256, 48

_KEY_SIZE = _SIGNATURE_SIZE = 32

_T = TypeVar("_T")
_State = tuple[int, int, int, int, int]
#: The digest of each file that was read, and the state in which it was read.
_digests: dict[str, tuple[_State, bytes]] = {}
#: A file that changed more recently may change again without a trace.
SETTLED_NS = 2_000_000_000
memory: dict[str, OrderedDict[str, Any]] = {}
"""What this process remembers of each kind, the latest used last."""


def folder() -> Path | None:
    """Where entries are kept; None where nothing can or shall be."""
    if os.environ.get("RCX_CACHE", "").lower() == "off":
        return None
    try:
        found = cache_root() / DISTRIBUTION
        found.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return found


def put(entry: Path, content: bytes) -> None:
    """Write an entry, and remove the oldest of its kind, which is its suffix.

    Raises:
        OSError: it cannot be written.
    """
    _replace(entry, _signature(entry, content) + content)
    entries = sorted(entry.parent.glob(f"*{entry.suffix}"), key=lambda path: path.stat().st_mtime)
    for old in entries[:-IN_FOLDER]:
        old.unlink(missing_ok=True)


def content(entry: Path) -> bytes:
    """Return what `put` has written.

    Raises:
        OSError: There is no such entry.
        ValueError: Somebody else has written it, or it is damaged.
    """
    found = entry.read_bytes()
    signature, rest = found[:_SIGNATURE_SIZE], found[_SIGNATURE_SIZE:]
    if not hmac.compare_digest(signature, _signature(entry, rest)):
        raise ValueError(f"{entry} is not signed with the key of this user")
    with suppress(OSError):
        os.utime(entry)
    return rest


def _signature(entry: Path, content: bytes) -> bytes:
    """Return the signature of an entry, which is of this name and no other."""
    return hmac.digest(_key(), entry.name.encode() + b"\0" + content, "sha256")


@lru_cache(maxsize=1)
def _key() -> bytes:
    """Return the key of this user; where it cannot be saved, one of this process."""
    try:
        place = settings_root() / DISTRIBUTION / "cache.key"
        with suppress(FileNotFoundError):
            if len(found := place.read_bytes()) == _KEY_SIZE:
                return found
        place.parent.mkdir(parents=True, exist_ok=True)
        _replace(place, os.urandom(_KEY_SIZE))
        return place.read_bytes()  # perhaps that of a process that was later
    except (OSError, RuntimeError):
        return os.urandom(_KEY_SIZE)


def _replace(file: Path, content: bytes) -> None:
    """Write a file that only this user can read, at once and as a whole."""
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as written:
        written.write(content)
    try:
        os.replace(written.name, file)
    except OSError:  # on Windows, while another process reads that one
        os.unlink(written.name)
        raise


def sources_key(paths: Sequence[Path]) -> str:
    """A name for these files with their contents, as this engine understands them.

    Empty where one cannot be read: whoever needs it says so.
    """
    digest = hashlib.sha256(_engine().encode())
    try:
        for path in paths:
            lines = getattr(path, "lines", None)
            own = _digest(path) if lines is None else hashlib.sha256(repr(lines).encode()).digest()
            digest.update(b"\0" + os.fsencode(path) + b"\0" + own)
    except InputError:
        return ""
    return digest.hexdigest()


def _digest(path: Path) -> bytes:
    """Return the SHA-256 of a file; it is read again only if its times, size or number changed.

    As git does, it does not trust a file that changed just now: a second change within the
    resolution of the file system's clock would leave all of these as they are.

    Raises:
        InputError: The file cannot be read.
    """
    name = os.fspath(path)
    state = file_state(name)
    found = _digests.get(name)
    if found is not None and found[0] == state:
        return found[1]
    digest = hashlib.sha256(file_bytes(path, SOURCE)).digest()
    if state is not None and time.time_ns() - max(state[:2]) > SETTLED_NS:
        _digests[name] = state, digest
    else:
        _digests.pop(name, None)
    return digest


def file_state(name: str) -> _State | None:
    """Return what changes when a file is written; None if there is no such file."""
    try:
        found = os.stat(name)
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino, found.st_dev


def is_lasting(paths: Sequence[Path]) -> bool:
    """Are these files to be there tomorrow? What is made of temporary ones is not kept."""
    temporary = tempfile.gettempdir()
    return not any(_is_in(folder, temporary) for folder in {path.parent for path in paths})


@lru_cache(maxsize=1024)
def _is_in(folder: Path, other: str) -> bool:
    """Return whether a folder is another one, or below it, links followed."""
    found, wanted = real(folder), real(other)
    return wanted in (found, *found.parents)


def remembered(kind: str, key: str, make: Callable[[], _T]) -> _T:
    """What `make` gave for this key before in this process, or gives now.

    Args:
        kind: What it is.
        key: What it was made of; empty for what cannot be remembered.
        make: Makes it; nothing may change it afterwards.
    """
    if not key:
        return make()
    ours = memory.setdefault(kind, OrderedDict())
    if key in ours:
        ours.move_to_end(key)
    else:
        ours[key] = make()
        if len(ours) > IN_PROCESS:
            ours.popitem(last=False)
    found: _T = ours[key]
    return found


def kept(kind: str, key: str, make: Callable[[], _T]) -> _T:
    """What `make` gave for this key before, in any process, or gives now; it must be picklable."""
    place = folder() if key else None
    if place is None:
        return make()
    entry = place / f"{key}.{kind}"
    with suppress(Exception):  # not there, or not whole: it is made anew
        found: _T = pickle.loads(content(entry))
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
    package = Path(__file__).parents[1]
    rooms = [package / name for name in ("language", "projects", "engines")]
    code = (file for room in rooms for kind in ("*.py", "*.lark") for file in room.rglob(kind))
    for file in sorted(code):
        digest.update(file.read_bytes())
    return digest.hexdigest()
