"""A command ends with the right exit code if a stream is closed, or after SIGTERM or an error."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rcx_harness.cli.own_error import report

_NOT_ON_WINDOWS = pytest.mark.skipif(sys.platform == "win32", reason="it has no such streams")


def _ended(
    code: str, *words: str, closed: tuple[int, ...] = (), **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run Python code in a new process in which the given standard streams are closed."""

    def close() -> None:
        for number in closed:
            os.close(number)

    return subprocess.run([sys.executable, "-c", code, *words], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=False,
                          preexec_fn=close if closed else None,
                          env={**os.environ, **environment})  # fmt: skip


_COMMAND = "import sys; from rcx_harness.cli.start import main; sys.exit(main())"


@_NOT_ON_WINDOWS
@pytest.mark.parametrize("closed", [(1,), (0, 1, 2)])
def test_a_command_works_with_closed_streams(tmp_path: Path, closed: tuple[int, ...]) -> None:
    """If a standard stream is closed, its output is discarded, not written into another file.

    Source: open(2): the lowest number that is free.
    """
    file = tmp_path / "it.eds"
    done = _ended(_COMMAND, "eds", str(file), closed=closed)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    text = file.read_text()
    assert text.startswith("$")
    assert "written:" not in text


@_NOT_ON_WINDOWS
def test_with_standard_error_closed_the_exit_code_is_still_right() -> None:
    """If standard error is closed, nothing is printed, also not on standard output.

    Source: the documentation of print.
    """
    done = _ended(_COMMAND, "encode", "Nothing", closed=(2,))
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "")


@_NOT_ON_WINDOWS
@pytest.mark.exhaustive(but=["words0"])
@pytest.mark.parametrize("words", [("run", "--help"), ("eds",), ("encode", "MovePtp")])
def test_a_command_ends_quietly_if_its_reader_has_ended(words: tuple[str, ...]) -> None:
    """If the reader of a pipe has ended, the exit code is 141. Exit code 1 means a failed check.

    Source: the exit code of a shell for a process that SIGPIPE has ended, 128 + 13.
    """
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run([sys.executable, "-c", _COMMAND, *words], stdin=subprocess.DEVNULL,
                              stdout=writer, stderr=subprocess.PIPE, check=False)  # fmt: skip
    finally:
        os.close(writer)
    assert (done.returncode, done.stderr) == (141, b"")


#: A script that runs `rcx`. It sends SIGTERM to itself when the named function begins.
_TERMINATED = """
import os, signal, sys
where = sys.argv.pop(1)
def called(frame, event, _):
    if event == "call" and frame.f_code.co_qualname == where:
        sys.setprofile(None)
        os.kill(os.getpid(), signal.SIGTERM)
sys.setprofile(called)
from rcx_harness.cli.start import main
sys.exit(main())
"""


@pytest.mark.exhaustive
@_NOT_ON_WINDOWS
@pytest.mark.skipif(sys.version_info < (3, 11), reason="code objects have no qualified name")
def test_sigterm_leaves_no_temporary_folder(repository: Path, tmp_path: Path) -> None:
    """After SIGTERM, a campaign removes the temporary folder with its copy of the program.

    Source: signal(7); shells give 128 and the number of the signal.
    """
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "L.st").write_text("TYPE\n  L : INT;\nEND_TYPE\n")
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    program = repository / "tests" / "cell" / "programs" / "RawArea.st"
    words = ["campaign", str(program), "--lib", str(tmp_path / "lib"), "--workers", "0"]
    words += ["--out", str(tmp_path / "out"), "--engine", "builtin"]
    done = _ended(_TERMINATED, "Compiled.__init__", *words, TMPDIR=str(temporary), RCX_CACHE="off")
    assert (done.returncode, done.stderr) == (143, "")
    assert [path.name for path in temporary.iterdir()] == []


#: A script in which `rcx` fails with an internal error; the given expression is its cause.
_BROKEN = """
import sys
import rcx_harness.cli.app
def broken():
    cause = {}
    raise RuntimeError("of our own") from cause
rcx_harness.cli.app.main = broken
from rcx_harness.cli.start import main
sys.exit(main())
"""


def test_an_internal_error_is_one_line_and_exit_code_3(tmp_path: Path) -> None:
    """An internal error gives one line that names a file with the traceback.

    Source: CONTRIBUTING.md, exit codes: 3 means an internal error, 1 means that a rule is broken.
    """
    done = _ended(_BROKEN.format("ValueError('the cause')"), TMPDIR=str(tmp_path))
    (file,) = tmp_path.iterdir()
    assert done.returncode == 3
    assert done.stderr == (
        f"rcx: this is an error of rcx itself: RuntimeError: of our own; please report it with "
        f"{file}\n"
    )
    assert "ValueError: the cause" in file.read_text()


def test_ctrl_c_inside_another_error_ends_with_130(tmp_path: Path) -> None:
    """A KeyboardInterrupt that is the cause of a RuntimeError ends the command with 130.

    Before Python 3.12, an exception in __set_name__ becomes a RuntimeError.
    """
    done = _ended(_BROKEN.format("KeyboardInterrupt()"), TMPDIR=str(tmp_path))
    assert (done.returncode, done.stderr) == (130, "rcx: interrupted\n")


def test_the_traceback_is_shown_if_no_file_can_be_made(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """If no temporary file can be written, the traceback is printed. Source: tempfile.mkstemp."""

    def refuse(**options: object) -> None:
        raise OSError("no folder")

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    try:
        raise ValueError("one\ntwo")
    except ValueError as error:
        report(error)
    said = capsys.readouterr().err
    assert said.startswith("Traceback (most recent call last):")
    assert said.endswith(
        "rcx: this is an error of rcx itself: ValueError: one; "
        "please report it with the lines above\n"
    )


def test_nothing_is_imported_before_ctrl_c_is_handled() -> None:
    """`cli.start` imports nothing else, because Ctrl-C during an import would show a traceback."""
    code = "import sys; before = set(sys.modules); import rcx_harness.cli.start; "
    done = _ended(f"{code}print(*sorted(set(sys.modules) - before - {{'gc', '__future__'}}))")
    assert done.stdout.split() == ["rcx_harness", "rcx_harness.cli", "rcx_harness.cli.start"]
