from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from both_engines import ENGINES
from rcx_harness import Cell, CellTimeout, InputError, RobotConfig

Build = Callable[..., Cell]

AT_ONCE = RobotConfig(boot_time=0.0)


def test_scans_cycles_and_packets_share_one_virtual_time(raw_cell: Build) -> None:
    """One second contains 100 scans of 10 ms and 200 controller cycles of 5 ms.

    Source: manual chapter 1, 2 (5 ms cycle).
    """
    cell = raw_cell(scan="10ms")
    cell.run("1s")
    assert (cell.now_us, cell.scans, cell.cycles) == (1_000_000, 100, 200)
    assert cell["Main.Scans"] == 100


def test_at_equal_times_the_controller_comes_before_the_plc(raw_cell: Build) -> None:
    cell = raw_cell(scan="10ms")
    cell.run("20ms")
    order = [f"{record.t_us // 1000} {type(record).__name__}" for record in cell.trace]
    assert order == ["0 Cycle", "0 Scan", "5 Cycle", "10 Cycle", "10 Scan", "15 Cycle"]


def test_an_output_travels_with_the_next_packet_and_the_next_cycle(raw_cell: Build) -> None:
    """The PLC writes an output at 100 ms; it is sent at 112 ms (RPI 16 ms) and read at 115 ms."""
    cell = raw_cell(scan="50ms", rpi="16ms", robot=AT_ONCE)
    cell.run("60ms")
    cell["Main.Bits0"] = 1
    cell.run("80ms")
    seen = [one.t_us for one in cell.trace.cycles() if one.rcx_si and one.rcx_si[32]]
    written = [one.t_us for one in cell.trace.scans() if one.si[32]]
    assert written[0] == 100_000
    assert seen[0] == 115_000


def test_a_packet_contains_the_outputs_of_the_time_when_it_was_sent(raw_cell: Build) -> None:
    """A late packet contains the outputs of the time at which it was sent."""
    cell = raw_cell(scan="10ms", rpi="10ms", jitter="40ms", robot=AT_ONCE, seed=3)
    for _ in range(60):
        cell["Main.Data"] = cell.scans % 250
        cell.scan()
    seen = [one.rcx_si[2] for one in cell.trace.cycles() if one.rcx_si]
    assert seen == sorted(seen)
    lateness = [
        one.t_us // 10_000 - one.rcx_si[2]
        for one in cell.trace.cycles()
        if one.rcx_si and one.rcx_si[2]
    ]
    assert max(lateness) >= 3


def test_given_phases_are_used(raw_cell: Build) -> None:
    cell = raw_cell(scan="10ms", phases={"scan": "3ms", "cycle": "1ms"})
    cell.run("15ms")
    assert [one.t_us for one in cell.trace.scans()] == [3_000, 13_000]
    assert [one.t_us for one in cell.trace.cycles()] == [1_000, 6_000, 11_000]


def test_the_same_seed_gives_the_same_run(raw_cell: Build) -> None:
    def lines(seed: int) -> list[str]:
        cell = raw_cell(scan="7ms", rpi="9ms", jitter="20ms", phases="random", seed=seed)
        cell.run("100ms")
        cell["Main.Bits0"] = 1
        cell.run("300ms")
        return list(cell.trace.lines())

    assert lines(1) == lines(1)
    assert lines(1)[1:] != lines(2)[1:]


def test_link_loss_is_seen_by_both_sides_after_the_time_out(raw_cell: Build) -> None:
    """On a loss, SI(00) and SI(06) turn OFF inside the controller, so SO(00) turns ON.

    Source: manual chapter 1, 5, 2.
    """
    cell = raw_cell(scan="10ms", rpi="10ms", robot=AT_ONCE)
    cell.run("50ms")
    cell["Main.Bits0"] = 0x01
    cell.run("150ms")
    assert cell["Main.Connected"]
    assert not cell["Main.InputArea[32]"] & 0x01
    last_packet = cell.now_us - 10_000
    cell.inject("link_down")
    cell.run_until(lambda: not cell["Main.Connected"], within="1s")
    assert cell.now_us - last_packet == 100_000
    sampled = [one for one in cell.trace.cycles() if one.t_us > last_packet]
    assert next(one.t_us for one in sampled if not one.rcx_si) - last_packet == 100_000
    assert sampled[-1].rcx_so[32] & 0x01
    cell.inject("link_up")
    cell.run_until(lambda: cell["Main.Connected"], within="120ms")


