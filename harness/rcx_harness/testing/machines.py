"""The run of a hypothesis state machine on the cell of a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck
from hypothesis import settings as hypothesis_settings
from hypothesis.stateful import run_state_machine_as_test

from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.sources import source_files
from rcx_harness.testing.cells import folder_of
from rcx_harness.testing.machine import CellMachine, bound
from rcx_harness.testing.settings import artifacts, settings_of
from rcx_harness.verify.storm.cells import Cells
from rcx_harness.verify.storm.demands import Demands
from structured_text.testing.settings import project

__all__ = ["run_machine"]

_QUIET = (HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much)


def run_machine(
    item: pytest.Item,
    demands: Sequence[str],
    machine: type[CellMachine] | None,
    settings: Mapping[str, Any],
    temporary: Path,
) -> None:
    """Run a machine on cells with the settings of a test.

    `demands` are files relative to the project's folder. Without `machine` the ready-made one runs.
    `temporary` is the folder for a failing run if the project names none.
    """
    options = settings_of(item, {})
    home = project(item.config)
    replaced = options.pop("replace", None)
    files = source_files(options.pop("program"), options.pop("lib", None), replaced)
    compiled = Compiled(files, options.pop("engine", "auto"))
    options.pop("seed", None)
    made = Demands.load([home / one for one in demands])
    cells = Cells(compiled, options, made)
    parent = artifacts(item.config)
    folder = temporary if parent is None else parent / folder_of(item)
    wanted = bound(machine or CellMachine, cells, folder / "replay.toml")
    given = {"deadline": None, "suppress_health_check": _QUIET, **settings}
    try:
        run_state_machine_as_test(wanted, settings=hypothesis_settings(**given))
    finally:
        compiled.close()
