"""`rcx run` as a user types it: what it prints, what it writes, how it ends."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness.cell import EVENTS
from rcx_harness.cli import main
from rcx_harness.trace import read_trace

Captured = pytest.CaptureFixture[str]
Run = Callable[..., int]


@pytest.fixture
def program(repository: Path) -> Path:
    return repository / "tests" / "cell" / "programs" / "RawArea.st"


@pytest.fixture
def run(program: Path, tmp_path: Path) -> Run:
    """Runs the program that writes the area itself, without a library."""
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


def test_a_run_with_a_violation_ends_with_1_and_tells_it(
    run: Run, tmp_path: Path, capsys: Captured
) -> None:
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


def test_sizes_that_differ_are_told(run: Run, tmp_path: Path, capsys: Captured) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("size = 256\n")
    assert run("--for", "300ms", "--size", "48", "--robot", str(robot)) == 0
    assert "no connection: the areas of PLC and robot differ in size" in capsys.readouterr().out


def test_the_robot_takes_the_size_of_the_plc_if_its_file_says_none(
    run: Run, tmp_path: Path, capsys: Captured
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("boot_time = 10\n")
    assert run("--for", "300ms", "--size", "256", "--robot", str(robot)) == 0
    assert "no connection" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--for", "5"], "not a duration: '5'"),
        (["--for", "0s"], "a run of 0 s shows nothing"),
        (["--scan", "fast"], "not a duration: 'fast'"),
        (["--size", "47"], "an area of 47 bytes does not exist"),
        (["--n", "480"], "the area at n = 480 needs 48 bytes"),
        (["--watch", "Main.Nothing"], "no member Nothing"),
        (["--engine", "quick"], "no engine 'quick'"),
        (["--link", "wifi"], "unknown link 'wifi'"),
        (["--phases", "scan=1h"], "the phase of scan"),
        (["--robot", "/nowhere/robot.toml"], "/nowhere/robot.toml: cannot read it"),
        (["--stimulus", "/nowhere/s.toml"], "/nowhere/s.toml: cannot read it"),
        (["--lib", "/nowhere/lib"], "/nowhere/lib: no such folder"),
        (["--trace", "/dev/null/t.jsonl"], "cannot be written"),
        (["--chart", "/dev/null/c.svg"], "cannot be written"),
        (["--vcd", "/dev/null/w.vcd"], "cannot be written"),
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


def test_a_missing_program_is_told(capsys: Captured) -> None:
    assert main(["run", "/nowhere/p.st"]) == 2
    assert capsys.readouterr().err == "rcx: /nowhere/p.st: no such file\n"


def test_an_input_is_never_overwritten(run: Run, program: Path, capsys: Captured) -> None:
    before = program.read_bytes()
    assert run("--for", "100ms", "--trace", str(program)) == 2
    assert "would be overwritten, but it is an input" in capsys.readouterr().err
    assert program.read_bytes() == before


def test_two_outputs_cannot_be_one_file(run: Run, tmp_path: Path, capsys: Captured) -> None:
    file = str(tmp_path / "x")
    assert run("--for", "100ms", "--trace", file, "--vcd", file) == 2
    assert "is named for two outputs" in capsys.readouterr().err


def test_an_error_in_the_source_is_told_with_file_and_line(
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
    done = subprocess.run(
        [sys.executable, "-m", "rcx_harness", "run", "none.st"],
        capture_output=True,
        text=True,
        check=False,
        cwd=repository,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "rcx: none.st: no such file\n"
    shown = subprocess.run(
        [sys.executable, "-m", "rcx_harness", "--version"],
        capture_output=True,
        text=True,
        check=True,
        cwd=repository,
    )
    assert shown.stdout.startswith("rcx 0.")
