"""For bad input, every command prints one message and ends with exit code 2.

The message names the bad input. Files of the user do not change.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]

_ZEROS = "00" * 48
#: A trace of two scans in which nothing changes.
_TRACE = (
    '{"format":"rcx-trace/1","scan_us":10000,"cycle_us":5000,"size":48,"engine":"builtin",'
    '"link":"direct","seed":0}\n'
    f'{{"t_us":0,"scan":0,"so":"{_ZEROS}","si":"{_ZEROS}","vars":{{}}}}\n'
    f'{{"t_us":10000,"scan":1,"so":"{_ZEROS}","si":"{_ZEROS}","vars":{{}}}}\n'
)
_LOOP = "Too many levels of symbolic links"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder. It contains a symbolic link `loop` that leads back to itself."""
    monkeypatch.chdir(tmp_path)
    os.symlink("there", "loop")
    os.symlink("loop", "there")
    Path("t.jsonl").write_text(_TRACE)
    Path("p.st").write_text("PROGRAM P\n  VAR A : BOOL; END_VAR\n  A := TRUE;\nEND_PROGRAM\n")
    Path("lib").mkdir()
    Path("lib/L.st").write_text("TYPE\n  L : INT;\nEND_TYPE\n")
    return tmp_path


def _refused(capsys: Captured, *words: str) -> str:
    """Run a command, check that it ends with 2, and return the one line of its error message."""
    code = main(words)
    said = capsys.readouterr()
    assert (code, said.out) == (2, ""), said
    lines = said.err.splitlines()
    assert len(lines) == 1, said.err
    return lines[0]


@pytest.mark.parametrize(
    "words",
    [
        ["check", "p.st", "--lib", "loop"],
        ["run", "loop", "--lib", "lib"],
        ["run", "p.st", "--lib", "lib", "--robot", "loop"],
        ["run", "p.st", "--lib", "lib", "--stimulus", "loop"],
        ["judge", "loop"],
        ["view", "loop"],
        ["compare", "loop"],
        ["compare", "t.jsonl", "--robot", "loop"],
        ["campaign", "p.st", "--lib", "loop"],
        ["import", "loop", "-o", "out"],
        ["export", "st", "--lib", "lib", "--program", "loop", "-o", "x.st"],
        ["prove", "p.st", "--lib", "loop"],
    ],
)
def test_a_link_in_a_loop_cannot_be_read(here: Path, capsys: Captured, words: list[str]) -> None:
    """The error message names the link. Source: open(2), ELOOP.

    Until Python 3.12, pathlib.Path.resolve raises a RuntimeError.
    """
    assert "loop" in _refused(capsys, *words)


@pytest.mark.parametrize(
    "words",
    [
        ["judge", "t.jsonl", "--quiet", "--chart", "loop"],
        ["judge", "t.jsonl", "--quiet", "--trace", "loop"],
        ["view", "t.jsonl", "-o", "loop"],
        ["eds", "loop"],
        ["new", "loop"],
        ["debug", "--vscode", "loop"],
        ["export", "st", "--lib", "lib", "-o", "loop"],
    ],
)
def test_a_link_in_a_loop_is_not_replaced(here: Path, capsys: Captured, words: list[str]) -> None:
    """An output with the name of the link is rejected, and the link stays.

    Source: open(2), ELOOP.
    """
    assert f"cannot be written: {_LOOP}" in _refused(capsys, *words)
    assert Path("loop").readlink() == Path("there")
    assert sorted(path.name for path in here.iterdir()) == ["lib", "loop", "p.st", "t.jsonl",
                                                            "there"]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "where"),
    [
        (["judge", "t.jsonl", "--quiet", "--chart", "{}"], "{}"),
        (["judge", "t.jsonl", "--quiet", "--trace", "{}"], "{}"),
        (["view", "t.jsonl", "-o", "{}"], "{}"),
        (["eds", "{}"], "{}"),
        (["new", "{}", "--name", "cell"], "{}/"),
        (["debug", "--vscode", "{}"], "{}/"),
        (["export", "st", "--lib", "lib", "-o", "{}"], "{}"),
    ],
)
@pytest.mark.parametrize(
    ("place", "reason"),
    [
        ("t.jsonl/x", "Not a directory"),
        ("n" * 300, "File name too long"),
        ("/proc/nothing", "No such file or directory"),
    ],
)
def test_an_unwritable_path_is_reported_with_the_reason(
    here: Path, capsys: Captured, words: list[str], where: str, place: str, reason: str
) -> None:
    """The message names the path that cannot be written, not standard output.

    Source: open(2), ENOTDIR, ENAMETOOLONG; proc(5) takes no new files.
    """
    said = _refused(capsys, *(word.format(place) for word in words))
    if said != "rcx: t.jsonl: is a file; name a folder":
        assert said.startswith(f"rcx: {where.format(place)}")
        assert said.endswith(f"cannot be written: {reason}")


