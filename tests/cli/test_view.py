"""`rcx view` and `rcx run --view` write HTML pages, and reject bad input."""

from __future__ import annotations

import gzip
import re
import webbrowser
from pathlib import Path

import pytest

from captures import Story, area, pcap, pcapng
from plcopen_drawings import element, project
from rcx_harness.cli.app import main
from rcx_harness.trace.view import BEGINNING
from view_page import PageContent

Captured = pytest.CaptureFixture[str]

_AREA = "00" * 48
_ON = "00" * 32 + "4100" + "00" * 14
_HEAD = '{"format":"rcx-trace/1","scan_us":10000,"size":48}\n'
_FIRST = f'{{"t_us":0,"scan":0,"so":"{_AREA}","si":"{_AREA}"}}\n'
_LINES = _HEAD + _FIRST + f'{{"t_us":10000,"scan":1,"so":"{_AREA}","si":"{_ON}"}}\n'

_RUNG = element("leftPowerRail", 1) + element("contact", 2, "Start", "1", at="50 0")
_RUNG += element("coil", 3, "Motor", "2", at="99 0")


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    """Return a trace file in which SI(00) and SI(06) turn ON at 10 ms."""
    file = tmp_path / "run.jsonl"
    file.write_text(_LINES, encoding="utf-8")
    return file


def _story() -> Story:
    """Return a capture in which SI(00) turns ON at 200 ms, and SI(06) only 50 ms later.

    The manual demands 100 ms between the two changes (chapter 5, 3).
    """
    story = Story()
    story.open(0)
    for k in range(1, 51):
        story.both(10_000 * k, area(dedicated=(k >= 20) | (k >= 25) << 6), area(dedicated=0x0112))
    return story


def _page(file: Path) -> PageContent:
    return PageContent(file.read_text(encoding="utf-8"))


def test_the_page_is_written_beside_the_trace(trace: Path, capsys: Captured) -> None:
    assert main(["view", str(trace)]) == 0
    page = trace.with_name("run.html")
    assert capsys.readouterr().out == f"written: {page}, no broken rules\n"
    changes = _page(page).changes("SI(06) Stop input")
    assert changes == [(-1, 0), (10_000, 1)]


def test_an_older_page_is_overwritten(trace: Path, tmp_path: Path, capsys: Captured) -> None:
    page = tmp_path / "mine" / "page.html"
    for _ in range(2):
        assert main(["view", str(trace), "-o", str(page)]) == 0
    whole = page.read_bytes()
    foreign = tmp_path / "foreign.html"
    foreign.write_text("<!doctype html>\n<p>mine", encoding="utf-8")
    assert main(["view", str(trace), "-o", str(foreign)]) == 2
    assert "already exists and is not a page of rcx view" in capsys.readouterr().err
    assert foreign.read_text(encoding="utf-8") == "<!doctype html>\n<p>mine"
    assert main(["view", str(trace), "-o", str(trace)]) == 2
    assert "would be overwritten" in capsys.readouterr().err
    assert page.read_bytes() == whole
    assert trace.read_text(encoding="utf-8") == _LINES


@pytest.mark.parametrize("has_browser", [True, False])
def test_the_page_opens_in_the_browser(
    trace: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch, has_browser: bool
) -> None:
    opened: list[str] = []

    def instead(address: str) -> bool:
        opened.append(address)
        return has_browser

    monkeypatch.setattr(webbrowser, "open", instead)
    assert main(["view", str(trace), "--open"]) == 0
    assert opened == [trace.with_name("run.html").as_uri()]
    assert ("no browser was found" in capsys.readouterr().err) is not has_browser


def test_a_capture_is_judged_first(tmp_path: Path, capsys: Captured) -> None:
    capture = pcapng(tmp_path / "cell.pcapng", _story().frames())
    assert main(["view", str(capture)]) == 0
    assert capsys.readouterr().out.endswith("cell.html, 1 broken rule\n")
    page = _page(tmp_path / "cell.html")
    (_, first), (when, text) = page.changes("Rules broken")
    assert (first, when) == (None, 250_000)
    assert "interval: SI(06) ON only 50 ms after SI(00) ON" in text


def test_a_capture_that_is_cut_off_is_shown_up_to_its_end(tmp_path: Path, capsys: Captured) -> None:
    capture = pcap(tmp_path / "cell.pcap", _story().frames())
    capture.write_bytes(capture.read_bytes()[:-20])
    assert main(["view", str(capture)]) == 2
    error = capsys.readouterr().err
    assert "is cut off after packet" in error
    assert error.count("\n") == 1
    assert _page(tmp_path / "cell.html").table["broken"] == 1


def test_a_recording_of_rcx_scan_is_judged(tmp_path: Path) -> None:
    """The page shows that two inputs change in one scan, which breaks a rule (chapter 5, 3)."""
    trace = tmp_path / "scan.jsonl"
    ready = "00" * 32 + "1201" + "00" * 14
    lines = [_HEAD.replace("}", ',"by":"rcx scan"}').strip()]
    for k in range(30):
        si = _ON if k >= 20 else _AREA
        lines.append(f'{{"t_us":{10_000 * k},"scan":{k},"so":"{ready}","si":"{si}"}}')
    trace.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert main(["view", str(trace)]) == 0
    assert [t_us for t_us, _ in _page(tmp_path / "scan.html").changes("Rules broken")] == [
        -1,
        200_000,
    ]


