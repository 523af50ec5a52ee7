"""A single module handles the differences between operating systems."""

from __future__ import annotations

import ast
import errno
import os
import select
import signal
import socket
import subprocess
import sys
import textwrap
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from imports import shipped
from structured_text.output import system
from system_names import used

SYSTEM, GUARD = "structured_text.output.system", "structured_text.output.guard"


@pytest.mark.exhaustive
def test_no_other_module_uses_names_that_one_system_lacks(repository: Path) -> None:
    """Only two modules use names that are missing on one of the systems.

    Source: docs/explanation/architecture.md, the rooms.
    """
    found = {
        name: used(file.read_text(encoding="utf-8")) for name, file in shipped(repository).items()
    }
    assert found.pop(GUARD) > {"os.killpg", "signal.SIGCHLD"}, "a script that Windows does not run"
    assert found.pop(SYSTEM) > {"os.sched_setscheduler", "fcntl", "_ctypes.dlclose"}
    assert {name: names for name, names in found.items() if names} == {}


@pytest.mark.exhaustive
def test_no_other_module_asks_which_system_it_is(repository: Path) -> None:
    """Only two modules read sys.platform or os.name.

    Source: docs/explanation/architecture.md, the rooms.
    """
    asks = {
        name
        for name, file in shipped(repository).items()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and ast.unparse(node) in ("sys.platform", "os.name")
    }
    assert asks == {SYSTEM, GUARD}


@pytest.fixture
def piped_input() -> Iterator[int]:
    """Replace standard input by a pipe, and return the pipe's writing end."""
    kept = os.dup(0)
    reading, writing = os.pipe()
    os.dup2(reading, 0)
    os.close(reading)
    yield writing
    os.dup2(kept, 0)
    os.close(kept)


@pytest.mark.parametrize("kind", [system.DirectInput, system.RelayedInput])
def test_standard_input_is_waited_for_beside_sockets(
    piped_input: int, kind: type[system.DirectInput] | type[system.RelayedInput]
) -> None:
    given = kind()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        assert select.select([given, other], (), (), 0)[0] == []
        os.write(piped_input, b"one\ntwo")
        assert select.select([given, other], (), (), 30)[0] == [given]
        assert given.read() == b"one\ntwo"
        assert select.select([given, other], (), (), 0)[0] == []
    os.close(piped_input)
    assert select.select([given], (), (), 30)[0] == [given]
    assert given.read() == b""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_wait_once(number: signal.Signals) -> None:
    told = threading.Event()
    before = signal.getsignal(number)
    with system.told_to_end(told.set):
        signal.raise_signal(number)
        assert told.wait(30)
    assert signal.getsignal(number) is before


