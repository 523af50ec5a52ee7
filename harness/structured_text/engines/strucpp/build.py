"""Compilation of ST files to a shared object: STruC++, our runtime in C++, the C++ compiler."""

from __future__ import annotations

import functools
import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.engines.native.c_layout import tables
from structured_text.engines.native.toolchain import (
    CompilerError,
    compile_shared,
    fingerprint,
    from_cache,
    run_tool,
    version,
)
from structured_text.errors import COMMAND, InputError
from structured_text.language.project import Project
from structured_text.language.source import origin, source_text
from structured_text.output.paths import real

__all__ = ["MISSING_STRUCPP", "NAMESPACE", "Strucpp", "compile_project", "find_strucpp"]

#: The message to users if STruC++ is not installed, and the reason of skipped tests.
MISSING_STRUCPP = "STruC++ not found: set RCX_STRUCPP or PATH"

#: The name space of the generated C++.
NAMESPACE = "strucpp"

_RUNTIME = Path(__file__).with_name("runtime.cpp")
# Without these options, all programs of a process would share inline variables, such as globals,
# and their guards.
_OPTIONS = ("-std=c++17", "-fvisibility=hidden")
_OF_GCC = ("-fno-gnu-unique",)
_BLOCKS = "iec-standard-fb.stlib"
_SCRIPT = Path("dist", "node", "cli.js")
_OTHERWISE = "write it another way, or use --engine builtin"
#: Matches a file and a line in a message of STruC++, g++ or clang++.
_PLACE = re.compile(r"\bpart(\d+)\.st:(\d+)(?::(\d+))?:(?: error: (.*))?")
_OFFSET = re.compile(r"at offset: (\d+)")


@dataclass(frozen=True)
class Strucpp:
    """An installed STruC++: its command, its standard blocks and its C++ headers."""

    command: tuple[str, ...]
    blocks: Path
    headers: Path


@functools.lru_cache(maxsize=8)
def _fingerprint(strucpp: Strucpp) -> str:
    """Return a hash of the compiler, its library and its headers, as part of a cache key."""
    own = Path(strucpp.command[-1])
    code = own.parents[1].rglob("*.js") if own.suffix == ".js" else [own]
    return fingerprint([*code, strucpp.blocks, *strucpp.headers.glob("*.hpp")])


def find_strucpp() -> Strucpp | None:
    """Look for STruC++ in `RCX_STRUCPP`, then on `PATH`.

    Raise InputError if `RCX_STRUCPP` is set but the STruC++ there is incomplete, or a `strucpp` on
    `PATH` has no headers or no standard blocks near it.

    Returns:
        The installation, or None if there is none.
    """
    named = os.environ.get("RCX_STRUCPP")
    binary = shutil.which("strucpp", path=named or None)
    if named and binary is None and (Path(named) / _SCRIPT).is_file():
        binary = str(Path(named) / _SCRIPT)
    if binary is None:
        if not named:
            return None
        raise InputError(
            f"RCX_STRUCPP has neither strucpp nor {_SCRIPT.as_posix()} in it: {named}",
            hint="name the folder of a release of STruC++ or of its sources after `npm run build`, "
            "or unset RCX_STRUCPP",
        )
    own = real(binary)
    command: tuple[str, ...] = (str(own),)
    if own.suffix == ".js":
        node = shutil.which("node")
        if node is None:
            raise InputError(f"{own} needs node, which is not found", hint="set PATH")
        command = (node, str(own))
    for folder in own.parents[:3]:
        blocks = folder / "libs" / _BLOCKS
        for headers in (folder / "runtime" / "include", folder / "src" / "runtime" / "include"):
            if blocks.is_file() and (headers / "iec_std_lib.hpp").is_file():
                return Strucpp(command, blocks, headers)
    raise InputError(
        f"{binary} has neither runtime/include nor libs/{_BLOCKS} near it",
        hint="set RCX_STRUCPP to the folder of a release of STruC++",
    )