@pytest.mark.parametrize(
    "words",
    [
        ["run", "{}", "--lib", "lib"],
        ["run", "p.st", "--lib", "lib", "--robot", "{}"],
        ["check", "{}"],
        ["judge", "{}"],
        ["view", "{}"],
        ["compare", "{}"],
        ["export", "st", "--lib", "lib", "--program", "{}", "-o", "x.st"],
        ["mutants", "p.st", "--reasons", "{}", "--", "true"],
        ["import", "{}", "-o", "out"],
    ],
)
def test_an_unreadable_file_is_reported(here: Path, capsys: Captured, words: list[str]) -> None:
    """The message has the name of the file and the reason. Source: open(2), ENAMETOOLONG."""
    name = "n" * 300
    said = _refused(capsys, *(word.format(name) for word in words))
    assert name in said
    assert said.endswith("File name too long")


def test_a_deleted_current_folder_is_reported(here: Path, capsys: Captured) -> None:
    """If the current folder was deleted, the command reports this. Source: getcwd(3), ENOENT."""
    gone = here / "gone"
    gone.mkdir()
    os.chdir(gone)
    gone.rmdir()
    said = _refused(capsys, "demo")
    assert said == (
        "rcx: the current folder cannot be accessed: it may be gone; change to another one"
    )


def test_campaign_refuses_a_library_that_is_no_folder(here: Path, capsys: Captured) -> None:
    """`rcx campaign` and `rcx run` print the same message. Source: `rcx run --help`, --lib."""
    said = _refused(capsys, "run", "p.st", "--lib", "nowhere")
    assert _refused(capsys, "campaign", "p.st", "--lib", "nowhere") == said


def test_explore_does_not_write_over_a_file_of_the_users(here: Path, capsys: Captured) -> None:
    """The user's file out/broken.toml stays.

    Source: CONTRIBUTING.md, files of users are never lost.
    """
    Path("out").mkdir()
    Path("out/broken.toml").write_text("mine\n")
    said = _refused(capsys, "explore", "p.st", "--lib", "lib", "--out", "out")
    assert "out/broken.toml: already exists and was not written by rcx" in said
    assert Path("out/broken.toml").read_text() == "mine\n"


# --- JSON ---------------------------------------------------------------------------------------


def test_json_is_written_to_a_file_and_the_report_is_printed(here: Path, capsys: Captured) -> None:
    """`--json FILE` writes the table that `--json -` prints. Source: docs/how-to/judge.md."""
    assert main(["judge", "t.jsonl", "--json", "it.json"]) == 0
    assert capsys.readouterr().out.endswith("no violations\nwritten: it.json\n")
    written = Path("it.json").read_text()
    assert main(["judge", "t.jsonl", "--json", "-"]) == 0
    assert capsys.readouterr().out == written
    assert main(["judge", "t.jsonl", "--json"]) == 0
    assert capsys.readouterr().out == written
    # the command may replace its own older file
    assert main(["judge", "t.jsonl", "--json", "it.json", "--quiet"]) == 0


