"""Command `make site`: write out/site from the pages of the repository and the playground."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from rcx_tools.site.bundle import bake, bundle
from rcx_tools.site.checked import problems
from rcx_tools.site.pages import staged
from rcx_tools.site.programs import ROOT, bake_job, programs_json
from rcx_tools.site.ranking import rank
from structured_text.errors import InputError

_HERE = Path(__file__).resolve().parent
_WORK = ROOT / "out/site-work"
_SITE = ROOT / "out/site"
#: Files of the npm package that a browser must load.
_PYTHON = (
    "pyodide.mjs",
    "pyodide.asm.mjs",
    "pyodide.asm.wasm",
    "python_stdlib.zip",
    "pyodide-lock.json",
)


def main() -> int:
    """Build the site. Return 2 if a tool is missing, 1 if a link is broken, else 0."""
    try:
        for name in ("node", "npm"):
            if shutil.which(name) is None:
                raise InputError(f"{name} is not found", hint="install Node.js 20 or newer")
        _documentation()
        _playground(_SITE / "play")
    except InputError as error:
        print(f"make site: {error}", file=sys.stderr)
        return 2
    found = problems(_SITE)
    for one in found[:50]:
        print(one, file=sys.stderr)
    if found:
        print(f"make site: {len(found)} broken links or foreign resources", file=sys.stderr)
        return 1
    size = sum(file.stat().st_size for file in _SITE.rglob("*") if file.is_file())
    print(f"out/site/index.html: {size / 1e6:.0f} MB; look at it with")
    print(f"  {Path(sys.executable).name} -m http.server --directory out/site")
    return 0


def _documentation() -> None:
    """Build the pages with Zensical."""
    work = _WORK / "pages"
    shutil.rmtree(work, ignore_errors=True)
    for path, content in staged():
        file = work / "docs" / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    shutil.copy(_HERE / "site.css", work / "docs")
    shutil.copy(_HERE / "zensical.toml", work)
    zensical = Path(sys.executable).with_name("zensical")
    if not zensical.exists():
        raise InputError("zensical is not installed", hint="make site installs it")
    _call([zensical, "build", "--clean"], work, "zensical")
    rank(work / "site")
    shutil.rmtree(_SITE, ignore_errors=True)
    shutil.move(work / "site", _SITE)


def _playground(place: Path) -> None:
    """Build the playground, together with the Python that runs in it."""
    work = _WORK / "python"
    work.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "package-lock.json", ".npmrc"):
        shutil.copy(_HERE / name, work)
    _call(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], work, "npm ci")
    pyodide = work / "node_modules/pyodide"
    shutil.copytree(_HERE / "playground", place)
    (place / "python").mkdir()
    for name in _PYTHON:
        shutil.copy(pyodide / name, place / "python")
    version = _version(pyodide)
    about = place / "about.txt"
    about.write_text(about.read_text(encoding="utf-8").replace("@PYODIDE@", version), "utf-8")
    (place / "programs.json").write_text(programs_json(), encoding="utf-8")
    archive, job = place / "harness.zip", work / "job.json"
    archive.write_bytes(bundle())
    job.write_text(bake_job(), encoding="utf-8")
    bake(archive, pyodide, job)
    _write_bytes(place)


def _write_bytes(place: Path) -> None:
    """Write the number of bytes that the worker fetches into the worker, for its progress bar."""
    files = [place / "python" / name for name in _PYTHON if not name.endswith(".mjs")]
    size = sum(file.stat().st_size for file in (*files, place / "harness.zip"))
    worker = place / "worker.js"
    worker.write_text(worker.read_text(encoding="utf-8").replace("@BYTES@", str(size)), "utf-8")


def _version(package: Path) -> str:
    return str(json.loads((package / "package.json").read_text(encoding="utf-8"))["version"])


def _call(command: Sequence[str | Path], folder: Path, name: str) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"{name} failed: {(done.stderr or done.stdout).strip()[-2000:]}")


if __name__ == "__main__":
    sys.exit(main())
