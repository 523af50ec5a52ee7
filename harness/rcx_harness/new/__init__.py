"""`rcx new`: a repository for a user's own cell, with program, tests and CI."""

from __future__ import annotations

import os
import re
from importlib.metadata import version
from pathlib import Path

from rcx_harness.spec.robots import RobotModel, robot_models
from rcx_harness.spec.wire import SIZE, check_size
from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["CI", "new_project"]

#: Files of a CI system in the template, by the name of the system.
CI: dict[str, str] = {
    "github": ".github/workflows/test.yml",
    "gitlab": ".gitlab-ci.yml",
    "jenkins": "Jenkinsfile",
}

_TEMPLATE = Path(__file__).resolve().parent / "template"
_PLACES = [120000, -45000, 30000, 0], [-80000, 60000, 30000, 0]
_NAME = re.compile(r"\w[\w .-]{0,59}")
#: Names that the folder may already contain, because an empty repository has them.
_WELCOME = {".git"}


def new_project(
    folder: Path,
    name: str | None = None,
    size: int = SIZE,
    ci: str = "all",
    robot: str | None = None,
) -> list[Path]:
    """Write the template into a new or empty folder.

    `name` is the cell's name in the README, by default that of the folder. `ci` is `"github"`,
    `"gitlab"`, `"jenkins"` or `"all"`. `robot` is a model of docs/reference/robots.md; by default
    each axis is a coordinate: X, Y, Z, R.

    Returns:
        The files, relative to the folder.
    """
    check_size(size)
    if ci != "all" and ci not in CI:
        raise InputError(f"there is no template for {ci!r}", hint=f"use {', '.join(CI)} or all")
    title = real(folder).name if name is None else name
    if not _NAME.fullmatch(title):
        raise InputError(
            f"{title!r} is not a name for a cell",
            hint="give --name with letters, digits, spaces, '.', '-' and '_', at most 60",
        )
    _check_empty(folder)
    words = {"@NAME@": title, "@SIZE@": str(size), "@VERSION@": version("rcx-harness")}
    words |= _robot(robot)
    others = {path for system, path in CI.items() if ci not in ("all", system)}
    files = {}
    for source in sorted(_TEMPLATE.rglob("*"), key=lambda file: file.parts):
        place = re.sub(r"(^|/)dot_", r"\1.", source.relative_to(_TEMPLATE).as_posix())
        if source.is_file() and place not in others and "__pycache__" not in source.parts:
            files[Path(place)] = _filled(source.read_text(encoding="utf-8"), words)
    replace_files({folder / place: text.encode() for place, text in files.items()})
    return list(files)


def _points(model: RobotModel) -> list[list[int]]:
    """Return two positions that the robot can reach, in pulses."""
    return [
        [
            round(joint.zero + (joint.low + share * (joint.high - joint.low)) * per)
            for joint in model.joints
            for per in (joint.pulses_per_unit,)
        ]
        for share in (0.4, 0.7)
    ]


def _robot(name: str | None) -> dict[str, str]:
    """Return the lines of the robot file for a model; without a name, for four plain axes."""
    if name is None:
        return {"@ROBOT@": ""} | {f"@POINT{k}@": str(at) for k, at in enumerate(_PLACES, 1)}
    models = robot_models()
    if name not in models:
        raise InputError(f"there is no robot {name!r}", hint=f"use {', '.join(models)}")
    places = enumerate(_points(models[name]), 1)
    return {"@ROBOT@": f'robot = "{name}"\n'} | {f"@POINT{k}@": str(at) for k, at in places}


def _check_empty(folder: Path) -> None:
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError("is a file", file=folder, hint="name a folder that is new or empty")
    try:
        there = [path.name for path in folder.iterdir()] if os.path.exists(folder) else []
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=folder) from None
    found = sorted(set(there) - _WELCOME)
    if found:
        more = f" and {len(found) - 3} more" if len(found) > 3 else ""
        raise InputError(
            f"is not empty: {', '.join(found[:3])}{more}",
            file=folder,
            hint="nothing was written; name a folder that is new or empty",
        )


def _filled(text: str, words: dict[str, str]) -> str:
    for token, word in words.items():
        text = text.replace(token, word)
    return text
