"""`rcx campaign` and `rcx sweep` report violations by exit codes and files for `rcx run`."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest

from faulty_examples import changed_example
from feeder import feeder
from junit_files import junit_root
from rcx_harness.cli.app import main
from rcx_harness.verify.storm.campaign import Seed, storms

Captured = pytest.CaptureFixture[str]
_HERE = ["--engine", "builtin", "--workers", "0"]
_CAMPAIGN = ["campaign", "Feeder.st", "--properties", "campaign.toml", "--seeds", "6", *_HERE]
_SWEEP = ["sweep", "Feeder.st", "--properties", "campaign.toml", "--stimulus", "good.toml"]
_SWEEP += ["--for", "1s", "--hold", "200ms", *_HERE]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _replays(said: str) -> list[str]:
    return [line.strip() for line in said.splitlines() if line.startswith("  rcx run ")]


def test_a_cell_that_recovers_passes_and_seeds_run_once(here: Path, capsys: Captured) -> None:
    feeder(here)
    assert main(_CAMPAIGN) == 0
    said = capsys.readouterr().out
    assert "seeds 0 to 5: " in said
    assert "nothing failed" in said
    results = here / "out/campaign/results.jsonl"
    before = results.read_text()
    assert main([*_CAMPAIGN, "--seed-from", "2"]) == 0
    new = results.read_text().removeprefix(before)
    assert [json.loads(line)["key"] for line in new.splitlines()] == ["6", "7"]


@pytest.mark.exhaustive
def test_a_property_that_breaks_is_replayed_by_rcx_run(here: Path, capsys: Captured) -> None:
    """The feeder wrongly runs while its guard is open, so the replay only starts the feeder."""
    feeder(here, runs_open=True)
    assert main([*_CAMPAIGN, "--junit", "out/it.xml"]) == 1
    said = capsys.readouterr().out
    assert "always closed: " in said
    assert "written: out/it.xml" in said
    assert "needs: nothing but the start" in said
    replay = here / "out/campaign/always_closed-1.toml"
    text = replay.read_text()
    assert text.startswith("# rcx replay: always closed at ")
    assert text.count("\n") <= 5
    assert (here / "out/campaign/always_closed-1.svg").read_text().startswith("<svg ")
    command = next(one for one in _replays(said) if "always_closed-1" in one)
    cases = list(junit_root(here / "out/it.xml").iter("testcase"))
    assert [case.get("name") for case in cases] == [f"seed {seed}" for seed in range(6)]
    texts = [str(one.text) for case in cases for one in case.iter("failure")]
    assert any(f"replay: {command}" in text for text in texts)
    assert main(command.split()[1:]) == 1
    assert "expect: NOT (Main.Running AND NOT Main.Closed) does not hold" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_a_cell_that_does_not_recover_is_found(here: Path, capsys: Captured) -> None:
    feeder(here)
    assert main(_CAMPAIGN) == 0
    feeder(here, latches=True)
    capsys.readouterr()
    assert main(_CAMPAIGN) == 1
    said = capsys.readouterr().out
    assert "results of other files or options; all is run anew" in said
    assert "needs: link_down" in said
    for command in _replays(said):
        assert main(command.split()[1:]) == 1


@pytest.mark.exhaustive
def test_a_file_of_the_users_is_not_written_over(here: Path, capsys: Captured) -> None:
    feeder(here, runs_open=True)
    (here / "out/campaign").mkdir(parents=True)
    mine = here / "out/campaign/always_closed-1.toml"
    mine.write_text("mine = 1\n")
    assert main(_CAMPAIGN) == 2
    assert "already exists and was not written by rcx" in capsys.readouterr().err
    assert mine.read_text() == "mine = 1\n"


@pytest.mark.parametrize(
    ("demands", "message"),
    [
        ('[[always]]\nthat = "Main.Runing"\n', "did you mean Running"),
        ("[[always]]\nthat = 3\n", "[[always]] 1: that is not a text"),
        ('[[eventually]]\nthat = "Main.Go"\n', "[[eventually]] 1: within is missing"),
        ('[operator]\nbuttons = ["Main.Goo"]\n', "rcx: campaign.toml:2: [operator]: "),
        ('[operator]\nbuttons = ["Main.Goo"]\n', "did you mean Go"),
        (
            '[operator]\nbuttons = ["Main.Speed"]\n',
            "campaign.toml:2: [operator]: Main.Speed is not a BOOL",
        ),
        ('[operator]\nvalues = { "Main.Speed" = [40000] }\n', "40000"),
        ('[faults]\nonly = ["link_dwn"]\n', "did you mean link_down"),
        ('[recover]\nwhen = "Main.Running"\n', "[recover]: within is missing"),
        ('[recover]\nsteps = [ { pres = "Main.Go" } ]\n', "unknown key 'pres'"),
        ('[recover]\nsteps = [ { press = "Main.Goo" } ]\n', "rcx: campaign.toml: [recover]: "),
        ('length = "0s"\n', "length is 0"),
        ("[oprator]\n", "did you mean operator"),
    ],
)
def test_impossible_properties_are_reported_in_one_line(
    here: Path, capsys: Captured, demands: str, message: str
) -> None:
    feeder(here)
    (here / "campaign.toml").write_text(demands)
    assert main(_CAMPAIGN) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("words", [_CAMPAIGN, _SWEEP])
@pytest.mark.parametrize(
    "entry", ['set = { "Main.Goo" = true }', 'set = { "Main.Goo" = 7 }', 'expect = "Main.Goo"']
)
def test_an_unknown_variable_of_a_good_run_is_named_with_its_line(
    here: Path, capsys: Captured, words: list[str], entry: str
) -> None:
    feeder(here)
    (here / "good.toml").write_text(f'[[at]]\ntime = "1s"\n{entry}\n')
    (here / "campaign.toml").write_text("")
    assert main([*words, *(["--stimulus", "good.toml"] if words is _CAMPAIGN else [])]) == 2
    said = capsys.readouterr().err
    assert said.splitlines()[-1].startswith("rcx: good.toml:1: ")


@pytest.mark.exhaustive
def test_properties_in_python_are_judged_by_campaign_and_run(here: Path, capsys: Captured) -> None:
    feeder(here, runs_open=True)
    (here / "mine.py").write_text(
        "import rcx_harness as rcx\n\n\n"
        "@rcx.always\ndef closed_while_running(cell):\n"
        '    return cell["Main.Closed"] or not cell["Main.Running"]\n\n\n'
        '@rcx.eventually(within="100ms", after=lambda cell: cell["Main.Go"])\n'
        "def go_is_answered(cell):\n"
        '    return cell["Main.Running"] or cell["Main.Broken"]\n'
    )
    text = (here / "campaign.toml").read_text()
    begin, end = text.index("[[always]]"), text.index("[recover]")
    (here / "campaign.toml").write_text(text[:begin] + text[end:])
    assert main([*_CAMPAIGN, "--properties", "mine.py"]) == 1
    said = capsys.readouterr().out
    assert "always closed while running: " in said
    command = _replays(said)[0]
    assert "--properties mine.py" in command
    assert main(command.split()[1:]) == 1
    assert "property: always closed while running" in capsys.readouterr().out


def test_an_unknown_variable_in_python_is_reported_with_its_line(
    here: Path, capsys: Captured
) -> None:
    feeder(here)
    (here / "mine.py").write_text(
        "import rcx_harness as rcx\n\n\n@rcx.always\ndef fed(cell):\n"
        '    return cell["Main.Feed"] >= 0\n'
    )
    assert main([*_CAMPAIGN, "--properties", "mine.py"]) == 2
    assert "mine.py:6: fed: " in (said := capsys.readouterr().err)
    assert "did you mean Fed" in said


@pytest.mark.exhaustive
def test_the_verdicts_do_not_depend_on_the_number_of_workers(here: Path) -> None:
    feeder(here, runs_open=True)
    results = []
    for workers in ("0", "2"):
        main([*_CAMPAIGN[:-1], workers, "--out", f"out/{workers}"])
        lines = (here / f"out/{workers}/results.jsonl").read_text().splitlines()
        results.append(sorted(lines[1:]))
    assert results[0] == results[1]


#: A property that kills one worker process in the middle of a run, but only once.
_ENDS_A_WORKER = """import multiprocessing, os, pathlib, signal

