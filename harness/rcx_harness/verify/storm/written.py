"""The files that campaign and sweep write to a folder. Files of the user are never overwritten."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from rcx_harness.verify.storm.replay import Replay
from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.replays import BEGINS, check

__all__ = ["check_folder", "command", "file_name", "forget", "write"]


def file_name(kind: str, taken: Iterable[str]) -> str:
    """Return an unused name for the files of a class."""
    plain = re.sub(r"\W+", "_", kind, flags=re.ASCII).strip("_").lower()[:40] or "failure"
    names = set(taken)
    number = next(k for k in range(1, len(names) + 2) if f"{plain}-{k}" not in names)
    return f"{plain}-{number}"


def check_folder(folder: Path) -> None:
    """Raise InputError if the path or one of its parents is a file."""
    for one in (folder, *folder.parents):
        if os.path.exists(one) and not os.path.isdir(one):
            raise InputError("is a file, not a folder", file=one, hint="name another with --out")


def write(folder: Path, files: Mapping[str, str]) -> None:
    """Write several files to a folder. If one cannot be written, write none.

    Raises:
        InputError: A file exists, and this program has not written it.
    """
    for name in files:
        check(folder / name)
    replace_files({folder / name: text for name, text in files.items()})


def forget(folder: Path) -> None:
    """Remove the replays and charts of an earlier call."""
    for file in sorted(folder.glob("*.toml")):
        chart = file.with_suffix(".svg")
        if file.read_bytes().startswith(BEGINS[".toml"]):
            file.unlink()
            if chart.is_file() and chart.read_bytes().startswith(BEGINS[".svg"]):
                chart.unlink()


def command(replayed: Replay, words: Iterable[str], file: Path) -> str:
    """Return the command line that replays a failing run."""
    duration = f"{replayed.duration_us // 1000}ms"
    seed = ["--seed", str(replayed.seed)] if replayed.seed else []
    return " ".join(["rcx run", *words, *seed, "--stimulus", file.as_posix(), "--for", duration])
