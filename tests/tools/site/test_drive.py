"""The functions that the worker of the playground calls also work outside of a browser."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from example_runs import changes, recorded_trace
from rcx_tools.docs.examples import examples
from rcx_tools.site.drive import Runner
from rcx_tools.site.programs import block_jobs, example_jobs

pytestmark = pytest.mark.exhaustive

Run = Callable[..., dict[str, Any]]


@pytest.fixture
def runner(tmp_path: Path) -> Runner:
    return Runner(tmp_path / "cell")


@pytest.fixture
def run(runner: Runner) -> Run:
    """Run an example of the playground as the page does, with these entries of its job changed."""

    def asked(job: dict[str, Any], tell: Callable[[float], object] = print, **others: Any) -> Any:
        whole = {"rpi": 10_000, **job, **others, "name": job["title"]}
        whole |= {key: f"{whole[key]}us" for key in ("scan", "rpi", "for")}
        return json.loads(runner.run(json.dumps(whole), tell))

    return asked


def test_an_example_runs_to_its_recorded_trace(runner: Runner, run: Run) -> None:
    """An example gives its recorded trace.

    It has two areas of 256 bytes at offsets, so all keys.
    """
    shares: list[float] = []
    outcome = run(example_jobs()["02_extended_area"], shares.append)
    assert outcome["told"] == ("3000 ms: 300 scans of 10 ms, 2 remote commands, no broken rules")
    assert outcome["broken"] == []
    assert outcome["page"].startswith("<!doctype html>\n<!-- rcx view -->")
    assert shares == sorted(shares)
    assert shares[-1] == 1
    recorded = recorded_trace(examples()["02_extended_area"]).read_text(encoding="utf-8")
    assert list(changes(runner.trace().splitlines())) == recorded.splitlines()[1:]


def test_an_example_with_a_robot_program_runs(run: Run) -> None:
    """An example runs with a robot file that names CARRY.PGM, a file of the job."""
    job = example_jobs()["16_robot_program"]
    assert "CARRY.PGM" in job["files"]
    assert run(job | {"for": 1_000_000})["told"].endswith("no broken rules")


def test_a_blocks_example_runs(run: Run) -> None:
    assert run(block_jobs()["FB_ServoOn"])["broken"] == []


def test_the_number_of_remote_commands_is_in_words(run: Run) -> None:
    """The result says "1 remote command" or "no remote commands".

    FB_ReadVersions executes one command. FB_ServoOn uses only dedicated inputs.
    """
    assert ", 1 remote command, no broken rules" in run(block_jobs()["FB_ReadVersions"])["told"]
    assert ", no remote commands, no broken rules" in run(block_jobs()["FB_ServoOn"])["told"]


def test_every_block_with_an_example_is_offered_with_its_stimulus() -> None:
    jobs = block_jobs()
    assert len(jobs) > 130
    assert all(len(job["files"]) == 1 and job["for"] >= 1_000_000 for job in jobs.values())
    assert jobs["FB_MovePtp"]["stimulus"] == [
        (0, 'set = { "Main.CellSafe" = true }'),
        (600_000, 'set = { "Main.Start" = true }'),
    ]


def test_an_error_says_its_file_and_line(run: Run) -> None:
    job = example_jobs()["01_power_up"]
    lines = job["files"]["PowerUp.st"].splitlines()
    place = next(k for k, line in enumerate(lines) if line.startswith("  ReadArea("))
    lines.insert(place, "  Start := 5;")
    error = run(job, files={**job["files"], "PowerUp.st": "\n".join(lines)})["error"]
    assert (error["file"], error["line"]) == ("PowerUp.st", place + 1)
    assert "BOOL" in error["message"]


def test_an_error_of_the_stimulus_says_which_moment(run: Run) -> None:
    job = example_jobs()["01_power_up"]
    wrong = [*job["stimulus"], (900_000, 'robot = "explosion"')]
    error = run(job, stimulus=wrong)["error"]
    assert error["moment"] == len(job["stimulus"])
    assert "explosion" in error["message"]
    assert "file" not in error


@pytest.mark.parametrize("text", ["set = ", 'set = { "Main.Start" = true'])
def test_a_moment_that_is_no_toml_is_said(run: Run, text: str) -> None:
    job = example_jobs()["01_power_up"]
    assert run(job, stimulus=[(0, text)])["error"]["moment"] == 0


def test_an_error_of_a_robot_file_says_its_line(run: Run) -> None:
    job = example_jobs()["01_power_up"]
    error = run(job, robots=['size = 48\nbest = "yes"\n'])["error"]
    assert (error["file"], "best" in error["message"]) == ("robot1.toml", True)


def test_a_broken_rule_is_reported_with_its_time(run: Run) -> None:
    """A broken rule is reported with its time.

    Two dedicated inputs change in one scan, in an area that no block has written.

    Source: manual chapter 5, 3
    """
    program = Path(__file__).parents[2] / "cell/programs/RawArea.st"
    text = program.read_text(encoding="utf-8").partition("END_TYPE\n")[2]
    job: dict[str, Any] = {"title": "raw", "files": {"RawArea.st": text}, "robots": []}
    job |= {"stimulus": [(300_000, 'set = { "Main.Bits0" = 65 }')], "scan": 10_000}
    outcome = run(job | {"for": 1_000_000})
    assert outcome["told"].endswith("2 broken rules")
    assert outcome["broken"][0].startswith("300 ms: plc, scan 30: interval: SI(00) ON and SI(06)")


def test_a_changed_scan_and_rpi_are_those_of_the_run(runner: Runner, run: Run) -> None:
    outcome = run(example_jobs()["01_power_up"], scan=20_000, rpi=40_000)
    assert "150 scans of 20 ms" in outcome["told"]
    assert json.loads(runner.trace().partition("\n")[0])["scan_us"] == 20_000