import rcx_harness as rcx


@rcx.always
def alive(cell):
    if multiprocessing.parent_process() is not None and cell.now_us > 1_000_000:
        try:
            pathlib.Path({mark!r}).unlink()
        except FileNotFoundError:
            return True
        os.kill(os.getpid(), signal.SIGKILL)
    return True
"""


@pytest.mark.exhaustive
def test_a_killed_worker_changes_no_result(here: Path, capsys: Captured) -> None:
    feeder(here, runs_open=True)
    mark = here / "mark"
    (here / "mine.py").write_text(_ENDS_A_WORKER.format(mark=str(mark)))
    command = [*_CAMPAIGN[:-6], "--seeds", "4", "--engine", "builtin", "--properties", "mine.py"]
    found = []
    for workers, killed in (("0", False), ("1", True), ("2", True)):
        out = f"out/{workers}"
        if killed:
            mark.touch()
        assert main([*command, "--workers", workers, "--out", out]) == 1
        assert not mark.exists()
        lines = (here / out / "results.jsonl").read_text().splitlines()
        said = capsys.readouterr().out.replace(out, "out")
        replays = [file.read_text() for file in sorted((here / out).glob("*.toml"))]
        found.append((sorted(lines[1:]), said, replays))
    assert found[0] == found[1] == found[2]
    assert len(found[0][0]) > 4, "seeds, and the classes of failing seeds"


@pytest.mark.parametrize("command", [_CAMPAIGN[:-2], _SWEEP[:-2]])
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--cluster", "tls://192.0.2.1:8786"], "needs --cluster-ca"),
        (["--cluster-key", "farm.key"], "--cluster-key needs --cluster"),
        (
            ["--cluster", "tcp://127.0.0.1:8786", "--workers", "2"],
            "--workers cannot be combined with",
        ),
    ],
)
def test_the_options_of_a_cluster_are_those_of_every_command(
    here: Path, capsys: Captured, command: list[str], options: list[str], message: str
) -> None:
    feeder(here)
    assert main([*command, *options]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.exhaustive
def test_a_late_answer_is_found_and_judged_by_run(here: Path, capsys: Captured) -> None:
    """A campaign finds that the feeder does not answer Go during a fault; `rcx run` confirms it."""
    feeder(here)
    late = (
        '[[eventually]]\nname = "go"\nafter = "Main.Go"\nthat = "Main.Running"\nwithin = "50ms"\n'
    )
    demands = (here / "campaign.toml").read_text()
    (here / "campaign.toml").write_text(demands.replace("[recover]", f"{late}[recover]"))
    assert main([*_CAMPAIGN, "--seeds", "12"]) == 1
    said = capsys.readouterr().out
    assert "eventually go: " in said
    command = next(one for one in _replays(said) if "eventually_go-1" in one)
    words = [*command.split()[1:], "--properties", "campaign.toml"]
    assert main(words) == 1
    assert "property: eventually go: Main.Running has not come within 50 ms" in (
        capsys.readouterr().out
    )


@pytest.mark.exhaustive
def test_an_interrupted_campaign_continues_with_the_saved_results(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    feeder(here)

    def three(*given: object) -> Iterator[tuple[int, Seed]]:
        yield from islice(storms(*given), 3)  # type: ignore[arg-type]
        raise KeyboardInterrupt

    module = sys.modules["rcx_harness.cli.campaign"]
    with monkeypatch.context() as patch:
        patch.setattr(module, "storms", three)
        assert main(_CAMPAIGN) == 130
    assert (
        "finished results are in out/campaign; the same call continues" in capsys.readouterr().out
    )
    results = here / "out/campaign/results.jsonl"
    before = results.read_text()
    keys = [json.loads(line)["key"] for line in before.splitlines()[1:]]
    assert keys[:3] == ["0", "1", "2"]
    assert main(_CAMPAIGN) == 0
    assert "seeds 0 to 5: " in capsys.readouterr().out
    new = results.read_text().removeprefix(before)
    rest = [json.loads(line)["key"] for line in new.splitlines()]
    assert sorted([*keys, *rest]) == list("012345")
    assert rest


# --- sweep ------------------------------------------------------------------------------------


@pytest.mark.exhaustive
def test_a_sweep_reports_the_scans_without_recovery(here: Path, capsys: Captured) -> None:
    """The sweep reports scans 35 to 95.

    Losses in these scans are detected while the feeder runs.
    """
    feeder(here, latches=True)
    sweep = [*_SWEEP, "--inject", "link_down,plc_overrun", "--every", "5", "--json", "out/it.json"]
    sweep += ["--junit", "out/it.xml"]
    assert main(sweep) == 1
    said = capsys.readouterr().out
    assert "20 moments of 1 s, 2 faults at each" in said
    told = json.loads((here / "out/it.json").read_text())
    assert told["inject"] == ["link_down", "plc_overrun"]
    (one,) = told["classes"]
    assert (one["inject"], one["kind"]) == ("link_down", "recovery")
    # The PLC detects a loss 100 ms after the last packet. If the loss begins after scan 30, it is
    # detected at 400 ms, in the scan of Go, and the feeder does not start. If the loss begins after
    # scan 35, it is detected while the feeder runs.
    assert one["scans"] == [[35, 95]]
    command = _replays(said)[0]
    cases = list(junit_root(here / "out/it.xml").iter("testcase"))
    assert len(cases) == 40
    failing = [case for case in cases if case.find("failure") is not None]
    names = [f"scan {scan} ({scan * 10} ms)" for scan in range(35, 100, 5)]
    assert [(case.get("classname"), case.get("name")) for case in failing] == [
        ("sweep.link_down", name) for name in names
    ]
    assert all(f"replay: {command}" in "".join(case.itertext()) for case in failing)
    assert main(command.split()[1:]) == 1
    assert main(sweep) == 1, "a known moment is not run again, and has the same result"


def test_a_sweep_of_a_cell_that_recovers_ends_with_0(here: Path, capsys: Captured) -> None:
    feeder(here)
    inject = "link_down,emergency_stop,power_cycle,plc_stop,Main.Closed=false,Main.Go=true"
    assert main([*_SWEEP, "--inject", inject, "--every", "10"]) == 0
    assert "10 moments of 1 s, 6 faults at each" in (said := capsys.readouterr().out)
    assert "the cell recovers from all of them" in said


@pytest.mark.exhaustive
def test_a_sweep_injects_at_each_of_several_controllers(here: Path, capsys: Captured) -> None:
    """The changed example 12 never resets robot 1, so only robot 1 does not recover."""
    changed_example(here, "12_two_robots", (("Reset := Reset1,", "Reset := FALSE,"),))
    demands = here / "campaign.toml"
    demands.write_text(demands.read_text().replace('within = "40s"', 'within = "6s"'))
    (here / "good.toml").write_text(
        'at = [\n  { time = "10ms", set = { "Main.CellSafe" = true } },\n'
        '  { time = "700ms", set = { "Main.Start1" = true, "Main.Start2" = true } },\n]\n'
    )
    robots = ["--robot", "robot1.toml", "--robot", "robot2.toml"]
    words = ["sweep", ".", *robots, *_SWEEP[2:], "--inject", "link_down", "--json", "it.json"]
    assert main([*words, "--for", "3s", "--every", "250"]) == 1
    said = capsys.readouterr().out
    told = json.loads((here / "it.json").read_text())
    assert told["inject"] == ["link_down@1", "link_down@2"]
    assert [(one["inject"], one["scans"]) for one in told["classes"]] == [
        ("link_down@1", [[250, 250]])
    ]
    assert "controller" not in (here / "out/sweep/link_down_1_recovery-1.toml").read_text()
    assert main(_replays(said)[0].split()[1:]) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--inject", "link_dwn"], "did you mean link_down"),
        (["--inject", "link_down@2"], "the cell has 1 controller(s)"),
        (["--inject", "link_down,link_down"], "has a name twice"),
        (["--inject", "Main.Goo=true"], "did you mean Go"),
        (["--inject", "Main.Go=3"], "the value is not true or false"),
        (["--inject", "auto_mode"], "'auto_mode' cannot have a duration"),
        (["--hold", "0s"], "injects nothing"),
        (["--link", "enip"], "--link enip is for rcx run"),
    ],
)
def test_a_sweep_refuses_impossible_options(
    here: Path, capsys: Captured, options: list[str], message: str
) -> None:
    feeder(here)
    assert main([*_SWEEP, *options]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.exhaustive
def test_a_sweep_needs_a_run_without_violations(here: Path, capsys: Captured) -> None:
    feeder(here, runs_open=True)
    good = (here / "good.toml").read_text().replace('"Main.Speed" = 7', '"Main.Closed" = false')
    (here / "good.toml").write_text(good)
    assert main([*_SWEEP, "--for", "2s", "--every", "10"]) == 2
    assert "without any fault: always closed at " in capsys.readouterr().err