@pytest.fixture
def handlers() -> Iterator[None]:
    """Restore all signal handlers after the test."""
    before = {one: signal.getsignal(one) for one in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("handlers")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_signals_end_a_command_as_ctrl_c_does(number: signal.Signals) -> None:
    """SIGTERM and SIGHUP raise KeyboardInterrupt, as Ctrl-C does.

    Commands then remove their temporary folders.
    """
    for one in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(one, signal.SIG_DFL)
    came = system.end_as_by_ctrl_c()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(number)
    assert came == [number]
    signal.raise_signal(number)  # a second signal during the end has no effect


@pytest.mark.usefixtures("handlers")
def test_a_signal_that_is_ignored_stays_so() -> None:
    """A signal that was ignored at the start stays ignored, as SIGHUP after `nohup`."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    system.end_as_by_ctrl_c()
    signal.raise_signal(signal.SIGHUP)
    with system.told_to_end(pytest.fail):
        signal.raise_signal(signal.SIGHUP)


@pytest.mark.parametrize(
    ("platform", "number", "expected"),
    [
        ("linux", errno.EPIPE, True),
        ("linux", errno.EINVAL, False),
        ("win32", errno.EPIPE, True),
        ("win32", errno.EINVAL, True),
        ("win32", errno.ENOSPC, False),
    ],
)
def test_a_closed_pipe_is_not_a_full_disk(
    monkeypatch: pytest.MonkeyPatch, platform: str, number: int, expected: bool
) -> None:
    """A closed pipe is told from a full disk, also by the error "invalid argument" of Windows."""
    monkeypatch.setattr("sys.platform", platform)
    assert system.nobody_reads(OSError(number, "")) is expected


@pytest.mark.parametrize(
    ("environment", "platform", "expected"),
    [
        ({"XDG_CACHE_HOME": "/kept"}, "win32", "/kept"),
        ({"LOCALAPPDATA": "/local", "USERPROFILE": "/me"}, "win32", "/local"),
        ({"HOME": "/me"}, "darwin", "/me/Library/Caches"),
        ({"HOME": "/me"}, "linux", "/me/.cache"),
    ],
)
def test_the_cache_folder_follows_the_conventions_of_the_system(
    monkeypatch: pytest.MonkeyPatch, environment: dict[str, str], platform: str, expected: str
) -> None:
    """The cache folder follows the conventions of Linux, Windows and macOS.

    Source: XDG base directories; Windows known folders; Apple's file system guide.
    """
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.platform", platform)
    assert system.cache_root() == Path(expected)


copies = pytest.mark.skipif(not system.COPIES, reason="this system has no copies of a process")


def _in_new_python(code: str) -> tuple[int, str, str]:
    """Run code in a new process, and return its exit code and output.

    A fork would inherit locks.
    """
    given = (
        "import os, signal, subprocess, sys\nfrom structured_text.output.system import PipedCopy\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", given + textwrap.dedent(code)],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        env={key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"},
    )
    return done.returncode, done.stdout, done.stderr


@copies
def test_a_copy_of_the_process_uses_its_pipes_and_ends_with_its_input() -> None:
    """A copy of the process reads and writes its pipes, and ends when its input is closed.

    Source: structured_text.output.system.
    """
    code = """
        def work():
            for line in sys.stdin:
                print(line.upper(), end="", flush=True)
        copy = PipedCopy(work, "rcx_harness.a_name_that_is_long")
        copy.stdin.write("one\\n")
        copy.stdin.flush()
        print(copy.stdout.readline(), copy.poll(), os.getsid(copy.pid) == copy.pid)
        if sys.platform == "linux":
            assert open(f"/proc/{copy.pid}/comm").read() == "me_that_is_long\\n"
        copy.stdin.close()
        print(copy.wait(), copy.returncode, copy.stdout.read() == "")
        """
    assert _in_new_python(code) == (0, "ONE\n None True\n0 0 True\n", "")


@copies
def test_a_copy_of_the_process_does_not_inherit_open_files() -> None:
    """A copy of the process does not inherit open files.

    If a copy kept the end of a pipe open, the reader of the pipe would never end.
    """
    code = """
        end, other = os.pipe()
        def work():
            for number in (end, other, *range(3, 40)):
                try:
                    os.fstat(number)
                except OSError:
                    continue
                print("open:", number)
        copy = PipedCopy(work, "-")
        print(copy.stdout.read() + str(copy.wait()))
        """
    assert _in_new_python(code) == (0, "0\n", "")


@copies
@pytest.mark.parametrize(
    ("ends", "expected", "said"),
    [
        ("sys.exit(7)", 7, ""),
        ("sys.exit('why')", 1, "why\n"),
        ("sys.exit()", 0, ""),
        ("1 / 0", 1, "ZeroDivisionError: division by zero\n"),
        ("os.kill(os.getpid(), signal.SIGTERM)", -15, ""),
        ("print('kept', end='')", 0, ""),
    ],
)
def test_the_exit_code_of_a_copy_shows_how_it_ended(ends: str, expected: int, said: str) -> None:
    """The exit code of a copy tells how its work has ended.

    Source: documentation of `sys.exit`.
    """
    code = f"""
        print("not twice", end=" ")
        def work():
            {ends}
        copy = PipedCopy(work, "-")
        print(copy.stdout.read(), copy.wait())
        """
    kept = "kept" * ("kept" in ends)
    found = _in_new_python(code)
    assert found[:2] == (0, f"not twice {kept} {expected}\n")
    assert found[2].endswith(said)
    assert bool(found[2]) == bool(said)


@copies
def test_a_copy_that_does_not_end_is_killed() -> None:
    """A copy that does not end within the wait can be killed.

    Source: the documentation of `subprocess.Popen`.
    """
    code = """
        copy = PipedCopy(signal.pause, "-")
        try:
            copy.wait(0.01)
        except subprocess.TimeoutExpired:
            print("late")
        copy.kill()
        print(copy.wait())
        copy.kill()
        """
    assert _in_new_python(code) == (0, "late\n-9\n", "")