def compile_project(
    project: Project, layout: Sequence[str], strucpp: Strucpp, compiler: str
) -> bytes:
    """Compile a project, or take it from the cache.

    `layout` are C++ expressions of the table `shim_layout`.

    Returns:
        The contents of the shared object.

    Raises:
        InputError: One of the compilers reports an error. If the compiler reports a place, the
            error has the user's file and line.
    """
    texts = [source_text(file) for file in project.files]
    added = "\n".join([*_program_part(project, layout), _RUNTIME.read_text(encoding="utf-8")])
    parts = [*texts, added, _fingerprint(strucpp), Path(__file__).read_text(encoding="utf-8")]

    def make() -> bytes:
        with tempfile.TemporaryDirectory(prefix=f"{COMMAND}-") as name:
            folder = Path(name)
            _translate(project, texts, strucpp, folder)
            unit = folder / "unit.cpp"
            unit.write_text(f'#include "program.cpp"\n{added}', encoding="utf-8")
            options = [*_OPTIONS, *(() if "clang" in version(compiler) else _OF_GCC)]
            try:
                return compile_shared(compiler, [*options, "-I", str(strucpp.headers)], unit)
            except CompilerError as error:
                place = _PLACE.search(error.output)
                file = project.files[int(place[1])] if place else None
                line = origin(file, int(place[2]), 1)[0] if place and file else None
                said = error.reason.split("error: ", 1)[-1][:200]
                raise InputError(
                    f"the C++ compiler refuses what STruC++ made of the program: {said}",
                    file=file,
                    line=line,
                    hint=_OTHERWISE,
                ) from None

    return from_cache(compiler, parts, make)


def _translate(project: Project, texts: Sequence[str], strucpp: Strucpp, folder: Path) -> None:
    """Run STruC++, which writes `program.cpp` and its header into a folder."""
    names = [f"part{number}.st" for number in range(len(texts))]
    for name, text in zip(names, texts, strict=True):
        (folder / name).write_text(text, encoding="utf-8")
    # Only the standard library is copied: other libraries may use names of the program.
    shutil.copy(strucpp.blocks, folder)
    options = ("-o", "program.cpp", "--line-directives", "--no-default-libs", "-L", ".")
    done = run_tool([*strucpp.command, *names, *options], folder)
    if done.returncode == 0:
        return
    output = (done.stderr + done.stdout).decode("utf-8", "replace")
    for place in _PLACE.finditer(output):
        if place[4]:
            number, line, column = int(place[1]), int(place[2]), int(place[3])
            # A lexical error has an offset instead of a line.
            if offset := _OFFSET.search(place[4]):
                before = texts[number][: int(offset[1])]
                line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
            file = project.files[number]
            line, column = origin(file, line, column)
            raise InputError(
                f"STruC++: {place[4].rstrip('. ')}",
                file=file,
                line=line,
                column=column,
                hint=_OTHERWISE,
            )
    said = next((line for line in output.splitlines() if line.strip()), "nothing")
    raise InputError(
        f"STruC++ failed with status {done.returncode} and said: {said}",
        file=project.files[0] if len(project.files) == 1 else None,
        hint=f"check its installation: {' '.join(strucpp.command)}",
    )


def _program_part(project: Project, layout: Sequence[str]) -> Iterator[str]:
    """Yield the C++ code of the runtime that depends on the program."""
    if project.configured:
        name = next(unit.name for unit in project.units if unit.kind == "CONFIGURATION")
        yield f"static {NAMESPACE}::Configuration_{name.upper()} shim_configuration;"
        instances = {name: f"shim_configuration.{name.upper()}" for name in project.instances}
    else:
        ((name, block),) = project.instances.items()
        yield f"static {NAMESPACE}::Program_{block.name.upper()} shim_program;"
        instances = {name: "shim_program"}
    yield "static void shim_programs(unsigned long long tick) {"
    for run in project.schedule:
        yield f"  if (tick % {run.every} == 0) {instances[run.instance]}.run();"
    yield "}"
    regions = [*instances.values(), *(f"{NAMESPACE}::{name}.value" for name in project.globals)]
    yield "#pragma GCC visibility push(default)"
    yield from tables(regions, layout, 'extern "C" ')
