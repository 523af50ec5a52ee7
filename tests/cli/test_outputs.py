"""If an output cannot be written completely, the old file stays, and one line is printed."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
from io import FileIO
from pathlib import Path

import pytest

from progress_lines import without_progress
from rcx_harness.cli.app import main
from rcx_harness.enip.target.adapter import Adapter
from serve_process import own_addresses
from structured_text.errors import InputError
from structured_text.output.files import NewFiles, OutputFile, replace_files

_FULL = Path("/dev/full")
_KINDS = ("trace", "vcd", "chart")


def _run(repository: Path, tmp_path: Path, *options: str) -> list[str]:
    program = repository / "tests" / "cell" / "programs" / "RawArea.st"
    (tmp_path / "lib").mkdir(exist_ok=True)
    given = ["run", str(program), "--lib", str(tmp_path / "lib"), "--engine", "builtin"]
    return [*given, "--for", "5s", *options]


def _limit() -> None:
    """Limit each file to 1,000 bytes, which simulates a full disk."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000, 1_000))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def _with_a_full_disk(*command: str) -> subprocess.CompletedProcess[str]:
    """Run `rcx` in a process with a simulated full disk.

    The process writes no compiled Python code. Python would not notice that such a file is cut off,
    and later tests that import the module would fail.
    """
    return subprocess.run(
        [sys.executable, "-m", "rcx_harness", *command],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=_limit,
        env={**os.environ, "RCX_CACHE": "off", "PYTHONDONTWRITEBYTECODE": "1"},
    )


