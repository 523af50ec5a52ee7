"""The drawing of a robot calculates joints, tool, hands and shifts as the virtual controller does.

The drawing (JavaScript) and the controller (Python) are written independently from the manual.
"""

from __future__ import annotations

import json
import random
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.robot import Controller, Hand, RobotConfig
from rcx_harness.robot.shape import poses, shapes

_NODE = shutil.which("node")
_COMPARED = """\
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { figure, jointsOf } from "./robot.js";

const shift = ([x, y, z, r], [sx, sy, sz, sr]) => {
  const [cosine, sine] = [Math.cos((sr * Math.PI) / 180), Math.sin((sr * Math.PI) / 180)];
  return [(x - sx) * cosine + (y - sy) * sine, (y - sy) * cosine - (x - sx) * sine, z - sz, r - sr];
};
for (const { model, pose, pulses, mm } of JSON.parse(readFileSync("cases.json", "utf8"))) {
  const joints = jointsOf(model, pulses, "pulses", pose);
  const { tool, r } = figure(model, joints, pose);
  const place = shift([...tool, r], pose.shift ?? [0, 0, 0, 0]);
  mm.forEach((value, k) => assert.ok(Math.abs(value - place[k]) < 0.002, `${mm}: ${place}`));
  const back = jointsOf(model, mm, "mm", pose);
  const again = figure(model, back, pose).tool;
  tool.forEach((value, k) => assert.ok(Math.abs(value - again[k]) < 0.01, `${tool}: ${again}`));
  assert.equal(back[1] < 0, joints[1] < 0);
}
"""


def _cases(model: str, count: int) -> list[dict[str, Any]]:
    """Return positions within the limits, with hands on and beside the R axis, and shifts."""
    draw = random.Random(7)
    hands = {(1, 1): Hand((60_000, -20_000, 30_000, 1))}
    hands[1, 2] = Hand((9000 if model.startswith("YK") else 40_000, 15_000, -5000, 0))
    shifts = {1: (10_000, -20_000, 5_000, 30_000)}
    config = RobotConfig(robot=(model,), hands=hands, shifts=shifts)
    cases = []
    for number in range(count):
        controller = Controller(config)
        settings = controller.machine.settings.of(1)
        settings.hand, settings.shift = number % 3, number // 3 % 2
        pulses = [draw.randint(axis.soft_low, axis.soft_high) for axis in config.axes]
        controller.positions[:] = pulses
        shown = controller.machine.arm(1).shown(mm=True)[: len(pulses)]
        mm = [value / 1000 for value in shown]
        (shape,), (pose,) = shapes(controller), poses(controller)
        cases.append({"model": shape, "pose": pose, "pulses": pulses, "mm": mm})
    return cases


@pytest.mark.skipif(_NODE is None, reason="node is not installed")
@pytest.mark.parametrize("model", ["YK610XEC", "SXYX"])
def test_the_drawing_puts_the_tool_where_the_controller_says(tmp_path: Path, model: str) -> None:
    source = files("rcx_harness.trace.view").joinpath("page").joinpath("robot.js").read_bytes()
    (tmp_path / "robot.js").write_bytes(source)
    (tmp_path / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    (tmp_path / "cases.json").write_text(json.dumps(_cases(model, 60)), encoding="utf-8")
    (tmp_path / "compared.js").write_text(_COMPARED, encoding="utf-8")
    assert _NODE is not None
    done = subprocess.run(
        [_NODE, "compared.js"], cwd=tmp_path, capture_output=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, done.stderr