def test_an_unfinished_trace_is_shown_up_to_its_end(trace: Path, capsys: Captured) -> None:
    trace.write_text(_LINES + '{"t_us":20000,"scan":2,"so":"00', encoding="utf-8")
    assert main(["view", str(trace)]) == 2
    page = trace.with_name("run.html")
    said = f"rcx: {trace}:4: is cut off in this line; the part before it is in {page}\n"
    assert capsys.readouterr().err == said
    assert _page(page).table["end"] == 10_000


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty; record again"),
        (b"hello\n", "is neither a capture (pcapng, pcap) nor a trace (jsonl)"),
        (gzip.compress(b"anything", mtime=0), "unpack it first"),
        (b"\x00\xff" * 99, "is neither a capture (pcapng, pcap) nor a trace (jsonl)"),
        (_HEAD.encode(), "contains no scan and no cycle"),
        ((_HEAD + '{"t_us":0').encode(), "run.jsonl:2: is cut off in this line"),
        ((_HEAD + _FIRST.replace(":0,", ":-5,", 1)).encode(), "run.jsonl:2: not a record of a"),
        ((_HEAD + _FIRST).encode() + b'{"t_us":"\xff"}\n', "run.jsonl:3: not a line of a trace"),
        ((_HEAD + _FIRST.replace(_AREA, "00")).encode(), "areas of 1 and 1 bytes do not"),
        (
            (_HEAD[:-2] + ',"watch":{"X":7}}\n' + _FIRST).encode(),
            "header does not describe variables",
        ),
    ],
)
def test_an_invalid_recording_is_one_line_and_no_page(
    tmp_path: Path, capsys: Captured, content: bytes, message: str
) -> None:
    file = tmp_path / "run.jsonl"
    file.write_bytes(content)
    assert main(["view", str(file)]) == 2
    shown = capsys.readouterr()
    assert message in shown.err
    assert (shown.err.count("\n"), shown.out) == (1, "")
    assert [one.name for one in tmp_path.iterdir()] == ["run.jsonl"]


def test_the_page_of_a_drawn_program_shows_its_networks(tmp_path: Path, capsys: Captured) -> None:
    """Their variables are recorded for the page only, so they are not printed as watched."""
    file, page = tmp_path / "plc.xml", tmp_path / "page.html"
    file.write_text(project("Start Motor : BOOL", f"<LD>{_RUNG}</LD>"), encoding="utf-8")
    given = ["--no-robot", "--engine=builtin", "--for=50ms", f"--view={page}"]
    assert main(["run", str(file), *given]) == 0
    assert "watched" not in capsys.readouterr().out
    table = _page(page).table
    assert [network["title"] for network in table["networks"][0]["networks"]] == ["Network 1"]
    assert list(table["variables"]) == ["MAIN.START", "MAIN.MOTOR"]


def test_a_trace_is_shown_with_the_networks_of_a_program(tmp_path: Path, capsys: Captured) -> None:
    """Only Start was watched, so the page knows nothing about Motor."""
    file, trace = tmp_path / "plc.xml", tmp_path / "run.jsonl"
    file.write_text(project("Start Motor : BOOL", f"<LD>{_RUNG}</LD>"), encoding="utf-8")
    given = ["--no-robot", "--engine=builtin", "--for=50ms", f"--trace={trace}"]
    assert main(["run", str(file), *given, "--watch=main.start"]) == 0
    assert main(["view", str(trace), f"--program={file}"]) == 0
    table = _page(tmp_path / "run.html").table
    assert [group["title"] for group in table["networks"]] == ["Main"]
    assert list(table["variables"]) == ["MAIN.START"]
    assert main(["run", str(file), *given]) == 0
    text = (tmp_path / "run.html").read_bytes()
    assert main(["view", str(trace), f"--program={file}"]) == 2
    assert "run.jsonl: has no variables that the networks can show" in capsys.readouterr().err
    (tmp_path / "plc.st").write_text("PROGRAM Main\nEND_PROGRAM\n", encoding="utf-8")
    assert main(["view", str(trace), f"--program={tmp_path / 'plc.st'}"]) == 2
    assert "plc.st: the program has no networks" in capsys.readouterr().err
    assert (tmp_path / "run.html").read_bytes() == text


def test_a_missing_recording_is_reported_in_one_line(tmp_path: Path, capsys: Captured) -> None:
    for name in ("nothing.jsonl", "."):
        assert main(["view", str(tmp_path / name), "-o", str(tmp_path / "page.html")]) == 2
        assert re.search("cannot be read|is a folder, not a file", capsys.readouterr().err)


def test_a_run_writes_the_page_of_its_trace(
    repository: Path, tmp_path: Path, capsys: Captured
) -> None:
    """`rcx run --view` writes the page that `rcx view` writes from the trace of the run.

    Only the titles of the pages differ.
    """
    example = repository / "plc/examples/04_pick_and_place"
    trace, page = tmp_path / "t.jsonl", tmp_path / "run.html"
    options = [f"--stimulus={example / 'stimulus.toml'}", f"--robot={example / 'robot.toml'}"]
    options += ["--watch=Main.Carry", "--positions=mm", "--engine=builtin"]
    given = [*options, "--for=2s", f"--trace={trace}", f"--view={page}"]
    assert main(["run", str(example), *given]) == 0
    assert f"written: {trace}, {page}\n" in capsys.readouterr().out
    assert main(["view", str(trace)]) == 0
    ran, read = (_page(file) for file in (page, tmp_path / "t.html"))
    assert page.read_text(encoding="utf-8").startswith(BEGINNING)
    assert ran.table.pop("title").endswith("scan 10 ms, RPI 10 ms")
    assert read.table.pop("title") == "t.jsonl"
    assert ran.table == read.table
    assert [text for _, text in read.changes("Main.Carry.Stage")][:2] == [
        "PICK_START",
        "PICK_EMPTY",
    ]
    assert {"Block Main.Carry", "Positions", "Speeds"} <= set(read.groups())