@pytest.mark.skipif(not _FULL.exists(), reason="no /dev/full")
@pytest.mark.parametrize("kind", _KINDS)
def test_a_full_disk_is_reported_in_one_line(
    repository: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    assert main(_run(repository, tmp_path, f"--{kind}", str(_FULL))) == 2
    said = "rcx: /dev/full: cannot be written: No space left on device\n"
    assert without_progress(capsys.readouterr().err) == said


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", _KINDS)
def test_a_full_disk_leaves_the_old_file_only(repository: Path, tmp_path: Path, kind: str) -> None:
    file = tmp_path / "out" / "old"
    assert main(_run(repository, tmp_path, f"--{kind}", str(file))) == 0
    before = file.read_bytes()
    assert len(before) > 1_000
    for name in ("old", "new"):
        there = tmp_path / "out" / name
        command = _run(repository, tmp_path, f"--{kind}", str(there))
        done = _with_a_full_disk(*command)
        said = f"rcx: {there}: cannot be written: File too large\n"
        assert (done.returncode, without_progress(done.stderr)) == (2, said)
    assert file.read_bytes() == before
    assert [one.name for one in file.parent.iterdir()] == ["old"]


def test_a_full_disk_leaves_nothing_of_a_new_cell(tmp_path: Path) -> None:
    done = _with_a_full_disk("new", str(tmp_path / "a" / "cell"))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.endswith(": cannot be written: File too large\n")
    assert list(tmp_path.iterdir()) == []


def test_an_old_file_is_replaced_only_by_a_complete_one(tmp_path: Path) -> None:
    place, link = tmp_path / "a", tmp_path / "link"
    place.write_text("old")
    place.chmod(0o640)
    link.symlink_to(place)
    file = OutputFile(link)
    file.write("new")
    assert place.read_text() == "old"
    file.close()
    assert (place.read_text(), place.stat().st_mode & 0o777) == ("new", 0o640)
    assert link.is_symlink()
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a", "link"]


def test_a_new_file_exists_at_once_unless_it_must_be_complete(tmp_path: Path) -> None:
    grows, whole = OutputFile(tmp_path / "a"), OutputFile(tmp_path / "b", whole=True)
    assert [one.exists() for one in (tmp_path / "a", tmp_path / "b")] == [True, False]
    for file in (grows, whole):
        file.write("new")
        file.close()
        file.discard()  # after close, discard has no effect
    assert [(tmp_path / name).read_text() for name in "ab"] == ["new", "new"]


def test_a_failing_close_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If closing an output fails, no new file remains.

    Reasons are a folder with the same name, or a network drive that reports only at close that it
    is full.
    """
    place = tmp_path / "a"
    place.write_text("old")
    file = OutputFile(place)
    place.unlink()
    place.mkdir()
    with pytest.raises(InputError, match="a: cannot be written: Is a directory"):
        file.close()
    assert list(tmp_path.iterdir()) == [place]

    class Full(FileIO):
        def close(self) -> None:
            if not self.closed:
                super().close()
                raise OSError(errno.EDQUOT, "Disk quota exceeded")

    other = tmp_path / "b"
    with monkeypatch.context() as full:
        full.setattr(Path, "open", lambda path, mode: Full(path, mode))
        file = OutputFile(other)
    assert other.exists()
    with pytest.raises(InputError, match="b: cannot be written: Disk quota exceeded"):
        file.close()
    assert list(tmp_path.iterdir()) == [place]


def test_a_pipe_is_written_and_stays(tmp_path: Path) -> None:
    """An output can be a named pipe, which stays. A user may write `--trace /dev/stdout`."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        for end in ("close", "discard"):
            file = OutputFile(pipe, whole=True)
            file.write(end)
            getattr(file, end)()
            assert os.read(reader, 100) == end.encode()
            assert pipe.is_fifo()
    finally:
        os.close(reader)
    assert list(tmp_path.iterdir()) == [pipe]


def test_several_files_are_replaced_together(tmp_path: Path) -> None:
    """If one of several files cannot be written, no file and no new folder remains."""
    old, new = tmp_path / "old", tmp_path / "a" / "b" / "new"
    old.write_text("old")
    with pytest.raises(InputError, match=r"^/dev/full/c: cannot be written: Not a directory$"):
        replace_files({old: b"x", new: b"x", Path("/dev/full/c"): b"x"})
    assert old.read_text() == "old"
    assert list(tmp_path.iterdir()) == [old]
    replace_files({old: b"x", new: b"y"})
    assert (old.read_text(), new.read_text()) == ("x", "y")
    assert [one.name for one in new.parent.iterdir()] == ["new"]


def test_after_an_error_no_further_error_is_raised(tmp_path: Path) -> None:
    if not _FULL.exists():
        pytest.skip("no /dev/full")
    file = OutputFile(_FULL)
    file.write("x")
    with pytest.raises(InputError, match="No space left on device"):
        file.close()
    file.write("x")
    file.close()


def _ends_in_one_line(command: list[str]) -> None:
    with _FULL.open("w") as full:
        done = subprocess.run([sys.executable, "-m", "rcx_harness", *command], stdout=full,
                              stderr=subprocess.PIPE, text=True, check=False)  # fmt: skip
    assert (done.returncode, done.stderr) == (
        2,
        "rcx: standard output cannot be written: No space left on device\n",
    )


@pytest.mark.skipif(not _FULL.exists(), reason="no /dev/full")
@pytest.mark.parametrize("command", [["eds"], ["encode", "MovePtp"]])
def test_standard_output_on_a_full_disk_is_reported_in_one_line(command: list[str]) -> None:
    _ends_in_one_line(command)


@pytest.mark.exhaustive
@pytest.mark.skipif(not _FULL.exists(), reason="no /dev/full")
def test_scan_and_serve_on_a_full_disk_report_one_line() -> None:
    (address,) = own_addresses(1)
    with Adapter(cyclic=0) as adapter:
        _ends_in_one_line(["scan", "127.0.0.1", "--port", str(adapter.address[1]), "--for", "0s"])
        _ends_in_one_line(["serve", "--address", address])


@pytest.mark.exhaustive(but=["eds-/proc/none/below", "new-/dev/full", "eds-/dev/full/below",
                             "new-/proc/none/below", "new-/dev/full/below",
                             "eds-/dev/full"])  # fmt: skip
@pytest.mark.parametrize("place", ["/dev/full", "/dev/full/below", "/proc/none/below"])
@pytest.mark.parametrize(
    "command",
    [["eds", "--force", "{}"], ["export", "st", "--force", "--out", "{}"], ["new", "{}"]],
    ids=lambda command: command[0],
)
def test_an_unwritable_path_is_reported_in_one_line(
    capsys: pytest.CaptureFixture[str], command: list[str], place: str
) -> None:
    if not _FULL.exists():
        pytest.skip("no /dev/full")
    assert main([one.format(place) for one in command]) == 2
    said = capsys.readouterr().err
    assert said.startswith("rcx: /")
    assert said.count("\n") == 1


#: A script that runs `rcx`. It sends Ctrl-C to itself when the named module is imported, or when
#: the named function begins.
_INTERRUPTED = """
import os, signal, sys
where = sys.argv.pop(1)
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == where:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder())
def called(frame, event, _):
    if event == "call" and frame.f_code.co_qualname == where:
        sys.setprofile(None)
        os.kill(os.getpid(), signal.SIGINT)
modules = ("rcx_harness", "structured_text", "typer", "lark", "vcd")
if where[0].isupper() or not where.startswith(modules):
    sys.setprofile(called)
from rcx_harness.cli.start import main
sys.exit(main())
"""


@pytest.mark.exhaustive(but=["typer", "rcx_harness.cli.app", "rcx_harness.cell.cell"])
@pytest.mark.parametrize(
    "moment",
    [
        "typer",
        "rcx_harness.cli.app",
        "rcx_harness.cell.cell",
        "structured_text.engines.builtin.compile",
        "lark",
        "source_files",
        "parse_text",
        "Writer.write",
        "Cell.build",
        "Bench.run",
        "Trace.close",
        "_print_outcome",
    ],
)
@pytest.mark.skipif(sys.version_info < (3, 11), reason="code objects have no qualified name")
def test_ctrl_c_prints_one_line_at_any_moment(
    repository: Path, tmp_path: Path, moment: str
) -> None:
    command = _run(repository, tmp_path, "--trace", str(tmp_path / "t.jsonl"), "--for", "50ms")
    done = subprocess.run(
        [sys.executable, "-c", _INTERRUPTED, moment, *command],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "RCX_CACHE": "off"},
    )
    progress = ("compiling", "running")  # lines with these words appear only on a slow computer
    said = [line for line in done.stderr.splitlines() if not line.startswith(progress)]
    assert (done.returncode, said) == (130, ["rcx: interrupted"])


