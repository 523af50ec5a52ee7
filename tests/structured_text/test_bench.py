"""A program runs on the toolkit alone, without a robot, a library or areas."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from structured_text import Bench, BenchTimeout, InputError
from structured_text.bench.stimulus import Stimulus
from structured_text.debug.bench import BenchMachine

_LAMP = """PROGRAM Main
  VAR Go, Lamp : BOOL; Count : INT; Delay : TON; END_VAR
  VAR RETAIN Parts : INT; END_VAR
  Delay(IN := Go, PT := T#50ms);
  Lamp := Delay.Q;
  IF Lamp THEN Count := Count + 1; Parts := Parts + 1; END_IF;
END_PROGRAM
"""


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    file = tmp_path / "lamp.st"
    file.write_text(_LAMP, encoding="utf-8")
    return file


def _stimulus(folder: Path, text: str) -> Path:
    file = folder / "stimulus.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_program_without_areas_runs_in_virtual_time(lamp: Path) -> None:
    """A program without areas runs in virtual time.

    The input is set before the scan at 0 ms, and the sixth scan is at 50 ms.

    Source: IEC 61131-3, TON.
    """
    with Bench.build(lamp, engine="builtin") as bench:
        bench["Main.Go"] = True
        assert bench.run_until(lambda: bench["Main.Lamp"], within="1s") == 50_000
        assert bench.scans == 6
        with bench.takes(scans=3):
            bench.scan(3)
        assert bench["Main.Count"] == 4


def test_a_condition_that_comes_too_late_fails_the_test(lamp: Path) -> None:
    with (
        Bench.build(lamp, engine="builtin", watch="Main.Count") as bench,
        pytest.raises(BenchTimeout, match=r"not within 1000 ms .*; Main\.Count = 0"),
    ):
        bench.run_until(lambda: bench["Main.Lamp"], within="1s")


def test_a_stimulus_sets_inputs_for_a_time_and_stops_the_plc(lamp: Path, tmp_path: Path) -> None:
    """The stimulus sets the input from 100 ms to 300 ms.

    The lamp is ON in the 15 scans from 150 ms to 290 ms.

    A warm start at 500 ms keeps the RETAIN variables.

    Source: IEC 61131-3, RETAIN.
    """
    file = _stimulus(
        tmp_path,
        """at = [
  { time = "100ms", set = { "Main.Go" = true }, for = "200ms" },
  { time = "400ms", plc = "stop", for = "100ms", expect = "Main.Count = 15" },
  { time = "450ms", expect = "Main.Count = 99" },
]
""",
    )
    with Bench.build(lamp, engine="builtin") as bench:
        Stimulus.load(file).schedule(bench)
        bench.run("1s")
        assert (bench["Main.Count"], bench["Main.Parts"]) == (0, 15)
        assert bench.scans == 90
        told = "plc, scan 40: expect: Main.Count = 99 does not hold"
        assert [one.text for one in bench.violations] == [told]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{ time = "1s", robot = "alarm" }', r":2: unknown key 'robot'; keys are time, set, plc"),
        ('{ time = "1s", plc = "halt" }', r":2: unknown event 'halt'"),
        (
            '{ time = "1s", plc = { event = "run", start = "hot" } }',
            r":2: start = 'hot' is not a kind of start",
        ),
        (
            '{ time = "1s", plc = { event = "overrun", by = "1s", x = 1 } }',
            r"write plc = \{ event = ",
        ),
        ('{ time = "1s", set = { "Main.Gone" = 1 } }', r":2: .*has no member Gone"),
        ('{ time = "1s", for = "1s" }', r":2: 'for' needs set or plc"),
    ],
)
def test_a_wrong_stimulus_has_its_line(lamp: Path, tmp_path: Path, text: str, message: str) -> None:
    file = _stimulus(tmp_path, f"at = [\n  {text},\n]\n")
    with Bench.build(lamp, engine="builtin") as bench, pytest.raises(InputError, match=message):
        Stimulus.load(file).schedule(bench)


def test_each_run_gives_the_same_trace(lamp: Path, tmp_path: Path) -> None:
    """Two runs write the same trace.

    Source: docs/reference/trace.md.
    """
    files = [tmp_path / name for name in ("first.jsonl", "second.jsonl")]
    for file in files:
        with Bench.build(lamp, engine="builtin", watch="Main.Go,Main.Lamp", trace=file) as bench:
            bench["Main.Go"] = True
            bench.run("60ms")
    header, *lines = map(json.loads, files[0].read_text().splitlines())
    assert header["scan_us"] == 10_000
    assert "size" not in header, "the program has no areas"
    assert [one["vars"]["Main.Lamp"] for one in lines] == [False] * 5 + [True]
    assert lines[5] == {"t_us": 50_000, "scan": 5, "vars": {"Main.Go": True, "Main.Lamp": True}}
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_trace_cannot_overwrite_the_program(lamp: Path) -> None:
    with pytest.raises(InputError, match="would be overwritten, but it is an input"):
        Bench.build(lamp, engine="builtin", trace=lamp)
    assert lamp.read_text(encoding="utf-8") == _LAMP


def test_a_bench_goes_back_to_a_snapshot(lamp: Path) -> None:
    with Bench.build(lamp, engine="builtin", watch="Main.Count") as bench:
        bench["Main.Go"] = True
        bench.scan(4)
        before = bench.snapshot()
        bench.scan(6)
        after = list(bench.trace), bench["Main.Count"], bench.now_us
        bench.restore(before)
        assert (bench.scans, bench["Main.Count"], len(bench.trace)) == (4, 0, 4)
        bench.scan(6)
        assert (list(bench.trace), bench["Main.Count"], bench.now_us) == after


def test_a_closed_bench_reports_that_it_is_closed(lamp: Path) -> None:
    with Bench.build(lamp, engine="builtin") as bench:
        bench.scan()
    with pytest.raises(InputError, match="the bench is closed"):
        bench.scan()
    with pytest.raises(InputError, match="the bench is closed"):
        bench["Main.Go"]


def test_a_program_takes_blocks_of_a_library_that_is_named(tmp_path: Path) -> None:
    program, library = tmp_path / "main.st", tmp_path / "lib"
    program.write_text("PROGRAM Main VAR A : INT; END_VAR A := FC_Next(A); END_PROGRAM")
    library.mkdir()
    (library / "FC_Next.st").write_text(
        "FUNCTION FC_Next : INT VAR_INPUT Old : INT; END_VAR FC_Next := Old + 1; END_FUNCTION"
    )
    with pytest.raises(InputError, match="FC_Next"):
        Bench.build(program, engine="builtin")
    with Bench.build(program, engine="builtin", lib=library) as bench:
        bench.scan(2)
        assert bench["Main.A"] == 2


def test_a_bench_is_debugged_forwards_and_backwards(lamp: Path) -> None:
    """A run of 60 ms with six scans can be stepped forwards and backwards.

    Source: docs/how-to/debug.md.
    """
    machine = BenchMachine(Bench.build(lamp, engine="builtin"), 60_000, "60ms")
    machine.bench["Main.Go"] = True
    before = machine.snapshot()
    while not machine.ended:
        machine.scan()
    assert (machine.scans, machine.program.read("Main.Count")) == (6, 1)
    assert machine.ended == "the end of the run (60ms)"
    machine.restore(before)
    assert (machine.scans, machine.program.read("Main.Count")) == (0, 0)
    machine.inject("plc_stop", 1)
    with pytest.raises(InputError, match="the PLC is not in RUN"):
        machine.scan()
    machine.close()
