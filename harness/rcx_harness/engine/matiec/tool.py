"""Where matiec is on this machine, and how it is called."""

from __future__ import annotations

import functools
import hashlib
import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rcx_harness.errors import InputError

__all__ = ["MISSING", "Matiec", "Message", "TranslationError", "find_c_compiler", "find_matiec"]

#: What a user reads, and what a skipped test says, where matiec is not installed.
MISSING = "matiec not found: set RCX_MATIEC or PATH"

#: The options with which OpenPLC v3 calls it: full locations, relaxed type equivalence, forward
#: references, REF_TO (twice) and constant expressions as array limits.
_OPTIONS = ("-f", "-l", "-p", "-r", "-R", "-a")

_PACKAGED = (Path("/usr/lib/matiec"), Path("/usr/share/matiec/lib"), Path("/usr/share/matiec"))

_MESSAGE = re.compile(
    r"^(?P<file>.+?):(?P<line>\d+)-(?P<column>\d+)\.\.\d+-\d+: error(?: [^:]+)?: (?P<text>.*)$"
)


@dataclass(frozen=True)
class Message:
    """One error of iec2c, at a place in the text that it was given (line and column from 1)."""

    text: str
    line: int
    column: int


class TranslationError(Exception):
    """iec2c gave no usable C.

    Args:
        messages: Its errors that lie in the given text, in its order; empty when it crashed
            or complained of something else.
        output: All that it printed.
        status: Its exit status, negative for a signal.
    """

    def __init__(self, messages: list[Message], output: str, status: int) -> None:
        self.messages = messages
        self.output = output
        self.status = status
        super().__init__(f"iec2c ended with status {status}")


@dataclass(frozen=True)
class Matiec:
    """An installed matiec: the compiler, its library of blocks and its C headers."""

    iec2c: Path
    library: Path
    headers: Path

    def translate(self, source: Path, target: Path) -> None:
        """Translate one ST file to C.

        Args:
            source: The file with everything in it.
            target: Directory that receives the C files.

        Raises:
            TranslationError: any exit status but 0; iec2c may crash after it printed errors.
        """
        command = [str(self.iec2c), *_OPTIONS, "-I", str(self.library), "-T", str(target)]
        done = subprocess.run(
            [*command, source.name], cwd=source.parent, capture_output=True, check=False
        )
        output = (done.stderr + done.stdout).decode("utf-8", "replace")
        if done.returncode == -signal.SIGINT:  # Ctrl-C goes to it, too
            raise KeyboardInterrupt
        if done.returncode != 0:
            found = list(_messages(output, source.name))
            raise TranslationError(found, output, done.returncode)

    def fingerprint(self) -> str:
        """A hash of the compiler, its library and its headers, as part of a cache key."""
        return _fingerprint(self)


def _messages(output: str, name: str) -> Iterator[Message]:
    for line in output.splitlines():
        match = _MESSAGE.match(line)
        if match and match["file"] == name:
            yield Message(match["text"].rstrip(".! "), int(match["line"]), int(match["column"]))


@functools.lru_cache(maxsize=8)
def _fingerprint(matiec: Matiec) -> str:
    digest = hashlib.sha256(matiec.iec2c.read_bytes())
    for folder, pattern in ((matiec.library, "*.txt"), (matiec.headers, "*.h")):
        for path in sorted(folder.glob(pattern)):
            digest.update(path.name.encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def find_matiec() -> Matiec | None:
    """Look for matiec in `RCX_MATIEC`, then on `PATH`.

    Returns:
        The installation, or None when there is none.

    Raises:
        InputError: `RCX_MATIEC` is set but leads to no complete matiec, or an `iec2c` on `PATH`
            has no library near it.
    """
    named = os.environ.get("RCX_MATIEC")
    if named:
        binary = shutil.which("iec2c", path=named)
        if binary is None:
            raise InputError(
                f"RCX_MATIEC has no iec2c in it: {named}",
                hint="name the directory that holds iec2c and lib, or unset RCX_MATIEC",
            )
    else:
        binary = shutil.which("iec2c")
        if binary is None:
            return None
    iec2c = Path(binary).resolve()
    for library in _library_places(iec2c.parent, Path(binary).parent):
        headers = _headers(library, iec2c.parent)
        if (library / "ieclib.txt").is_file() and headers is not None:
            return Matiec(iec2c, library.resolve(), headers.resolve())
    raise InputError(
        f"{binary} has no library: neither ieclib.txt nor C/iec_std_lib.h was found near it",
        hint="set RCX_MATIEC to the directory that holds iec2c and lib",
    )


def _library_places(*binaries: Path) -> Iterator[Path]:
    """Build tree and OpenPLC (lib beside it), prefix installations, then packages (Beremiz)."""
    for folder in dict.fromkeys(binaries):
        yield folder / "lib"
        for part in ("lib/matiec", "share/matiec/lib", "share/matiec", "lib"):
            yield folder.parent / part
    yield from _PACKAGED


def _headers(library: Path, binary_folder: Path) -> Path | None:
    """The C headers: `lib/C`; OpenPLC v3 keeps them in `core/lib` beside its iec2c."""
    for folder in (library / "C", binary_folder / "core" / "lib"):
        if (folder / "iec_std_lib.h").is_file():
            return folder
    return None


def find_c_compiler() -> str | None:
    """The C compiler: `CC`, then cc, gcc or clang on `PATH`; None when there is none."""
    for name in (os.environ.get("CC"), "cc", "gcc", "clang"):
        if name and (path := shutil.which(name)):
            return path
    return None