def test_an_interruption_shorter_than_the_time_out_is_not_a_loss(raw_cell: Build) -> None:
    cell = raw_cell(robot=AT_ONCE)
    cell.run("50ms")
    cell.inject("link_down")
    cell.run("60ms")
    cell.inject("link_up")
    cell.run("100ms")
    assert all(one.rcx_si for one in cell.trace.cycles() if one.t_us > 10_000)
    assert cell["Main.Connected"]


@pytest.mark.parametrize(("on_loss", "left"), [("hold", 0x12), ("clear", 0)])
def test_a_plc_without_a_link_holds_its_inputs(raw_cell: Build, on_loss: str, left: int) -> None:
    cell = raw_cell(robot=AT_ONCE, on_loss=on_loss)
    cell.run("100ms")
    cell.robot.force("SO00", 0)
    cell.run("100ms")
    assert cell["Main.InputArea[32]"] == 0x12
    cell.inject("link_down")
    cell.run("200ms")
    assert cell["Main.InputArea[32]"] == left


def test_different_sizes_make_no_connection(raw_cell: Build) -> None:
    """If one side has 48 bytes and the other 256 bytes, there is no connection.

    Source: manual chapter 3, 1.
    """
    cell = raw_cell(size=256, robot=RobotConfig(boot_time=0.0))
    cell.run("500ms")
    assert not cell.matched
    assert not cell["Main.Connected"]
    assert all(one.rcx_si == b"" for one in cell.trace.cycles())


def test_a_power_cycle_interrupts_the_link_until_the_controller_has_booted(raw_cell: Build) -> None:
    cell = raw_cell(robot=RobotConfig(boot_time=300.0))
    cell.run("400ms")
    assert cell["Main.Connected"]
    cell.inject("power_cycle")
    cell.run("200ms")
    assert not cell["Main.Connected"]
    cell.run_until(lambda: cell["Main.Connected"], within="150ms")
    assert cell["Main.InputArea[32]"] & 0x02


def test_256_bytes_at_offsets_m_and_n(raw_cell: Build) -> None:
    """The areas begin at byte m of the inputs and byte n of the outputs.

    Source: manual chapter 1, 4.2.
    """
    cell = raw_cell(size=256, m=10, n=200, robot=RobotConfig(size=256, boot_time=0.0))
    cell["Main.InputArea[9]"] = 77
    cell.run("100ms")
    assert cell["Main.InputArea[9]"] == 77
    assert cell["Main.InputArea[42]"] & 0x02
    assert cell["Main.InputArea[32]"] == 0
    cell["Main.OutputArea[255]"] = 9
    cell.run("50ms")
    assert cell.trace.cycles()[-1].rcx_si[55] == 9


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": 64}, "an area of 64 bytes does not exist"),
        ({"m": 465}, "the area at m = 465 needs 48 bytes, but Main.InputArea has 512"),
        ({"n": -1}, "the offset n = -1 is negative"),
        ({"n": 500}, "the area at n = 500 needs 48 bytes, but Main.OutputArea has 512"),
        ({"scan": "0ms"}, "the scan is 0 ms; it must be 0.1 ms to 10000 ms"),
        ({"scan": "soon"}, "'soon' is not a duration"),
        ({"rpi": "5s"}, "the RPI is 5000 ms; it must be 1 ms to 3200 ms"),
        ({"jitter": "-1ms"}, "'-1ms' is not a duration"),
        ({"phases": "often"}, "unknown phases: 'often'"),
        ({"phases": {"plc": "1ms"}}, "unknown phase 'plc'"),
        ({"phases": {"scan": "10ms"}}, "the phase of scan is 10 ms; it must be 0 ms to 9.999 ms"),
        ({"on_loss": "keep"}, "on_loss is 'keep'"),
        ({"link": "serial"}, "unknown link 'serial'"),
        ({"engine": "fast"}, "there is no engine 'fast'"),
        ({"watch": ["Main.Scan"]}, "no member Scan; did you mean Scans"),
    ],
)
def test_bad_values_are_refused_with_one_sentence(
    raw_cell: Build, options: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError) as caught:
        raw_cell(**options)
    assert message in str(caught.value)