def test_an_instance_needs_the_option_connect(here: Path, capsys: Captured) -> None:
    """The options for instances are only allowed with --connect. Source: `rcx run --help`."""
    for option in ("--input-instance", "--output-instance"):
        said = _refused(capsys, "run", "p.st", option, "99999")
        assert "--input-instance, --output-instance need --connect" in said


@pytest.mark.parametrize("command", ["judge", "compare"])
def test_json_does_not_write_over_an_input_file(here: Path, capsys: Captured, command: str) -> None:
    """The input file is not replaced. Source: CONTRIBUTING.md, files of users are never lost."""
    said = _refused(capsys, command, "t.jsonl", "--json", "t.jsonl")
    assert "already exists and was not written by this command" in said
    assert Path("t.jsonl").read_text() == _TRACE


# --- numbers ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        ["serve", "--seed", "-1"],
        ["serve", "--seed", str(2**63)],
        ["campaign", "p.st", "--seed-from", str(2**63)],
        ["campaign", "p.st", "--seeds", str(10**10)],
        ["campaign", "p.st", "--workers", str(10**6)],
        ["explore", "p.st", "--workers", str(10**6)],
        ["explore", "p.st", "--bound", str(10**10)],
        ["explore", "p.st", "--depth", str(10**10)],
        ["mutants", "p.st", "--workers", str(10**6), "--", "true"],
        ["mutants", "p.st", "--show", "-1", "--", "true"],
        ["mutants", "p.st", "--minutes", "nan", "--", "true"],
    ],
)
def test_numbers_outside_their_range_are_refused(
    here: Path, capsys: Captured, words: list[str]
) -> None:
    """A number outside its range is rejected and named. Source: the help of each command."""
    assert main(words) == 2
    assert words[-3 if "--" in words else -1] in capsys.readouterr().err.replace("\n", "")


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["run", ""], "rcx: the name"),
        (["check", "p.st", ""], "rcx: the name"),
        (["view", ""], "rcx: the name"),
        (["judge", "t.jsonl", "--chart", ""], "rcx: --chart: the name"),
        (["run", "p.st", "--lib="], "rcx: --lib: the name"),
        (["run", "p.st", "--robot", ""], "rcx: --robot: the name"),
        (["import", "p.st", "-o", ""], "rcx: -o: the name"),
        (["demo", "--out", ""], "rcx: --out: the name"),
        (["points", "backup", "127.0.0.1", ""], "rcx: the name"),
    ],
)
def test_an_empty_name_of_a_file_is_not_the_current_folder(
    here: Path, capsys: Captured, words: list[str], shown: str
) -> None:
    """An empty path is rejected. An unset shell variable gives one. Source: POSIX 4.13."""
    hint = "a variable of the shell may not be set; . is the current folder"
    assert _refused(capsys, *words) == f"{shown} of a file or folder is empty; {hint}"


def test_no_escape_sequence_reaches_the_terminal(here: Path, capsys: Captured) -> None:
    """Escape sequences in names of files, keys and variables are not printed.

    Such names may come from projects, traces and archives of other people.

    Source: ECMA-48, 5.3: ESC and the controls from 80 to 9F
    """
    Path("evil").mkdir()
    Path("evil/a\x1b[2J\x9b31m.st").write_text(
        "PROGRAM P\n  VAR InputArea, OutputArea : ARRAY [0..511] OF BYTE; END_VAR\n"
        "  IF TRUE THEN\n    ;\n  END_IF;\nEND_PROGRAM\n"
    )
    Path("robot.toml").write_text('"\\u001b[2J" = 1\n')
    Path("never.toml").write_text('[[always]]\nname = "\\u001b[2J"\nthat = "FALSE"\n')
    for words in (
        ["check", "evil", "--lib", "lib"],
        ["run", "no\x1b[2J.st"],
        ["run", "p.st", "--lib", "lib", "--robot", "robot.toml"],
        ["run", "evil", "--lib", "lib", "--properties", "never.toml", "--for", "20ms"],
    ):
        main(words)
        said = capsys.readouterr()
        text = said.out + said.err
        assert "\\x1b[2J" in text, text
        assert "\x1b" not in text
        assert "\x9b" not in text
