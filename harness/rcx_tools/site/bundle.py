"""Bundle for the playground's Python: the unchanged harness, lark, the library, and the tables."""

from __future__ import annotations

import io
import subprocess
from collections.abc import Iterator
from importlib.metadata import files as files_of
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from structured_text.errors import InputError

__all__ = ["bake", "bundle"]

ROOT = Path(__file__).resolve().parents[3]
_HERE = Path(__file__).resolve().parent
#: Top-level folders of the packages that a cell needs. They import no other top-level folder.
_ROOMS = {
    "rcx_harness": ("cell", "robot", "spec", "trace", "watch"),
    "structured_text": ("bench", "engines", "language", "output", "projects"),
}
#: Modules of lark that the harness does not import.
_LEFT_OUT = ("__pyinstaller", "tools")
_DATA = (".lark", ".py", ".st", ".toml", ".html", ".css", ".js")
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)


def bundle() -> bytes:
    """Return the packed files as bytes. Equal files give equal bytes."""
    packed = io.BytesIO()
    with ZipFile(packed, "w", ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in sorted(_files()):
            info = ZipInfo(name, _FIRST_DAY)
            info.compress_type = ZIP_DEFLATED
            archive.writestr(info, content)
    return packed.getvalue()


def _files() -> Iterator[tuple[str, bytes]]:
    packages = {ROOT / "harness" / name: rooms for name, rooms in _ROOMS.items()}
    every = [file for package in packages for file in package.glob("*.py")]
    every = [file for file in every if file.stem != "__main__"]
    every.append(ROOT / "harness" / "structured_text_names.py")
    folders = [package / room for package, rooms in packages.items() for room in rooms]
    for folder in (*folders, ROOT / "plc/lib", ROOT / "spec"):
        every += (file for file in folder.rglob("*") if file.suffix in _DATA)
    every += [_HERE.parent / "__init__.py", _HERE / "__init__.py", _HERE / "drive.py"]
    for file in every:
        yield file.relative_to(ROOT).as_posix(), file.read_bytes()
    for path in files_of("lark") or []:
        own = path.parts[0] == "lark" and path.suffix in _DATA and path.parts[1] not in _LEFT_OUT
        if own or path.name == "LICENSE":
            yield f"harness/{path.as_posix()}", path.read_binary()


def bake(archive: Path, pyodide: Path, job: Path) -> None:
    """Compile the modules of a bundle for the Python of the playground, and try a job there.

    Args:
        archive: The bundle. It is overwritten.
        pyodide: Folder of Pyodide.
        job: A job of `drive.Runner`. Its program is compiled as well.

    Raises:
        InputError: the compilation or the job fails.
    """
    command: list[str | Path] = ["node", _HERE / "bake.mjs", pyodide, archive, job]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"the playground's Python does not work: {done.stderr.strip()[-2000:]}")
