"""A program gives the same trace over the direct link and over EtherNet/IP."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.robot import Point, RobotProgram

Build = Callable[..., Cell]


@pytest.mark.exhaustive(but=["jitter"])
@pytest.mark.parametrize(
    ("jitter", "phases"), [("0ms", "zero"), ("12ms", "random")], ids=["steady", "jitter"]
)
def test_the_demo_over_ethernet_ip_has_the_trace_of_the_direct_link(
    build_cell: Build, repository: Path, tmp_path: Path, jitter: str, phases: str
) -> None:
    robot = RobotConfig(programs=(RobotProgram(duration=300.0, loop=False),), points={19: Point()})
    traces = []
    for link in ("direct", "enip"):
        file = tmp_path / f"{link}.jsonl"
        cell = build_cell(repository / "plc" / "examples" / "01_power_up", link=link, robot=robot,
                          jitter=jitter, phases=phases, seed=1, trace=file)  # fmt: skip
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run("1500ms")
        cell.inject("link_down")
        cell.run("200ms")
        cell.inject("link_up")
        cell.run("300ms")
        cell.close()
        traces.append(file.read_text().splitlines())
    direct, enip = traces
    assert enip[0] == direct[0].replace('"link":"direct"', '"link":"enip"')
    assert enip[1:] == direct[1:]
    assert len(direct) > 700
