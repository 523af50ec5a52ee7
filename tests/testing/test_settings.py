"""The settings of `cell` in a user's test come from marker, command line and ini file."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

Run = Callable[..., pytest.RunResult]

_SHOW = "def test_it(cell):\n    print('scan', cell.timing.scan_us)\n"


def test_cell_is_the_program_of_the_ini_file_and_robot_its_robot(run: Run) -> None:
    result = run("""
        def test_it(cell, robot):
            cell.scan(3)
            assert cell["Main.Scans"] == 3
            assert robot is cell.robot
        """)
    result.assert_outcomes(passed=1)


def test_each_test_has_a_cell_of_its_own_at_time_0(run: Run) -> None:
    result = run("""
        def test_one(cell):
            cell["Main.Data"] = 7
            cell.run("1s")
        def test_two(cell):
            assert (cell.now_us, cell["Main.Data"]) == (0, 0)
        """)
    result.assert_outcomes(passed=2)


def test_the_marker_comes_before_the_command_line_and_that_before_the_ini_file(run: Run) -> None:
    test = _SHOW + "import pytest\n@pytest.mark.rcx(scan='5ms')\n" + _SHOW.replace("_it", "_marked")
    result = run(test, "-s", "--rcx-scan", "20ms", scan="40ms")
    result.stdout.fnmatch_lines(["*scan 20000*", "*scan 5000*"])
    run(_SHOW, "-s", scan="40ms").stdout.fnmatch_lines(["*scan 40000*"])
    run(_SHOW, "-s").stdout.fnmatch_lines(["*scan 10000*"])


def test_markers_of_class_and_test_are_joined_and_the_nearer_one_wins(run: Run) -> None:
    result = run("""
        import pytest
        @pytest.mark.rcx(scan="5ms", rpi="20ms")
        class TestIt:
            @pytest.mark.rcx(scan="7ms")
            def test_it(self, cell):
                assert (cell.timing.scan_us, cell.timing.rpi_us) == (7_000, 20_000)
        """)
    result.assert_outcomes(passed=1)


def test_every_key_of_the_ini_file_reaches_the_cell(run: Run, pytester: pytest.Pytester) -> None:
    pytester.makefile(".toml", robot="size = 256\n")
    result = run(
        """
        def test_it(cell):
            header = cell.trace.header
            assert (header["seed"], header["size"], header["scan_us"]) == (5, 256, 20_000)
            assert (cell.timing.rpi_us, cell.timing.jitter_us) == (30_000, 2_000)
            cell["Main.Data"] = 9
            cell.run("100ms")
            assert cell.trace.scans()[-1].vars == {"Main.Data": 9}
            assert cell.trace.cycles()[0].positions == (0.0, 0.0, 0.0, 0.0)
            assert cell["Main.InputArea[132]"] & 2, "SO(01) lies at m + 32"
            assert cell.trace.scans()[-1].si[0] == 0, "the area to the robot begins at n = 200"
        """,
        robot="robot.toml",
        seed="5",
        scan="20ms",
        rpi="30ms",
        jitter="2ms",
        m="100",
        n="200",
        on_loss="clear",
        watch="Main.Da*",
        positions="mm",
    )
    result.assert_outcomes(passed=1)


def test_files_of_the_command_line_lie_where_the_user_stands_others_at_the_ini_file(
    run: Run, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytester.makefile(".toml", robot="size = 48\n")
    (pytester.mkdir("below") / "robot.toml").write_text("size = 256\n")
    test = "def test_it(cell, request):\n    assert cell.robot.config.size == {}\n"
    run(test.format(48), robot="robot.toml").assert_outcomes(passed=1)
    monkeypatch.chdir("below")
    run(test.format(48), "..", robot="robot.toml").assert_outcomes(passed=1)
    result = run(test.format(256), "..", "--rcx-robot", "robot.toml", robot="robot.toml")
    result.assert_outcomes(passed=1)


def test_several_robots_are_named_line_by_line_or_one_option_each(
    run: Run, pytester: pytest.Pytester
) -> None:
    pytester.makefile(".toml", a="auto_speed = 50\n", b="auto_speed = 60\n")
    test = """
        def test_it(cell):
            assert [one.config.auto_speed for one in cell.robots] == [50, 60]
            cell.run("500ms")
            assert cell["Main.InputArea[32]"] & 2, "SO(01) of the first"
            assert cell["Main.InputArea[132]"] & 2, "SO(01) of the second, at m = 100"
        """
    run(test, robot="\n  a.toml\n  b.toml", m="0 100").assert_outcomes(passed=1)
    run(test, "--rcx-robot=a.toml", "--rcx-robot=b.toml", m="0 100").assert_outcomes(passed=1)


def test_sources_may_be_a_folder_or_several_lines(run: Run) -> None:
    test = "def test_it(cell):\n    cell.scan()\n"
    run(test, sources="plc").assert_outcomes(passed=1)
    run(test, sources="\n  plc/Raw*.st\n  plc/RawArea.st").assert_outcomes(passed=1)


def test_a_test_builds_further_cells_on_top_of_its_settings(run: Run) -> None:
    result = run("""
        import pytest
        @pytest.mark.rcx(scan="5ms")
        def test_it(cell, rcx_build):
            other = rcx_build(rpi="20ms")
            assert other is not cell
            assert (other.timing.scan_us, other.timing.rpi_us) == (5_000, 20_000)
        """)
    result.assert_outcomes(passed=1)


@pytest.mark.exhaustive
def test_the_link_may_be_ethernet_ip(run: Run) -> None:
    result = run(
        """
        def test_it(cell):
            assert cell.trace.header["link"] == "enip"
            cell.run("300ms")
            assert cell["Main.InputArea[32]"] & 2, "SO(01) came over the network"
        """,
        "--rcx-link=enip",
    )
    result.assert_outcomes(passed=1)


def test_the_header_shows_version_engine_link_and_seed(run: Run) -> None:
    result = run(_SHOW, "--rcx-seed", "42")
    result.stdout.re_match_lines(
        [r"rcx-harness \d+\.\d+\.\d+: engine builtin, link direct, seed 42"]
    )


def test_without_a_program_the_message_says_where_to_name_it(run: Run) -> None:
    result = run(_SHOW, sources="")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["rcx: no program is named; write `rcx_sources = plc/*.st` into*"])


def _each_refused(run: Run, wrong: Mapping[str, str]) -> None:
    """Check that each marker is an error of its test, with one message."""
    tests = [
        f"@pytest.mark.rcx({marker})\ndef test_{number}(cell):\n    pass\n"
        for number, marker in enumerate(wrong)
    ]
    result = run("import pytest\n" + "".join(tests))
    result.assert_outcomes(errors=len(wrong))
    result.stdout.fnmatch_lines([f"rcx: {message}" for message in wrong.values()])
    assert len([line for line in result.outlines if line.startswith("rcx: ")]) == len(wrong)
    assert "Traceback" not in result.stdout.str()


def test_a_wrong_marker_is_one_message(run: Run) -> None:
    wrong = {
        "scann='5ms'": "*a cell has no option 'scann'*scan*",
        "'5ms'": "*takes names, not '5ms'*",
        "scan='5 parrots'": "*'5 parrots' is not a duration*",
        "sources='nothing/*.st'": "*no file is called nothing/*.st*",
        "robot='none.toml'": "*none.toml*",
        "size=47": "*47 bytes*",
    }
    _each_refused(run, wrong)


@pytest.mark.parametrize(
    ("options", "ini", "message"),
    [
        ([], {"seed": "many"}, "rcx_seed is 'many', not a whole number"),
        ([], {"size": "48 256"}, "rcx_size is '48 256', not a whole number"),
        ([], {"scan": "fast"}, "'fast' is not a duration"),
        ([], {"robot": "none.toml"}, "none.toml"),
        ([], {"sources": "nothing/*.st"}, "no file is called nothing"),
        ([], {"artifacts": "pytest.ini"}, "is not a folder"),
        (["--rcx-engine", "steam"], {}, "invalid choice: 'steam'"),
        (["--rcx-link", "rope"], {}, "invalid choice: 'rope'"),
        (["--rcx-seed", "many"], {}, "invalid int value: 'many'"),
        (["--rcx-scan", "fast"], {}, "'fast' is not a duration"),
        (["--rcx-robot", "none.toml"], {}, "none.toml"),
    ],
)
def test_a_wrong_option_or_key_of_the_ini_file_ends_the_run_with_one_message(
    run: Run, options: list[str], ini: dict[str, str], message: str
) -> None:
    result = run(_SHOW, *options, **ini)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*{message}*"])
    assert "Traceback" not in result.stderr.str() + result.stdout.str()


def test_a_refused_bare_number_is_explained_as_microseconds(run: Run) -> None:
    wrong = {
        "scan=5": "*the scan is 0.005 ms; *; a bare number is microseconds; write '5ms'",
        "rpi=10": "*the RPI is 0.01 ms; *; a bare number is microseconds; write '10ms'",
        "timeout=100": "*the time-out is 0.1 ms; *; a bare number is microseconds; write '100ms'",
        "scan='5us'": "*the scan is 0.005 ms; it must be 0.1 ms to 10000 ms",
    }
    _each_refused(run, wrong)


_DEVICES = """<project><types><pous/></types><instances><configurations>{devices}
</configurations></instances></project>"""
_DEVICE = """<configuration name="{name}"><resource name="Application">
<task name="Main" priority="5" interval="PT0.01S"><pouInstance name="{name}Program" typeName=""/>
</task><addData><data name="http://www.3s-software.com/plcopenxml/pou">
<pou name="{name}Program" pouType="program"><interface><localVars>
<variable name="n"><type><INT/></type></variable></localVars></interface>
<body><ST><xhtml>n := n + 1;</xhtml></ST></body></pou></data></addData></resource></configuration>
"""


def test_a_device_of_a_project_is_chosen_on_the_command_line_or_in_the_ini_file(
    run: Run, pytester: pytest.Pytester
) -> None:
    """A device of a project is selected by the command line or the ini file.

    Then the only remaining error is that the program of the device has no robot areas.

    Source: docs/how-to/testing.md.
    """
    devices = "".join(_DEVICE.format(name=name) for name in ("Press", "Oven"))
    pytester.makefile(".xml", plant=_DEVICES.format(devices=devices))
    test = "def test_it(cell):\n    pass\n"
    several = "*the project has several devices: Press and Oven; choose one*"
    run(test, sources="plant.xml").stdout.fnmatch_lines([several])
    for given in (
        run(test, "--rcx-device", "Oven", sources="plant.xml"),
        run(test, sources="plant.xml", device="Oven"),
    ):
        given.stdout.no_fnmatch_line(several)
        given.stdout.fnmatch_lines(["*OvenProgram*"])
