"""External programs end with their parent, and their end is reported."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO

import pytest

from imports import shipped
from structured_text.output.programs import Program, run

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the programs are shell scripts")

_LONGEST = 60
#: A shell script that prints its process number and runs for ever with its output open.
_ENDLESS = "echo $$; exec sleep 1000"


def test_its_output_and_exit_code_are_those_of_the_program(tmp_path: Path) -> None:
    done = run(["sh", "-c", "pwd; echo no >&2; exit 7"], cwd=tmp_path)
    assert (done.returncode, done.stderr) == (7, b"no\n")
    assert Path(done.stdout.decode().strip()).samefile(tmp_path)


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGKILL, signal.SIGINT])
def test_a_program_that_a_signal_ends_has_a_negative_return_code(number: signal.Signals) -> None:
    """Source: subprocess: a negative return code is the signal's."""
    assert run(["sh", "-c", f"kill -{int(number)} $$"]).returncode == -number


@pytest.mark.parametrize("name", ["no/such/program", "file"])
def test_a_program_that_cannot_be_started_raises(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("no program")
    with pytest.raises(OSError, match=name):
        run([f"./{name}"])


def test_children_of_a_program_are_killed_with_it() -> None:
    with Program(["sh", "-c", f"{_ENDLESS} & wait"], stdout=subprocess.PIPE) as program:
        assert program.stdout is not None
        program.stdout.readline()
        program.kill()
        _assert_closed(program.stdout)
    assert program.returncode == -signal.SIGKILL


#: A Python program that starts another program, and runs until its standard input closes.
_PARENT = f"""
import subprocess, sys
import select
from structured_text.output.programs import Program
Program(["sh", "-c", {_ENDLESS!r}])
# A signal just before a blocking read would be seen only after it.
while not select.select([sys.stdin], [], [], 0.1)[0]:
    pass
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_program_ends_with_the_process_that_started_it(number: signal.Signals) -> None:
    """Program and parent hold the same pipe open, so it closes only when both have ended.

    Source: a defect report: a child process never outlives its parent, however the parent ends.
    """
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", _PARENT], stdin=pipe, stdout=pipe) as parent:
        assert parent.stdout is not None
        parent.stdout.readline()
        parent.send_signal(number)
        _assert_closed(parent.stdout)


def _assert_closed(stream: IO[bytes]) -> None:
    """Check that no process has the writing end of the pipe open. Zombies do not count."""
    assert select.select([stream], [], [], _LONGEST)[0], "another process still has the pipe open"
    assert stream.read() == b""


#: Modules that start processes of this package, which end when their standard input closes.
_OWN = {
    "rcx_harness.enip.child",
    "rcx_harness.serve.host",
    "structured_text.output.system",
    "structured_text.output.guard",
}
_STARTS = re.compile(
    r"(subprocess\.(run|call|check_\w+|Popen\()|(?<!\w)Popen\(|create_subprocess|"
    r"os\.(fork|system|popen|spawn|exec|posix_spawn)\w*\()"
)


def test_no_other_module_starts_processes(repository: Path) -> None:
    """Source: docs/explanation/architecture.md: one place that starts programs of others."""
    starting = {
        name
        for name, file in shipped(repository).items()
        if _STARTS.search(file.read_text(encoding="utf-8"))
    }
    assert starting == _OWN
