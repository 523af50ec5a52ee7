"""Compilation of ST text to a shared object: iec2c, our runtime in C, the C compiler, the cache."""

from __future__ import annotations

import functools
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from structured_text.engines.native.c_layout import tables
from structured_text.engines.native.toolchain import (
    CompilerError,
    compile_shared,
    fingerprint,
    from_cache,
    run_tool,
)
from structured_text.errors import COMMAND, InputError
from structured_text.output.paths import real

__all__ = [
    "MISSING",
    "Matiec",
    "Message",
    "RefusedCodeError",
    "TranslationError",
    "Wanted",
    "compile_program",
    "find_matiec",
    "fingerprint_of",
]

_RUNTIME = Path(__file__).with_name("runtime.c")

_PROGRAM = re.compile(r"^\d+;([\w.]+);(\w+);$", re.MULTILINE)
_GLOBAL = re.compile(r"^__DECLARE_GLOBAL(_FB|_LOCATED|)\((\w+),(\w+),(\w+)\)", re.MULTILINE)
_GLOBAL_PLACE = re.compile(r"__INIT_GLOBAL_LOCATED\(\w+,(\w+),(\w+),")
# The development version of matiec writes names of other globals in front of this macro, so the
# pattern also matches inside a line.
_LOCATED = re.compile(r"__LOCATED_VAR\((\w+),(\w+),")


@dataclass(frozen=True)
class Wanted:
    """The contents that the shared object must export; used by `compile_program`.

    All names are in upper case, as matiec writes them.

    Attributes:
        instances: Program instances; the first entries of `shim_regions`.
        globals: Global variables; the next entries of `shim_regions`.
        layout: C expressions of the table `shim_layout`.
    """

    instances: tuple[str, ...]
    globals: tuple[str, ...]
    layout: tuple[str, ...]


def compile_program(text: str, wanted: Wanted, matiec: Matiec, compiler: str) -> bytes:
    """Compile a program, or take it from the cache.

    Returns:
        The contents of the shared object.

    Raises:
        TranslationError: iec2c reports an error in the text.
        RefusedCodeError: The C compiler refuses the code of iec2c.
    """
    parts = [
        text,
        repr(wanted),
        fingerprint_of(matiec),
        _RUNTIME.read_text(encoding="utf-8"),
        Path(__file__).read_text(encoding="utf-8"),
    ]
    return from_cache(compiler, parts, lambda: _compile(text, wanted, matiec, compiler))


def _compile(text: str, wanted: Wanted, matiec: Matiec, compiler: str) -> bytes:
    with tempfile.TemporaryDirectory(prefix=f"{COMMAND}-") as name:
        folder = Path(name)
        source, target = folder / "program.st", folder / "c"
        source.write_text(text, encoding="utf-8")
        target.mkdir()
        matiec.translate(source, target)
        unit = target / "shim_program.c"
        written = [_RUNTIME.read_text(encoding="utf-8"), *_program_part(target, wanted)]
        # The file of the resource includes POUS.c. The generated files come last, because they
        # define macros with the names of the program instances.
        parts = sorted(path.name for path in target.glob("*.c") if path.name != "POUS.c")
        written += [f'#include "{part}"' for part in parts]
        unit.write_text("\n".join(written) + "\n", encoding="utf-8")
        try:
            return compile_shared(compiler, ("-std=gnu11", "-I", str(matiec.headers)), unit)
        except CompilerError as error:
            raise RefusedCodeError(error.reason, _where(error.reason, target)) from None


class RefusedCodeError(Exception):
    """The error for C code that iec2c has written and the C compiler refuses.

    Args:
        reason: The first error of the C compiler.
        pou: Upper-case name of the POU with the error in its C code; empty if it is not known.
    """

    def __init__(self, reason: str, pou: str) -> None:
        self.reason = reason
        self.pou = pou
        super().__init__(reason)


#: Matches a file and a line in a message of gcc or clang.
_C_PLACE = re.compile(r"([\w.]+\.[ch]):(\d+):")
#: The first line of a function in the C code of iec2c; it has the name of its POU.
_C_FUNCTION = re.compile(r"^[A-Za-z_]\w*[ *]+(\w+?)(?:_body__|_init__)?\(")


def _where(reason: str, folder: Path) -> str:
    """Return the name of the POU whose C code has an error; empty if the error is elsewhere."""
    place = _C_PLACE.search(reason)
    file = folder / place[1] if place else None
    if place is None or file is None or not file.is_file():
        return ""
    lines = file.read_text(encoding="utf-8", errors="replace").splitlines()[: int(place[2])]
    names = (match[1].upper() for line in reversed(lines) if (match := _C_FUNCTION.match(line)))
    return next(names, "")


def _program_part(target: Path, wanted: Wanted) -> Iterator[str]:
    """Yield the C code of the runtime that depends on the program."""
    places = dict(_located(target))
    regions: list[str] = []
    for kind, place in zip(places.values(), places, strict=True):
        yield f"static {kind} shim_at{place};"
        yield f"{kind} *{place} = &shim_at{place};"
    programs = _programs(target)
    for instance in wanted.instances:
        symbol, kind = programs[instance]
        yield f"extern {kind} {symbol};"
        regions.append(symbol)
    variables = _globals(target)
    for variable in wanted.globals:
        declaration, region = variables[variable]
        yield declaration
        regions.append(region)
    regions += [f"shim_at{place}" for place in places]
    yield from tables(regions, wanted.layout)