def test_a_failed_run_until_reports_scan_time_and_watched_values(raw_cell: Build) -> None:
    cell = raw_cell(watch=["Main.Scans"])
    with pytest.raises(CellTimeout) as caught:
        cell.run_until(lambda: cell["Main.Bits0"] == 1, within="100ms")
    assert str(caught.value) == "not within 100 ms (scan 11, 100 ms); Main.Scans = 11"


def test_run_until_returns_in_the_first_scan_with_a_true_condition(raw_cell: Build) -> None:
    cell = raw_cell()
    assert cell.run_until(lambda: cell["Main.Scans"] == 4, within="1s") == 30_000
    assert cell.run_until(lambda: True, within="1s") == 0


def test_takes_asserts_the_number_of_scans(raw_cell: Build) -> None:
    cell = raw_cell()
    with cell.takes(scans=2):
        cell.scan(2)
    with pytest.raises(AssertionError, match="took 3 scans, expected 2"), cell.takes(scans=2):
        cell.scan(3)


def test_a_restored_cell_repeats_its_run(raw_cell: Build) -> None:
    cell = raw_cell(jitter="15ms", phases="random", seed=5, robot=RobotConfig(boot_time=(10, 90)))
    cell.run("40ms")
    before = cell.snapshot()
    runs = []
    for _ in range(2):
        cell.restore(before)
        cell.run("100ms")
        cell["Main.Bits0"] = 0x43
        cell.run("300ms")
        runs.append((list(cell.trace.lines()), list(cell.violations), cell.now_us, cell.scans))
    assert runs[0] == runs[1]
    assert runs[0][1]


def test_a_cell_with_a_trace_file_cannot_be_restored(raw_cell: Build, tmp_path: Path) -> None:
    cell = raw_cell(trace=tmp_path / "trace.jsonl")
    with pytest.raises(InputError, match="cannot go back in time"):
        cell.snapshot()


def test_an_unknown_path_is_reported_with_similar_names(raw_cell: Build) -> None:
    cell = raw_cell()
    with pytest.raises(InputError, match="Scans"):
        cell["Main.Scan"]
    with pytest.raises(InputError):
        cell["Main.Bits0"] = 256


@pytest.mark.parametrize("engine", ENGINES)
def test_a_closed_cell_keeps_its_trace_and_refuses_all_other_calls(
    raw_cell: Build, engine: str
) -> None:
    cell = raw_cell(engine=engine)
    cell.run("30ms")
    state = cell.snapshot()
    cell.close()
    cell.close()
    assert len(cell.trace.scans()) == 3
    assert (cell.now_us, cell.scans, cell.violations) == (30_000, 3, [])
    with pytest.raises(InputError, match="the cell is closed"):
        cell["Main.Scans"]
    with pytest.raises(InputError, match="the cell is closed"):
        cell["Main.Scans"] = 0
    uses: list[Callable[[], object]] = [
        cell.scan,
        cell.snapshot,
        lambda: cell.run("10ms"),
        lambda: cell.run_until(lambda: False, within="1s"),
        lambda: cell.restore(state),
    ]
    for use in uses:
        with pytest.raises(InputError, match="the cell is closed"):
            use()
