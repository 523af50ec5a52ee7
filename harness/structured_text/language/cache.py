"""The caches for results of compilation: in this process, and in a folder of the user.

The distribution has a folder in the system's cache folder, which is `~/.cache` on Linux, or
`XDG_CACHE_HOME`. `RCX_CACHE=off` switches it off. Entries are written under a temporary name and
renamed, so that several processes may work at the same time.

Loading an entry can execute code, because entries are pickled. Each entry is therefore signed with
a key in another folder of the user. An entry with a wrong signature was written by another user or
is damaged. Such an entry is ignored and made again.
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
from structured_text.language.dialects import dialect_of
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
    "sources_key",
]

#: Greatest number of entries of one kind in the folder, and in this process.
IN_FOLDER, IN_PROCESS = 256, 48

_KEY_SIZE = _SIGNATURE_SIZE = 32

_T = TypeVar("_T")
_State = tuple[int, int, int, int, int]
#: The digest of each file that was read, with the times, size and inode that the file had then.
_digests: dict[str, tuple[_State, bytes]] = {}
#: Least age of a file [ns]. A file that changed more recently may change again without a new time
#: stamp.
SETTLED_NS = 2_000_000_000
memory: dict[str, OrderedDict[str, Any]] = {}
"""The results cached in this process by kind, the latest used last."""


def folder() -> Path | None:
    """Return the cache folder; None if it is switched off or cannot be created."""
    if os.environ.get("RCX_CACHE", "").lower() == "off":
        return None
    try:
        found = cache_root() / DISTRIBUTION
        found.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return found


def put(entry: Path, content: bytes) -> None:
    """Write an entry, and remove the oldest entries with the same suffix if there are too many.

    Each kind of entry has a suffix of its own. Raise OSError if the entry cannot be written.
    """
    _replace(entry, _signature(entry, content) + content)
    entries = sorted(entry.parent.glob(f"*{entry.suffix}"), key=lambda path: path.stat().st_mtime)
    for old in entries[:-IN_FOLDER]:
        old.unlink(missing_ok=True)


def content(entry: Path) -> bytes:
    """Return the content of an entry that `put` has written.

    Raises:
        OSError: There is no such entry.
        ValueError: Another user has written the entry, or it is damaged.
    """
    found = entry.read_bytes()
    signature, rest = found[:_SIGNATURE_SIZE], found[_SIGNATURE_SIZE:]
    if not hmac.compare_digest(signature, _signature(entry, rest)):
        raise ValueError(f"{entry} is not signed with the key of this user")
    with suppress(OSError):
        os.utime(entry)
    return rest


def _signature(entry: Path, content: bytes) -> bytes:
    """Return the signature of an entry. It includes the name, so entries cannot be swapped."""
    return hmac.digest(_key(), entry.name.encode() + b"\0" + content, "sha256")


@lru_cache(maxsize=1)
def _key() -> bytes:
    """Return the key of this user; if it cannot be saved, a key for this process."""
    try:
        place = settings_root() / DISTRIBUTION / "cache.key"
        with suppress(FileNotFoundError):
            if len(found := place.read_bytes()) == _KEY_SIZE:
                return found
        place.parent.mkdir(parents=True, exist_ok=True)
        _replace(place, os.urandom(_KEY_SIZE))
        return place.read_bytes()  # another process may have replaced the key
    except (OSError, RuntimeError):
        return os.urandom(_KEY_SIZE)


def _replace(file: Path, content: bytes) -> None:
    """Write a file atomically; only this user can read it."""
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as written:
        written.write(content)
    try:
        os.replace(written.name, file)
    except OSError:  # on Windows, this fails while another process reads the file
        os.unlink(written.name)
        raise


def sources_key(paths: Sequence[Path]) -> str:
    """Return a key for these files, their contents and the version of this engine.

    The key is empty if a file cannot be read. The caller then reports the error.
    """
    digest = hashlib.sha256(f"{_engine()} {dialect_of(paths)}".encode())
    try:
        for path in paths:
            lines = getattr(path, "lines", None)
            own = _digest(path) if lines is None else hashlib.sha256(repr(lines).encode()).digest()
            digest.update(b"\0" + os.fsencode(path) + b"\0" + own)
    except InputError:
        return ""
    return digest.hexdigest()


def _digest(path: Path) -> bytes:
    """Return the SHA-256 of a file; read it again only if its times, size or inode changed.

    As in git, a file that changed very recently is not trusted: a second change within the
    resolution of the file system's clock would leave all of these values unchanged. Raise
    InputError if the file cannot be read.
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
    """Return the times, size and inode of a file, which change when it is written, or None."""
    try:
        found = os.stat(name)
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino, found.st_dev


def is_lasting(paths: Sequence[Path]) -> bool:
    """Return whether no file is temporary. Results of temporary files are not saved."""
    temporary = tempfile.gettempdir()
    return not any(_is_in(folder, temporary) for folder in {path.parent for path in paths})


@lru_cache(maxsize=1024)
def _is_in(folder: Path, other: str) -> bool:
    """Return whether a folder equals another folder or is inside it; links are followed."""
    found, wanted = real(folder), real(other)
    return wanted in (found, *found.parents)


def remembered(kind: str, key: str, make: Callable[[], _T]) -> _T:
    """Return the result of `make` for this key, cached in this process.

    With an empty key nothing is cached. The result must not be changed afterwards.
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
    """Return the result of `make` for this key, cached in the folder.

    The result must be picklable.
    """
    place = folder() if key else None
    if place is None:
        return make()
    entry = place / f"{key}.{kind}"
    with suppress(Exception):  # the entry is missing or damaged: make the result again
        found: _T = pickle.loads(content(entry))
        return found
    made = make()
    with suppress(OSError, RecursionError):  # the disk is full, or nested too deeply for pickle
        put(entry, pickle.dumps(made, protocol=5))
    return made


def made_of(kind: str, key: str, files: Sequence[Path], make: Callable[[], _T]) -> _T:
    """Return the result of `make`, cached in this process and in the folder.

    Results of temporary files are cached in this process only. The result must be picklable and
    must not be changed afterwards.
    """
    lasting = key if is_lasting(files) else ""
    return remembered(kind, key, lambda: kept(kind, lasting, make))


@lru_cache(maxsize=1)
def _engine() -> str:
    """Return a hash of the engine's code, since another version may read sources differently."""
    digest = hashlib.sha256(sys.version.encode())
    package = Path(__file__).parents[1]
    rooms = [package / name for name in ("language", "projects", "engines")]
    code = (
        file for room in rooms for kind in ("*.py", "*.lark", "*.toml") for file in room.rglob(kind)
    )
    for file in sorted(code):
        digest.update(file.read_bytes())
    return digest.hexdigest()
