"""Exports of CODESYS are read with tasks, devices, arguments of blocks, and replaced bodies.

The expected values come from the CODESYS help (Task Configuration, Editor 'Task'; Method FB_Init)
and from the XML schema of PLCopen TC6.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.bench import Bench
from structured_text.errors import InputError
from structured_text.language.load import analyse
from structured_text.language.portability import lint
from structured_text.projects.open import project_sources
from structured_text.projects.sources import source_files

_3S = "http://www.3s-software.com/plcopenxml"


def _pou(name: str, kind: str, variables: str, body: str, more: str = "") -> str:
    return (
        f'<pou name="{name}" pouType="{kind}"><interface><localVars>{variables}</localVars>'
        f"</interface>\n<body><ST><xhtml>{body}</xhtml></ST></body>{more}</pou>\n"
    )


def _variable(name: str, kind: str, more: str = "") -> str:
    return f'<variable name="{name}"><type>{kind}</type>{more}</variable>\n'


def _device(name: str, tasks: str, pous: str) -> str:
    return (
        f'<configuration name="{name}"><resource name="Application">{tasks}\n<addData>'
        f'<data name="{_3S}/pou">{pous}</data></addData></resource></configuration>\n'
    )


def _project(folder: Path, devices: str, pous: str = "") -> Path:
    file = folder / "plant.xml"
    file.write_text(
        f"<project><types><pous>{pous}</pous></types><instances><configurations>{devices}"
        "</configurations></instances></project>",
        encoding="utf-8",
    )
    return file


def _task(name: str, program: str, attributes: str = "", settings: str = "") -> str:
    return (
        f'<task name="{name}" priority="5" {attributes}><pouInstance name="{program}" typeName=""/>'
        f'<addData><data name="{_3S}/tasksettings"><TaskSettings {settings}/></data></addData>'
        "</task>\n"
    )


_COUNT = _pou("Count", "program", _variable("n", "<INT/>"), "n := n + 1;")
_MAIN = _pou("Cyclic", "program", _variable("go", "<BOOL/>") + _variable("k", "<INT/>"), "k := 1;")


@pytest.mark.parametrize(
    ("settings", "counts"),
    [
        ('KindOfTask="Event" Event="Cyclic.go"', [0, 1, 1, 1, 2]),
        ('KindOfTask="Status" Event="Cyclic.go"', [0, 1, 2, 2, 3]),
        ('KindOfTask="Freewheeling"', [1, 2, 3, 4, 5]),
    ],
)
def test_a_task_starts_by_its_variable(settings: str, counts: list[int], tmp_path: Path) -> None:
    """An event task runs at a rising edge of its variable, a status task while it is TRUE.

    A freewheeling task runs in each scan. In five scans the variable is FALSE, TRUE, TRUE,
    FALSE, TRUE.

    Source: CODESYS help, Editor 'Task', Type.
    """
    tasks = _task("Main", "Cyclic", 'interval="PT0.01S"') + _task("Edge", "Count", "", settings)
    file = _project(tmp_path, _device("Plc", tasks, _COUNT + _MAIN))
    with Bench.build(source_files(file, None), engine="builtin") as bench:
        found = []
        for value in (False, True, True, False, True):
            bench["Cyclic.go"] = value
            bench.scan()
            found.append(bench["Count.n"])
        assert found == counts


def test_a_task_of_the_standard_may_have_a_variable(tmp_path: Path) -> None:
    """A task of IEC 61131-3 may start at a rising edge of its SINGLE variable.

    Source: PLCopen TC6 XML 2.01: task, attribute single; IEC 61131-3, table 63: SINGLE.
    """
    tasks = '<task name="Edge" single="Cyclic.go" priority="1"><pouInstance name="Count"/></task>'
    tasks += '<task name="Main" interval="PT0.01S" priority="1"><pouInstance name="Cyclic"/></task>'
    file = _project(tmp_path, _device("Plc", tasks, _COUNT + _MAIN))
    with Bench.build(source_files(file, None), engine="builtin") as bench:
        bench["Cyclic.go"] = True
        bench.scan(3)
        assert bench["Count.n"] == 1


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ("", "an event that the file does not name starts the task Edge"),
        ('KindOfTask="ExternalEvent" ExternalEvent="CAN bus"', "the event CAN bus starts the task"),
    ],
)
def test_a_task_by_an_unknown_event_is_noted(settings: str, said: str, tmp_path: Path) -> None:
    """A task with an unknown event does not run and is noted, and the other task runs.

    A task that the user gives replaces both.

    Source: docs/how-to/projects.md.
    """
    tasks = _task("Main", "Cyclic", 'interval="PT0.01S"') + _task("Edge", "Count", "", settings)
    file = _project(tmp_path, _device("Plc", tasks, _COUNT + _MAIN))
    files = source_files(file, None)
    (note,) = files.notes
    assert said in note
    assert note.endswith("does not call Count; give other tasks by --replace Tasks=file.st")
    with Bench.build(files, engine="builtin") as bench:
        bench.scan(2)
        assert bench["Cyclic.k"] == 1
    own = tmp_path / "tasks.st"
    own.write_text(
        "CONFIGURATION C\nTASK T(INTERVAL := T#5ms);\nPROGRAM Count WITH T : Count;\n"
        "END_CONFIGURATION\n",
        encoding="utf-8",
    )
    files = source_files(file, None, {"tasks": own})
    assert files.notes == ()
    with Bench.build(files, engine="builtin") as bench:
        bench.scan(2)
        assert bench["Count.n"] == 2


def test_a_program_whose_only_task_has_an_unknown_event_can_be_checked(tmp_path: Path) -> None:
    """A program is checked even if its only task starts by an unknown event.

    Source: docs/how-to/projects.md.
    """
    file = _project(tmp_path, _device("Plc", _task("Edge", "Count"), _COUNT))
    project, errors = analyse(source_files(file, None).all)
    assert errors == []
    assert project is not None


def test_an_interval_may_be_only_in_the_settings_of_the_tool(tmp_path: Path) -> None:
    """If a task has no interval, the interval in the settings of CODESYS is used.

    Source: an export of CODESYS: Interval and IntervalUnit of TaskSettings.
    """
    settings = 'KindOfTask="Cyclic" Interval="2500" IntervalUnit="us"'
    tasks = _task("Main", "Count", 'interval="PT0S"', settings)
    project, _ = analyse(source_files(_project(tmp_path, _device("Plc", tasks, _COUNT)), None).all)
    assert project is not None
    assert [task.interval_us for task in project.tasks] == [2_500]


# --- devices ----------------------------------------------------------------------------------


def _two(folder: Path) -> Path:
    devices = ""
    for name, step in (("Press", 1), ("Oven", 5)):
        tasks = _task("Main", "Count", 'interval="PT0.01S"')
        pou = _pou("Count", "program", _variable("n", "<INT/>"), f"n := n + {step};")
        devices += _device(name, tasks, pou)
    return _project(folder, devices)


@pytest.mark.parametrize(("device", "n"), [("Press", 1), ("oven", 5), ("Oven.Application", 5)])
def test_a_device_is_chosen_by_its_name(device: str, n: int, tmp_path: Path) -> None:
    """If a project has several devices, the name of a device selects its program.

    Source: docs/how-to/projects.md.
    """
    files = source_files(_two(tmp_path), None, device=device)
    with Bench.build(files, engine="builtin") as bench:
        bench.scan()
        assert bench["Count.n"] == n


@pytest.mark.parametrize(
    ("device", "said"),
    [
        ("", "the project has several devices: Press and Oven; choose one: --device Press"),
        ("Furnace", "the project has no device Furnace; it has Press and Oven; choose one"),
    ],
)
def test_two_devices_are_one_message_with_both_names(
    device: str, said: str, tmp_path: Path
) -> None:
    """Without a choice between two devices, one message names both.

    Source: docs/how-to/projects.md.
    """
    with pytest.raises(InputError) as caught:
        source_files(_two(tmp_path), None, device=device)
    assert said in str(caught.value)
    assert caught.value.file == str(tmp_path / "plant.xml")


def test_a_device_without_programs_is_not_a_choice(tmp_path: Path) -> None:
    """Devices without programs, such as drives and couplers, need no choice of the user.

    Source: docs/how-to/projects.md.
    """
    device = _device("Plc", _task("Main", "Count", 'interval="PT0.01S"'), _COUNT)
    file = _project(tmp_path, '<configuration name="Drive"/>' + device)
    assert source_files(file, None).own
    with pytest.raises(InputError, match=r"no device Drive; it has Plc\.Application"):
        source_files(file, None, device="Drive")
    plain = tmp_path / "a.st"
    plain.write_text("PROGRAM P\nEND_PROGRAM\n", encoding="utf-8")
    with pytest.raises(InputError, match="--device is for projects of PLC tools"):
        source_files(plain, None, device="Drive")


# --- blocks with arguments, replaced bodies ---------------------------------------------------

_METHOD = (
    f'<addData><data name="{_3S}/method"><Method name="FB_Init"><interface><returnType><BOOL/>'
    f"</returnType><inputVars>{_variable('r', '<BOOL/>')}{_variable('c', '<BOOL/>')}"
    f"{_variable('K', '<INT/>')}{_variable('L', '<INT/>')}</inputVars></interface>"
    "<body><ST><xhtml>n := 10 * K + L;</xhtml></ST></body></Method></data></addData>"
)


def test_arguments_of_a_block_are_beside_its_variable(tmp_path: Path) -> None:
    """The project stores arguments of FB_Init beside the variable.

    The block gets 10 * 3 + (2 + 2) = 34.

    Source: CODESYS help, Methods FB_Init, FB_Reinit and FB_Exit: additional parameters.
    """
    assignments = (
        f'<addData><data name="{_3S}/inputassignments"><InputAssignments><InputAssignment>'
        "<Value>3</Value></InputAssignment><InputAssignment><Value>2 + 2</Value>"
        "</InputAssignment></InputAssignments></data></addData>"
    )
    block = _pou("Block", "functionBlock", _variable("n", "<INT/>"), ";", _METHOD)
    variable = _variable("b", '<derived name="Block"/>', assignments)
    main = _pou("Count", "program", variable, "b();")
    device = _device("Plc", _task("Main", "Count", 'interval="PT0.01S"'), block + main)
    with Bench.build(source_files(_project(tmp_path, device), None), engine="builtin") as bench:
        bench.scan()
        assert bench["Count.b.n"] == 34


def test_a_body_of_a_device_is_replaced(tmp_path: Path) -> None:
    """A file of the user replaces the statements of a POU on one device.

    Source: docs/how-to/projects.md.
    """
    own = tmp_path / "body.st"
    own.write_text("n := n + 7;\n", encoding="utf-8")
    files = source_files(_two(tmp_path), None, {"Count": own}, device="Oven")
    with Bench.build(files, engine="builtin") as bench:
        bench.scan()
        assert bench["Count.n"] == 7


def test_messages_on_a_replaced_pou_name_the_file_of_each_line(tmp_path: Path) -> None:
    """The project has the interface of a POU, and the user's file has its statements.

    A message names the file of its line.

    Source: docs/how-to/projects.md.
    """
    variables = _variable("n", "<INT/>") + _variable("x", '<derived name="AXIS"/>')
    pou = _pou("Count", "program", variables, "n := 1;")
    file = _project(tmp_path, "", pou)
    own = tmp_path / "body.st"
    own.write_text("n := 1;\nn := m;\n", encoding="utf-8")
    _, errors = analyse(project_sources([file], {"Count": own}).paths)
    assert [(Path(one.file or "").name, one.line, one.message) for one in errors] == [
        ("plant.xml", 2, "there is no type AXIS"),
        ("body.st", 2, "m is not declared"),
    ]


def test_warnings_on_a_replaced_pou_name_the_file_of_each_line(tmp_path: Path) -> None:
    """A warning names the file of its line.

    The variable in line 1 of the project has a name that is not portable.

    Source: docs/reference/language.md, portable subset.
    """
    file = _project(tmp_path, "", _pou("Count", "program", _variable("L", "<INT/>"), ";"))
    own = tmp_path / "body.st"
    own.write_text("\n\n\nL := 1;\n", encoding="utf-8")
    sources = project_sources([file], {"Count": own})
    said = [str(one) for one in lint(sources.paths)]
    assert all(one.startswith((f"{file}:1:", f"{own}:4:")) for one in said), said
