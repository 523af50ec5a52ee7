"""`rcx new`: a repository for a cell, with program, tests and CI."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import choices
from rcx_harness.new import CI, new_project
from rcx_harness.spec.robots import robot_models
from rcx_harness.spec.wire import SIZE
from structured_text.output.console import quoted

__all__ = ["new"]

_TRY = ("pytest", "rcx run plc --robot robot.toml --stimulus stimulus.toml --for 5s --show")
_INSTALL = ("pip install pytest   # it is missing here; for CI see README.md", "pytest")


def new(
    folder: Annotated[Path, typer.Argument(help="Folder to create; new or empty.", metavar="DIR")],
    name: Annotated[
        str | None, typer.Option(help="Name of the cell. Default: name of the folder.")
    ] = None,
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE,
    ci: Annotated[
        str,
        typer.Option(help=f"CI files: {', '.join(CI)} or all.", autocompletion=choices(*CI, "all")),
    ] = "all",
    robot: Annotated[
        str | None,
        typer.Option(
            help="Model of the robot, as in docs/reference/robots.md: YK400XE ...",
            autocompletion=lambda: list(robot_models()),
        ),
    ] = None,
) -> None:
    """Write a repository for a cell of your own: program, tests, virtual robot, CI files.

    Exit code: 0, or 2 if the folder is not empty.
    """
    files = new_project(folder, name, size, ci, robot)
    for file in files:
        print(f"  {file.as_posix()}")
    print(f"written: {len(files)} files in {folder}\n\nnext:\n  cd {quoted(folder)}")
    for line in _INSTALL if find_spec("pytest") is None else _TRY:
        print(f"  {line}")
