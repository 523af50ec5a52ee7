"""The commands run in Linux processes that simulate the behaviour of Python on Windows.

The simulation is in tests/support/as_windows/sitecustomize.py.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.cli.options import replacements
from serve_process import ServeProcess, own_addresses
from structured_text.engines.load import why_not
from structured_text.export import TARGETS
from windows import as_windows

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/fd").exists(), reason="which files are open is asked of /proc"
)

Rcx = Callable[..., "subprocess.CompletedProcess[str]"]

_RUN = ("--robot", "cell/robot.toml", "--stimulus", "cell/stimulus.toml", "--for", "2s")


@pytest.fixture(scope="module")
def windows(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return environment variables with which Python simulates its behaviour on Windows."""
    return as_windows(tmp_path_factory.mktemp("windows"))


@pytest.fixture
def rcx(tmp_path: Path, windows: dict[str, str]) -> Rcx:
    """Return a function that runs `rcx` with arguments, and checks that the exit code is 0."""

    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        done = subprocess.run([sys.executable, "-m", "rcx_harness", *arguments], cwd=tmp_path,
                              env=windows, capture_output=True, encoding="cp1252",
                              check=False)  # fmt: skip
        assert done.returncode == 0, f"{arguments}\n{done.stdout}\n{done.stderr}"
        return done

    return call


@pytest.mark.exhaustive
def test_a_new_project_passes_its_tests(rcx: Rcx, tmp_path: Path, windows: dict[str, str]) -> None:
    rcx("new", "cell")
    assert "no errors, no broken rule" in rcx("check", "cell/plc").stdout
    command = [sys.executable, "-m", "pytest", "-q", "--rcx-engine=builtin", "-pno:xdist"]
    done = subprocess.run([*command, "-pno:hypothesispytest", "-Wignore"], cwd=tmp_path / "cell",
                          env=windows, capture_output=True, encoding="cp1252",
                          check=False)  # fmt: skip
    assert "19 passed" in done.stdout, done.stdout + done.stderr


@pytest.mark.exhaustive
@pytest.mark.parametrize("engine", ["builtin", "matiec"])
def test_a_run_writes_the_same_bytes_and_prints_an_ascii_chart(
    rcx: Rcx, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, engine: str
) -> None:
    """The outputs are the same as on Linux.

    With matiec, a loaded library's file cannot be deleted.
    """
    if missing := why_not(engine):
        pytest.skip(missing)
    monkeypatch.chdir(tmp_path)
    assert main(["new", "cell"]) == 0
    options = ["run", "cell/plc", *_RUN, "--engine", engine, "--show"]
    for kind in ("there", "here"):
        written = [f"--trace={kind}/t.jsonl", f"--chart={kind}/c.svg", f"--vcd={kind}/w.vcd"]
        if kind == "here":
            assert main([*options, *written]) == 0
        else:
            printed = rcx(*options, *written).stdout
    assert printed.isascii()
    assert '/"""""' in printed
    for name in ("t.jsonl", "c.svg", "w.vcd"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


@pytest.mark.exhaustive
def test_every_export_is_the_same_byte_for_byte(
    tmp_path: Path, windows: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "cell"]) == 0
    options = ["--program", "cell/plc", "--needed", "--allow-missing", "-o"]
    here, there = (
        [["export", one, *options, f"{place}/{one}/rcx3"] for one in sorted(TARGETS)]
        for place in ("here", "there")
    )
    script = (
        f"from rcx_harness.cli.app import main\nfor one in {there!r}:\n    assert main(one) == 0\n"
    )
    subprocess.run([sys.executable, "-c", script], env=windows, check=True, capture_output=True)
    assert [main(one) for one in here] == [0] * len(TARGETS)
    assert _contents(tmp_path / "there") == _contents(tmp_path / "here") != {}


def _contents(folder: Path) -> dict[str, bytes]:
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


@pytest.mark.exhaustive
@pytest.mark.parametrize("network", [("--link", "enip"), ("--link", "enip", "--realtime")])
def test_a_run_over_real_ethernet_ip_connects(rcx: Rcx, network: tuple[str, ...]) -> None:
    rcx("new", "cell")
    said = rcx("run", "cell/plc", *_RUN[:-1], "500ms", "--engine", "builtin", *network).stdout
    assert "50 scans" in said
    assert "no connection" not in said


@pytest.mark.exhaustive
def test_a_served_controller_ends_with_ctrl_c(rcx: Rcx, windows: dict[str, str]) -> None:
    (address,) = own_addresses(1)
    with ServeProcess("--address", address, "--web", "0", environment=windows) as served:
        served.wait_for("Ctrl-C ends it")
        said = rcx("scan", address, "--write", "SI00=1", "--for", "50ms").stdout
        assert "SO(01)" in said
        served.interrupt()
        assert served.end() == (0, "")


@pytest.mark.exhaustive
def test_the_demo_and_an_import_are_written(rcx: Rcx, repository: Path, tmp_path: Path) -> None:
    rcx("demo", "-o", "demo")
    assert len(_contents(tmp_path / "demo")) == 4
    rcx("export", "twincat", "-o", "tc")
    rcx("import", "tc", "-o", "st")
    assert "FB_MovePtp.st" in _contents(tmp_path / "st")


@pytest.mark.exhaustive(
    but=["arguments0-ascii", "arguments0-cp1252", "arguments2-cp1252", "arguments2-ascii"]
)
@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
@pytest.mark.parametrize(
    "arguments",
    [
        ("--help",),
        ("export", "--help"),
        ("decode", "16#0001", "16#0013"),
        ("new", "Zelle ü ●", "--name", "Zelle"),
        ("demo", "-o", "Zelle ü ●"),
    ],
)
def test_output_can_be_printed_in_every_encoding(
    tmp_path: Path, arguments: tuple[str, ...], encoding: str
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "rcx_harness", *arguments],
        cwd=tmp_path,
        env=dict(os.environ) | {"PYTHONIOENCODING": encoding},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, b"Error" in done.stderr) == (0, False)
    assert done.stdout.decode(encoding)
    if "Zelle ü ●" in arguments:
        assert b"\\u25cf" in done.stdout


@pytest.mark.exhaustive
def test_files_with_crlf_give_the_same_results_as_files_with_lf(tmp_path: Path) -> None:
    for ending in (b"\n", b"\r\n"):
        folder = tmp_path / ("unix" if ending == b"\n" else "dos")
        assert main(["new", str(folder / "cell")]) == 0
        for file in filter(Path.is_file, (folder / "cell").rglob("*")):
            file.write_bytes(file.read_bytes().replace(b"\n", ending))
        named = [f"--robot={folder}/cell/robot.toml", f"--stimulus={folder}/cell/stimulus.toml"]
        trace = f"--trace={folder}/t.jsonl"
        assert main(["run", f"{folder}/cell/plc", *named, "--for", "1s", trace]) == 0
        options = ["--program", f"{folder}/cell/plc", "-o", f"{folder}/rcx3.st"]
        assert main(["export", "st", *options]) == 0
    for name in ("t.jsonl", "rcx3.st"):
        assert (tmp_path / "unix" / name).read_bytes() == (tmp_path / "dos" / name).read_bytes()


def test_a_drive_letter_is_a_part_of_the_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    r"""The colon in `--replace Main=C:\cell\Main.st` is a part of the path."""
    monkeypatch.chdir(tmp_path)
    name = r"C:\cell\Main.st"
    Path(name).write_text("", encoding="utf-8")
    assert replacements([f"Main={name}"]) == {"Main": Path(name)}