def _located(target: Path) -> Iterator[tuple[str, str]]:
    """Yield matiec's C name of each direct address (`__QX0_0`), and its C type."""
    text = (target / "LOCATED_VARIABLES.h").read_text(encoding="utf-8", errors="replace")
    for match in _LOCATED.finditer(text):
        yield match[2], match[1]


def _programs(target: Path) -> dict[str, tuple[str, str]]:
    """Return C symbol and type of each program instance, by name."""
    text = (target / "VARIABLES.csv").read_text(encoding="utf-8", errors="replace")
    found = {}
    for match in _PROGRAM.finditer(text.partition("// Variables")[0]):
        # A full path is CONFIGURATION.RESOURCE.INSTANCE. Without a RESOURCE in the source, the C
        # name begins with RESOURCE.
        path = match[1].split(".")
        resource = path[1] if len(path) == 3 else "RESOURCE"
        found[path[-1]] = (f"{resource}__{path[-1]}", match[2])
    return found


def _globals(target: Path) -> dict[str, tuple[str, str]]:
    """Return declaration and C expression of each global variable, by name."""
    text = "".join(
        path.read_text(encoding="utf-8", errors="replace") for path in sorted(target.glob("*.c"))
    )
    places = {match[1]: match[2] for match in _GLOBAL_PLACE.finditer(text)}
    found = {}
    for match in _GLOBAL.finditer(text):
        form, kind, domain, name = match.groups()
        symbol = f"{domain}__{name}"
        if form == "_LOCATED":
            found[name] = ("", f"shim_at{places[name]}")
        elif form == "_FB":
            found[name] = (f"extern {kind} {symbol};", symbol)
        else:
            found[name] = (f"extern __IEC_{kind}_t {symbol};", f"{symbol}.value")
    return found


#: The message to users if matiec is not installed, and the reason of skipped tests.
MISSING = "matiec not found: set RCX_MATIEC or PATH"

#: The options of OpenPLC v3: full locations, relaxed type equivalence, forward references, REF_TO
#: (twice) and constant expressions as array limits.
_OPTIONS = ("-f", "-l", "-p", "-r", "-R", "-a")

#: Folders in which Linux distributions install matiec's library.
PACKAGED = (Path("/usr/lib/matiec"), Path("/usr/share/matiec/lib"), Path("/usr/share/matiec"))

_MESSAGE = re.compile(
    r"^(?P<file>.+?):(?P<line>\d+)-(?P<column>\d+)\.\.\d+-\d+: error(?: [^:]+)?: (?P<text>.*)$"
)


@dataclass(frozen=True)
class Message:
    """One error of iec2c, at a place in the text that it compiled (line and column from 1)."""

    text: str
    line: int
    column: int


class TranslationError(Exception):
    """The error for a text from which iec2c made no usable C.

    Args:
        messages: The errors of iec2c that have a line and column. Empty if iec2c crashed or
            reported only something else.
        output: The whole output of iec2c.
        status: The exit status of iec2c; negative if a signal ended it.
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

        Raises:
            TranslationError: The exit status is not 0; iec2c may crash after it printed errors.
        """
        command = [str(self.iec2c), *_OPTIONS, "-I", str(self.library), "-T", str(target)]
        done = run_tool([*command, source.name], source.parent)
        output = (done.stderr + done.stdout).decode("utf-8", "replace")
        if done.returncode != 0:
            found = list(_messages(output, source.name))
            raise TranslationError(found, output, done.returncode)


def _messages(output: str, name: str) -> Iterator[Message]:
    for line in output.splitlines():
        match = _MESSAGE.match(line)
        if match and match["file"] == name:
            yield Message(match["text"].rstrip(".! "), int(match["line"]), int(match["column"]))


@functools.lru_cache(maxsize=8)
def fingerprint_of(matiec: Matiec) -> str:
    """Return a hash of the compiler, its library and its headers, as part of a cache key."""
    return fingerprint([matiec.iec2c, *matiec.library.glob("*.txt"), *matiec.headers.glob("*.h")])


def find_matiec() -> Matiec | None:
    """Look for matiec in `RCX_MATIEC`, then on `PATH`.

    Raise InputError if `RCX_MATIEC` is set but the matiec there is incomplete, or an `iec2c` on
    `PATH` has no library near it.

    Returns:
        The installation, or None if there is none.
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
    iec2c = real(binary)
    for library in _library_places(iec2c.parent, Path(binary).parent):
        headers = _headers(library, iec2c.parent)
        if (library / "ieclib.txt").is_file() and headers is not None:
            return Matiec(iec2c, real(library), real(headers))
    raise InputError(
        f"{binary} has no library: neither ieclib.txt nor C/iec_std_lib.h was found near it",
        hint="set RCX_MATIEC to the directory that holds iec2c and lib",
    )


def _library_places(*binaries: Path) -> Iterator[Path]:
    """Yield the folders that may contain matiec's library.

    First come a build tree and OpenPLC, with `lib` beside iec2c. Then come an installation under a
    prefix, and the packages of distributions (Beremiz).
    """
    for folder in dict.fromkeys(binaries):
        yield folder / "lib"
        for part in ("lib/matiec", "share/matiec/lib", "share/matiec", "lib"):
            yield folder.parent / part
    yield from PACKAGED


def _headers(library: Path, binary_folder: Path) -> Path | None:
    """Return the folder of the C headers: `lib/C`, or `core/lib` beside the iec2c of OpenPLC v3."""
    for folder in (library / "C", binary_folder / "core" / "lib"):
        if (folder / "iec_std_lib.h").is_file():
            return folder
    return None
