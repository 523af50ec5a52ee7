"""Every command reports a damaged recording and ends with exit code 2."""

from __future__ import annotations

import struct
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from captures import Story, area, pcap, pcapng
from rcx_harness.cli.app import main
from rcx_harness.trace import read_trace
from structured_text.errors import InputError

Captured = pytest.CaptureFixture[str]
_HEADER, _RECORD = 24, 16  # sizes of the headers [byte]: of a pcap file, and of each packet in it
_COMMANDS = ["judge {} --quiet", "compare {} --quiet", "view {} -o page.html"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _story() -> Story:
    """Return a capture in which the controller is in AUTO mode and the PLC requests nothing."""
    story = Story()
    story.open(0)
    for k in range(1, 31):
        story.both(10_000 * k, area(), area(dedicated=0x0112))
    return story


def _places(data: bytes | bytearray) -> list[int]:
    """Return the positions of the records of a pcap file."""
    found, at = [], _HEADER
    while at < len(data):
        found.append(at)
        at += _RECORD + struct.unpack_from("<I", data, at + 8)[0]
    return found


def _cut(data: bytearray) -> None:
    del data[-5:]


def _zeroed(data: bytearray) -> None:
    at = _places(data)[30]
    data[at : at + 1000] = bytes(1000)


def _with_a_hole(data: bytearray) -> None:
    at = _places(data)[30]
    del data[at + 7 : at + 1000]


def _longer_than_any(data: bytearray) -> None:
    struct.pack_into("<I", data, _places(data)[30] + 8, 0x7FFFFFFF)


def _shorter_on_the_wire(data: bytearray) -> None:
    struct.pack_into("<I", data, _places(data)[30] + 12, 4)


def _clock_back(data: bytearray) -> None:
    at = _places(data)[30]
    struct.pack_into("<I", data, at, struct.unpack_from("<I", data, at)[0] - 5)


def _clock_ahead(data: bytearray) -> None:
    at = _places(data)[30]
    struct.pack_into("<I", data, at, struct.unpack_from("<I", data, at)[0] + 200_000)


_DAMAGES = [_cut, _zeroed, _with_a_hole, _longer_than_any, _shorter_on_the_wire]
_DAMAGES += [_clock_back, _clock_ahead]


@pytest.mark.parametrize("command", _COMMANDS)
@pytest.mark.parametrize("damage", _DAMAGES)
def test_a_capture_that_is_damaged_is_reported(
    here: Path, capsys: Captured, damage: Callable[[bytearray], None], command: str
) -> None:
    """Every command reports a damaged capture with exit code 2.

    Source: a defect report: 16 of 22 s were ignored, with "answers the same" and exit code 0.
    """
    whole = pcap(here / "cell.pcap", _story().frames())
    assert main(command.format(whole).split()) in (0, 1)
    capsys.readouterr()
    data = bytearray(whole.read_bytes())
    damage(data)
    file = here / "damaged.pcap"
    file.write_bytes(data)
    assert main(command.format(file).split()) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"rcx: {file}: is ")
    assert " after packet " in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("command", _COMMANDS)
def test_a_wrong_block_length_is_reported(here: Path, capsys: Captured, command: str) -> None:
    """Source: a defect report."""
    file = pcapng(here / "cell.pcapng", _story().frames())
    data = bytearray(file.read_bytes())
    at = data.index(struct.pack("<I", 6), len(data) // 2)
    struct.pack_into("<I", data, at + 4, 0xFFFF)
    file.write_bytes(data)
    assert main(command.format(file).split()) == 2
    assert f"rcx: {file}: is damaged after packet" in capsys.readouterr().err


def test_compare_reports_missing_packets(here: Path, capsys: Captured) -> None:
    """`rcx compare` reports missing packets in a file that is not damaged.

    The packet numbers show that the packets of 20 ms are missing.

    Source: a defect report: a hole in the middle.
    """
    data = bytearray(pcap(here / "cell.pcap", _story().frames()).read_bytes())
    places = _places(data)
    del data[places[30] : places[34]]
    file = here / "hole.pcap"
    file.write_bytes(data)
    main(["compare", str(file), "--quiet"])
    assert "4 packets are missing: lost on the way" in capsys.readouterr().out, "2 each way"


_HEAD = '{"format":"rcx-trace/1","scan_us":10000}\n'


def _scan(number: int, t_us: int) -> str:
    return f'{{"t_us":{t_us},"scan":{number},"so":"{"00" * 48}","si":"{"00" * 48}"}}\n'


@pytest.mark.parametrize(
    ("scans", "message"),
    [
        ([(0, 0), (1, 10_000), (3, 30_000)], "scan 3 follows scan 1: lines are missing"),
        ([(0, 0), (2, 20_000), (1, 10_000)], "scan 2 follows scan 0: lines are missing"),
        ([(0, 0), (1, 10_000), (1, 10_000)], "scan 1 follows scan 1: lines are missing"),
        ([(0, 0), (1, 10_000), (2, 5_000)], "the time goes back by 0.005 s"),
    ],
)
def test_a_trace_with_a_hole_is_damaged_at_its_line(
    here: Path, scans: list[tuple[int, int]], message: str
) -> None:
    """A trace with a missing scan is reported as damaged, with the line of the gap.

    Source: a defect report: each scan number is one higher than the last.
    """
    file = here / "trace.jsonl"
    file.write_text(_HEAD + "".join(_scan(*one) for one in scans))
    with pytest.raises(InputError) as raised:
        list(read_trace(file)[1])
    steps = [after == (n + 1, t + 10_000) for (n, t), after in pairwise(scans)]
    assert str(raised.value).startswith(f"{file}:{steps.index(False) + 3}: {message}")


def test_a_trace_of_changes_has_gaps(here: Path) -> None:
    """A trace that was written with `only` may have gaps, because it contains only changes.

    Source: files.md, `only`.
    """
    file = here / "trace.jsonl"
    head = _HEAD.replace("}", ',"only":"changes"}')
    file.write_text(head + _scan(0, 0) + _scan(7, 70_000))
    assert len(list(read_trace(file)[1])) == 2