def test_a_library_without_the_block_is_reported_instead_of_the_program(
    repository: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = repository / "plc" / "examples" / "01_power_up"
    for command in ("check", "run"):
        assert main([command, str(program), "--lib", str(tmp_path)]) == 2
        said = capsys.readouterr().err
        assert f"--lib {tmp_path} does not declare it" in said
        assert "look at the spelling" not in said


@pytest.mark.parametrize("command", ["check", "run"])
def test_an_unknown_block_is_reported_at_its_line_of_the_program(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    (tmp_path / "lib").mkdir()
    program = tmp_path / "Mine.st"
    program.write_text("PROGRAM Mine\nVAR\n  a : FB_Nonsense;\nEND_VAR\n  a();\nEND_PROGRAM\n")
    for lib in ([], ["--lib", str(tmp_path / "lib")]):
        assert main([command, str(program), *lib]) == 2
        said = capsys.readouterr().err
        assert "Mine.st:3" in said
        assert "there is no type FB_Nonsense" in said
        assert "--lib" not in said


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_library_that_is_no_folder_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    program = tmp_path / "Mine.st"
    program.write_text("PROGRAM Mine\nVAR\n  a : FB_ReadArea;\nEND_VAR\n  a();\nEND_PROGRAM\n")
    for lib in (program, tmp_path / "nope"):
        assert main([command, str(program), "--lib", str(lib)]) == 2
        said = capsys.readouterr().err
        assert f"--lib {lib} is not a folder; name a folder, or leave out --lib" in said
        assert "Mine.st:" not in said
        assert said.count("\n") == 1


def test_the_demo_does_not_overwrite_files_of_the_user(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "trace.jsonl").write_text("mine", encoding="utf-8")
    assert main(["demo", "-o", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith(f"rcx: {tmp_path / 'trace.jsonl'}: already exists")
    assert [file.name for file in tmp_path.iterdir()] == ["trace.jsonl"]


def test_new_files_are_reserved_before_the_work_and_named_after_it(tmp_path: Path) -> None:
    one, two = tmp_path / "new" / "one.toml", tmp_path / "two.csv"
    with NewFiles([one, two]) as files:
        assert not one.exists()
        files.write(b"1", b"2")
    assert (one.read_bytes(), two.read_bytes()) == (b"1", b"2")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["new", "one.toml", "two.csv"]
    with NewFiles([tmp_path / "made" / "three"]):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new", "two.csv"]


def test_nothing_is_done_if_a_new_file_cannot_be_written(tmp_path: Path) -> None:
    there = tmp_path / "there"
    there.write_text("mine", encoding="utf-8")
    for paths, message in (
        ([tmp_path / "a", there], "there: already exists; name another one"),
        ([tmp_path / "a", there / "b"], "b: cannot be written: "),
        ([tmp_path / "a", tmp_path / ("x" * 300)], "xxx: cannot be written: File name too long"),
        ([tmp_path / "a", tmp_path / "." / "a"], "both files are the same; name another one"),
    ):
        with pytest.raises(InputError, match=message):
            NewFiles(paths)
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    assert there.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("links", [True, False])
def test_a_file_that_appears_meanwhile_stays_and_the_output_is_renamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    """If another program creates the file meanwhile, the output gets a new name.

    This works on file systems without hard links as well.
    """
    if not links:

        def none(*_: object) -> None:
            raise PermissionError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(os, "link", none)
    one, two = tmp_path / "one.toml", tmp_path / "two.csv"
    with NewFiles([one, two]) as files:
        one.write_text("mine", encoding="utf-8")
        (tmp_path / "one-1.toml").write_text("mine, too", encoding="utf-8")
        with pytest.raises(InputError) as caught:
            files.write(b"1", b"2")
    other = tmp_path / "one-2.toml"
    said = f"{one}: was created by another program; the output is in {other}"
    assert str(caught.value) == said
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == {
        "one.toml": "mine",
        "one-1.toml": "mine, too",
        "one-2.toml": "1",
        "two.csv": "2",
    }
