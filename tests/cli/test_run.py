"""`rcx run` prints its results, writes its outputs, and ends with the exit codes of its help."""

from __future__ import annotations

import inspect
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from progress_lines import without_progress
from rcx_harness.cell import EVENTS, Cell
from rcx_harness.cell.clock import Timing
from rcx_harness.cli.app import main
from rcx_harness.cli.run import RunOptions
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.trace import read_trace
from structured_text.projects.sources import st_files

Captured = pytest.CaptureFixture[str]
Run = Callable[..., int]


@pytest.fixture
def program(repository: Path) -> Path:
    return repository / "tests" / "cell" / "programs" / "RawArea.st"


@pytest.fixture
def run(program: Path, tmp_path: Path) -> Run:
    """Return a function that runs a program without blocks. The program writes the area itself."""
    lib = tmp_path / "lib"
    lib.mkdir()

    def run(*args: str) -> int:
        return main(["run", str(program), "--lib", str(lib), "--engine", "builtin", *args])

    return run


def test_a_run_without_a_violation_ends_with_0(run: Run, capsys: Captured) -> None:
    assert run("--for", "1s", "--scan", "20ms") == 0
    assert capsys.readouterr().out == (
        "1 s on the builtin engine: 50 scans, 200 controller cycles, no remote commands, "
        "no violations\n"
    )


@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX")
@pytest.mark.parametrize("options", [(), ("--realtime",)])
def test_a_killed_adapter_process_ends_the_run_with_1_and_one_line(
    run: Run, monkeypatch: pytest.MonkeyPatch, capsys: Captured, options: tuple[str, ...]
) -> None:
    made: list[Adapter] = []

    class Recorded(Adapter):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            made.append(self)

    def dying(cell: Cell, duration: Any) -> None:
        if cell.now_us:
            (adapter,) = made
            os.kill(adapter.pid, signal.SIGKILL)
        going_on(cell, duration)

    going_on = Cell.run
    monkeypatch.setattr(Cell, "run", dying)
    for user in ("enip.links", "cell.live"):
        monkeypatch.setattr(f"rcx_harness.{user}.Adapter", Recorded)
    assert run("--link", "enip", "--for", "60s", *options) == 1
    told = "the process of the EtherNet/IP adapter has ended by itself (killed by SIGKILL)"
    assert without_progress(capsys.readouterr().err) == f"rcx: {told}\n"


def test_a_run_with_a_violation_exits_with_1(run: Run, tmp_path: Path, capsys: Captured) -> None:
    stimulus = tmp_path / "s.toml"
    stimulus.write_text("[[at]]\ntime = '500ms'\nset = { 'Main.Bits0' = 65 }\n")
    assert run("--for", "600ms", "--stimulus", str(stimulus)) == 1
    out = capsys.readouterr().out
    assert "violation at 500 ms: plc, scan 50: interval: SI(00) ON and SI(06) ON in one scan" in out
    assert "2 violations" in out


def test_trace_chart_and_wave_are_written(run: Run, tmp_path: Path, capsys: Captured) -> None:
    out = tmp_path / "out"
    paths = [out / name for name in ("trace.jsonl", "chart.svg", "wave.vcd")]
    options = [
        f"--{kind}={path}" for kind, path in zip(("trace", "chart", "vcd"), paths, strict=True)
    ]
    assert run("--for", "300ms", "--watch", "Main.Scans", "--show", *options) == 0
    header, records = read_trace(paths[0])
    assert (header["scan_us"], header["engine"], header["link"]) == (10_000, "builtin", "direct")
    assert len(list(records)) == 30 + 60
    assert paths[1].read_text().startswith("<svg ")
    assert paths[2].read_text().startswith("$timescale 1 us $end")
    printed = capsys.readouterr().out
    assert "SO(01) CPU_OK status output" in printed
    assert printed.endswith(f"written: {paths[0]}, {paths[1]}, {paths[2]}\n")


def test_watched_variables_are_printed_at_the_end(run: Run, capsys: Captured) -> None:
    """After the run, the watched variables and their last values are printed."""
    assert run("--for", "300ms", "--watch", "Main.Bits?,Main.Scans", "--watch", "Main.Con*") == 0
    assert capsys.readouterr().out.splitlines()[:-1] == [
        "watched, at the end:",
        "  Main.Bits0 = 16#00",
        "  Main.Bits1 = 16#00",
        "  Main.Scans = 30",
        "  Main.Connected = TRUE",
    ]


def test_a_chart_can_be_true_to_scale(
    run: Run, tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    chart = tmp_path / "c.svg"
    monkeypatch.setenv("COLUMNS", "100")
    for scale, begins in (("time", ["0", "50", "100"]), ("200ms", ["0", "200"])):
        assert run("--for", "300ms", "--show", f"--scale={scale}", f"--chart={chart}") == 0
        heads = [one for one in capsys.readouterr().out.splitlines() if one.startswith("time")]
        assert [head.split()[2] for head in heads][: len(begins)] == begins
        assert chart.read_text().startswith("<svg ")
    assert run("--for", "300ms", "--show") == 0
    assert capsys.readouterr().out.split("\n")[0].split() == ["time", "[ms]", "0"], "events"


def test_positions_are_in_every_output(run: Run, tmp_path: Path, capsys: Captured) -> None:
    paths = {kind: tmp_path / kind for kind in ("trace", "chart", "vcd")}
    options = [f"--{kind}={path}" for kind, path in paths.items()]
    assert run("--for", "300ms", "--positions", "mm", "--show", *options) == 0
    assert "Position X [mm]" in capsys.readouterr().out
    assert '"positions":[0.0,0.0,0.0,0.0]}' in paths["trace"].read_text()
    assert "Position X [mm]" in paths["chart"].read_text()
    assert "Position_X_mm" in paths["vcd"].read_text()


def test_different_sizes_are_reported(run: Run, tmp_path: Path, capsys: Captured) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("size = 256\n")
    assert run("--for", "300ms", "--size", "48", "--robot", str(robot)) == 0
    assert "no connection: the areas of PLC and robot differ in size" in capsys.readouterr().out


def test_the_robot_takes_the_size_of_the_plc(run: Run, tmp_path: Path, capsys: Captured) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("boot_time = 10\n")
    assert run("--for", "300ms", "--size", "256", "--robot", str(robot)) == 0
    assert "no connection" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--for", "5"], "'5' is not a duration"),
        (["--for", "0s"], "a run of 0 s shows nothing"),
        (["--scan", "fast"], "'fast' is not a duration"),
        (["--size", "47"], "an area of 47 bytes does not exist"),
        (["--n", "480"], "the area at n = 480 needs 48 bytes"),
        (["--watch", "Main.Nothing"], "no member Nothing"),
        (["--watch", "Main.Scans,Main.Dta*"], "no variable matches Main.Dta*; did you mean Data"),
        (["--positions", "inch"], "positions cannot be in 'inch'; use pulses or mm"),
        (["--scale", "wide"], "--scale is 'wide'; use events, time, or at least 1ms, as 500ms"),
        (["--scale", "10us"], "--scale is '10us'"),
        (["--engine", "quick"], "no engine 'quick'"),
        (["--link", "wifi"], "unknown link 'wifi'"),
        (["--phases", "scan=1h"], "the phase of scan"),
        (["--robot", "/nowhere/robot.toml"], "/nowhere/robot.toml: cannot be read"),
        (["--stimulus", "/nowhere/s.toml"], "/nowhere/s.toml: cannot be read"),
        (["--lib", "/nowhere/lib"], "--lib /nowhere/lib is not a folder"),
        (["--trace", "/dev/null/t.jsonl"], "cannot be written"),
        (["--chart", "/dev/null/c.svg"], "cannot be written"),
        (["--vcd", "/dev/null/w.vcd"], "cannot be written"),
        (["--panel", "0"], "--panel needs a run in real time; add --link enip --realtime"),
        (["--panel", "70000", "--realtime"], "--panel 70000 is not a port"),
        (["--panel", "0", "--connect", "127.0.0.1"], "--panel is for a virtual controller"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(
    run: Run, capsys: Captured, args: list[str], message: str
) -> None:
    assert run("--for", "100ms", *args) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert printed.err.startswith("rcx: ")
    assert printed.err.count("\n") == 1


def test_an_unknown_option_is_exit_code_2(run: Run, capsys: Captured) -> None:
    assert run("--fast") == 2
    assert "--fast" in capsys.readouterr().err


def test_an_input_is_never_overwritten(run: Run, program: Path, capsys: Captured) -> None:
    before = program.read_bytes()
    assert run("--for", "100ms", "--trace", str(program)) == 2
    assert "would be overwritten, but it is an input" in capsys.readouterr().err
    assert program.read_bytes() == before


@pytest.mark.parametrize(
    ("kind", "name"),
    [("trace", "trace"), ("chart", "timing chart (SVG)"), ("vcd", "wave file (VCD)")],
)
def test_a_file_that_no_run_has_written_is_not_overwritten(
    run: Run, tmp_path: Path, capsys: Captured, kind: str, name: str
) -> None:
    file = tmp_path / "other.st"
    file.write_text("$ (* mine *)")
    others = {"trace", "chart", "vcd"} - {kind}
    unwritten = [f"--{one}={tmp_path / one}" for one in sorted(others)]
    assert run("--for", "100ms", f"--{kind}", str(file), *unwritten) == 2
    assert capsys.readouterr().err == (
        f"rcx: {file}: already exists and is not a {name}; nothing was written; "
        "name another file, or remove this one\n"
    )
    assert file.read_text() == "$ (* mine *)"
    assert not any((tmp_path / one).exists() for one in others)


def test_a_run_overwrites_its_own_outputs_and_empty_files(run: Run, tmp_path: Path) -> None:
    files = [tmp_path / kind for kind in ("trace", "chart", "vcd")]
    options = [f"--{file.name}={file}" for file in files]
    for file in files:
        file.touch()
    assert run("--for", "200ms", *options) == 0
    first = [file.read_bytes() for file in files]
    assert run("--for", "300ms", *options) == 0
    assert len(first[0]) < files[0].stat().st_size
    assert run("--for", "200ms", *options) == 0
    assert [file.read_bytes() for file in files] == first


def test_an_entry_after_the_end_is_reported(run: Run, tmp_path: Path, capsys: Captured) -> None:
    stimulus = tmp_path / "t.toml"
    stimulus.write_text("[[at]]\ntime = '50s'\nset = { 'Main.Data' = 1 }\n")
    assert run("--for", "100ms", "--stimulus", str(stimulus)) == 0
    told = f"1 entry of {stimulus} is at or after the end (0.1 s)"
    assert capsys.readouterr().out.splitlines()[0] == told


def test_files_of_other_tools_are_not_part_of_the_program(tmp_path: Path) -> None:
    """Folders such as .venv are ignored inside a program folder, but not above it."""
    folder = tmp_path / ".hidden" / "site-packages" / "cell"
    places = (".venv/lib/a.st", "site-packages/b.st", "__pycache__/c.st", ".#d.st", "plc/e.st")
    for place in (*places, "f.st"):
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).touch()
    assert st_files(folder) == [folder / "f.st", folder / "plc/e.st"]


def test_a_virtual_environment_is_ignored(program: Path, tmp_path: Path, capsys: Captured) -> None:
    inside = tmp_path / "cell" / ".venv"
    inside.mkdir(parents=True)
    (inside / "Wrong.st").write_text("PROGRAM")
    (tmp_path / "cell" / program.name).write_bytes(program.read_bytes())
    lib = tmp_path / "lib"
    lib.mkdir()
    assert main(["check", str(tmp_path / "cell"), "--lib", str(lib)]) == 0
    assert capsys.readouterr().out.startswith("1 file checked")


def test_the_help_names_both_defaults_of_the_time_out(
    capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert main(["run", "--help"]) == 0
    said = "Default: 4 RPI, at least 100ms; with --realtime 32 RPI, at least 320ms."
    assert said in capsys.readouterr().out
    for rpi, virtual_us, real_us in (("2ms", 100_000, 320_000), ("40ms", 160_000, 1_280_000)):
        assert Timing.make(rpi=rpi).timeout_us == virtual_us
        assert "timeout" not in RunOptions([], rpi=rpi).of_cell()
        real = RunOptions([], rpi=rpi, link="enip", realtime=True)
        assert real.of_cell()["timeout"] == real_us


def test_every_option_is_used_by_the_cell_or_by_the_run() -> None:
    """Each option is an argument of `Cell.build` with the same name, or is used by the run itself.

    Source: RunOptions.
    """
    of_cell = set(inspect.signature(Cell.build).parameters) - {"program", "keep", "through"}
    of_run = {"files", "duration", "realtime", "stimulus", "chart", "vcd", "scale", "show"}
    of_run |= {"view", "properties", "no_robot"}
    of_run |= {"yes", "input_instance", "output_instance", "config_instance", "config_data"}
    of_run |= {"address", "panel"}
    of_run |= {"coverage", "coverage_out", "coverage_library", "cover_fail_under"}
    assert {one.name for one in fields(RunOptions)} == of_cell | of_run
    given = RunOptions([Path("a.st")], m=[4], n=[], phases="scan=3ms, cycle=1ms", watch=["Main.X"])
    arguments = given.of_cell()
    assert arguments["m"] == [4]
    assert "n" not in arguments
    assert arguments["phases"] == {"scan": "3ms", "cycle": "1ms"}
    assert arguments["watch"] == ["Main.X"]


def test_two_outputs_cannot_have_the_same_file(run: Run, tmp_path: Path, capsys: Captured) -> None:
    file = str(tmp_path / "x")
    assert run("--for", "100ms", "--trace", file, "--vcd", file) == 2
    assert "is named for two outputs" in capsys.readouterr().err


def test_a_mistake_in_the_source_is_reported_with_file_and_line(
    tmp_path: Path, capsys: Captured
) -> None:
    file = tmp_path / "Wrong.st"
    file.write_text("PROGRAM Wrong\n  VAR\n    a : BOOL;\n  END_VAR\n  a := 5;\nEND_PROGRAM\n")
    assert main(["run", str(file), "--engine", "builtin"]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"rcx: {file}:5:")
    assert err.count("\n") == 1


def test_the_help_lists_the_events(capsys: Captured, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert main(["run", "--help"]) == 0
    out = capsys.readouterr().out
    for event in EVENTS:
        assert event in out


def test_the_command_is_installed_and_ends_without_a_traceback(repository: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "rcx_harness", "run", "none.st"],
                          capture_output=True, text=True, check=False, cwd=repository)  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "rcx: none.st: no such file\n"
    shown = subprocess.run([sys.executable, "-m", "rcx_harness", "--version"], capture_output=True,
                           text=True, check=True, cwd=repository)  # fmt: skip
    assert shown.stdout.startswith("rcx 0.")
