"""Projects in the style of four tools run with a robot that the user has added.

For each tool there is a machine program in the tool's file format. Its constructs are taken from
public projects. The user adds a block for the robot (`data/Robot_Cell.st`).
"""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.robot import Point
from structured_text.projects.open import project_sources

_ROBOT = Path(__file__).parent / "data/Robot_Cell.st"
_POINT = (120_000, -45_000, 30_000, 0, 0, 0)

# --- CODESYS: each object is text in its own file, as shown in the editor -------------------------

_CODESYS = {
    "E_Stage.st": "{attribute 'qualified_only'}\r\n{attribute 'strict'}\r\n\r\n// of the sorter\r\n"
    "TYPE E_Stage :\r\n(\r\n\tIdle := 0, // waits\r\n\tWeigh := 10,\r\n\tPush := 20\r\n);\r\n"
    "END_TYPE\r\n",
    "IO.st": "{attribute 'qualified_only'}\nVAR_GLOBAL\n\ti_Part : BOOL;\n\ti_Scale : INT;\n"
    "\ti_Out AT %IX9.0 : BOOL;\n\to_Push : BOOL;\nEND_VAR\n",
    "Limits.st": "VAR_GLOBAL CONSTANT\n\tLightest : INT := 300; // a box\nEND_VAR\n",
    "FB_Push.st": """\
FUNCTION_BLOCK FB_Push
VAR_INPUT
	start : BOOL; // pulse
END_VAR
VAR_OUTPUT
	done : BOOL;
END_VAR
VAR
	trigStart : R_TRIG;
	timer : TON := (PT := T#0.5S);
	state : INT := 0;
END_VAR

trigStart(CLK:=start);

CASE state OF

	0: // idle
		IF trigStart.Q THEN
			state := 10;
			done := FALSE;
		END_IF

	10:
		IO.o_Push := TRUE;
		timer(IN := TRUE);
		IF timer.Q THEN
			timer(IN := FALSE);
			IO.o_Push := FALSE;
			done := TRUE;
			state := 0;
		END_IF

END_CASE
""",
    "counted.st": "FUNCTION counted : BOOL\nVAR_INPUT\nEND_VAR\nVAR\nEND_VAR\n\n"
    "PLC_PRG.pushed := PLC_PRG.pushed + 1; // nothing is returned\n",
    "PLC_PRG.st": """\
PROGRAM PLC_PRG
VAR
	eStage : E_Stage;
	oneshot : ARRAY[0..30] OF BOOL;
	reset : ARRAY[0..30] OF BOOL;
	settle : TON := (PT := T#200MS);
	push : FB_Push;
	pushed : INT;
END_VAR

CASE eStage OF
	E_Stage.Idle:
	IF IO.i_Part THEN
		eStage := E_Stage.Weigh;
	END_IF;

	E_Stage.Weigh:
	settle(IN := TRUE);
	IF settle.Q AND (IO.i_Scale < Limits.Lightest) THEN
		settle(IN := FALSE);
		eStage := E_Stage.Push;
	END_IF

	E_Stage.Push:
	IF NOT oneshot[20] THEN
		oneshot := reset;
		oneshot[20] := TRUE;
		counted();
	END_IF
	push(start := TRUE);
	IF push.done THEN
		push(start := FALSE);
		eStage := E_Stage.Idle;
	END_IF;

ELSE // never
	eStage := E_Stage.Idle;
END_CASE;
""",
    "Robot_Prg.st": "PROGRAM Robot_Prg\nVAR\n\tCell : Robot_Cell;\nEND_VAR\n\n"
    "Cell(Release := IO.o_Push);\n",
}

_TASK = """\
CONFIGURATION Plant
  RESOURCE Plc ON PLC
    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM {main} WITH Cyclic : {main};
    PROGRAM Robot_Prg WITH Cyclic : Robot_Prg;
  END_RESOURCE
END_CONFIGURATION
"""

_ROBOT_MAIN = (
    "PROGRAM Robot_Prg\nVAR\n\tCell : Robot_Cell;\nEND_VAR\nCell(Release := {});\nEND_PROGRAM\n"
)

# --- TwinCAT: objects, interfaces in an array with initial value, a task --------------------------

_OBJECT = """\
\ufeff<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.12">
  <{tag} Name="{name}" Id="{{00000000-0000-0000-0000-000000000001}}">
{inside}
  </{tag}>
</TcPlcObject>
"""
_TWINCAT = {
    "DUTs/E_State.TcDUT": (
        "DUT",
        "    <Declaration><![CDATA[{attribute 'qualified_only'}\n{attribute 'strict'}\n"
        "TYPE E_State :\n(\n\tSTOPPED := 0,\n\tRUNNING\n) USINT;\nEND_TYPE\n]]></Declaration>",
    ),
    "POUs/IStation.TcIO": (
        "Itf",
        "    <Declaration><![CDATA[INTERFACE IStation\n]]></Declaration>\n"
        '    <Method Name="Execute" Id="{2}"><Declaration><![CDATA[METHOD Execute : BOOL\n'
        "VAR_INPUT\n\tbStart\t: BOOL;\nEND_VAR\n]]></Declaration></Method>",
    ),
    "POUs/FB_Station.TcPOU": (
        "POU",
        "    <Declaration><![CDATA[FUNCTION_BLOCK FB_Station IMPLEMENTS IStation\nVAR\n"
        "\ttmrWork\t: TON;\n\tbBusy\tAT %Q*\t: BOOL;\nEND_VAR\n]]></Declaration>\n"
        "    <Implementation>\n      <ST><![CDATA[]]></ST>\n    </Implementation>\n"
        '    <Method Name="Execute" Id="{3}"><Declaration><![CDATA[METHOD PUBLIC Execute : BOOL\n'
        "VAR_INPUT\n\tbStart\t: BOOL;\nEND_VAR\n]]></Declaration><Implementation><ST><![CDATA["
        "tmrWork(IN := bStart, PT := T#300MS);\nbBusy := bStart AND NOT tmrWork.Q;\n"
        "Execute := tmrWork.Q;]]></ST></Implementation></Method>",
    ),
    "POUs/MAIN.TcPOU": (
        "POU",
        "    <Declaration><![CDATA[PROGRAM MAIN\nVAR\n\tbStart\tAT %I*\t: BOOL;\n"
        "\teState\t: E_State;\n\tfbFill\t: FB_Station;\n\tfbCap\t: FB_Station;\n"
        "\tStations\t: ARRAY[0..1] OF IStation := [fbFill, fbCap];\n\ti\t: DINT;\n"
        "\tbReady\t: BOOL;\nEND_VAR\n]]></Declaration>\n"
        "    <Implementation>\n      <ST><![CDATA[CASE eState OF\n\tE_State.STOPPED:\n"
        "\t\tIF bStart THEN\n\t\t\teState := E_State.RUNNING;\n\t\tEND_IF\n\tE_State.RUNNING:\n"
        "\t\tbReady := TRUE;\n\t\tFOR i := 0 TO 1 DO\n"
        "\t\t\tIF Stations[i] <> 0 AND_THEN NOT Stations[i].Execute(bStart := TRUE) THEN\n"
        "\t\t\t\tbReady := FALSE;\n\t\t\tEND_IF\n\t\tEND_FOR\nEND_CASE]]></ST>\n"
        "    </Implementation>",
    ),
    "PlcTask.TcTTO": (
        "Task",
        "    <CycleTime>10000</CycleTime>\n    <Priority>20</Priority>\n"
        "    <PouCall>\n      <Name>MAIN</Name>\n    </PouCall>",
    ),
}
_PLCPROJ = (
    '<?xml version="1.0" encoding="utf-8"?>\n<Project DefaultTargets="Build" '
    'xmlns="http://schemas.microsoft.com/developer/msbuild/2003">\n  <ItemGroup>\n{}'
    "  </ItemGroup>\n</Project>\n"
)

# --- Rockwell: an instruction with a prescan, a ladder timer, a replaced ladder routine -----------

_L5X = """\
<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<RSLogix5000Content SchemaRevision="1.0" SoftwareRevision="33.00" TargetType="Controller">
<Controller Use="Target" Name="Plant" ProcessorType="1756-L83E">
<AddOnInstructionDefinitions>
<AddOnInstructionDefinition Name="Curve" Revision="1.0" ExecutePrescan="true">
<Parameters>
<Parameter Name="EnableIn" TagType="Base" DataType="BOOL" Usage="Input" Required="false"/>
<Parameter Name="EnableOut" TagType="Base" DataType="BOOL" Usage="Output" Required="false"/>
<Parameter Name="Raw" TagType="Base" DataType="REAL" Usage="Input" Required="true"/>
<Parameter Name="Value" TagType="Base" DataType="REAL" Usage="Output" Required="false"/>
</Parameters>
<LocalTags>
<LocalTag Name="Terms" DataType="REAL" Dimensions="3"/>
<LocalTag Name="Index" DataType="DINT"/>
</LocalTags>
<Routines>
<Routine Name="Logic" Type="ST"><STContent>
<Line Number="0"><![CDATA[(* looked up,]]></Line>
<Line Number="1"><![CDATA[   and rounded *)]]></Line>
<Line Number="2"><![CDATA[Index := Raw;]]></Line>
<Line Number="3"><![CDATA[if Index > 2 then Index := 2; end_IF;]]></Line>
<Line Number="4"><![CDATA[Value := Terms[Index] * 1.5 + ATAN(Raw);]]></Line>
</STContent></Routine>
<Routine Name="Prescan" Type="ST"><STContent>
<Line Number="0"><![CDATA[Terms[0] := 0.0; Terms[1] := 2.0;]]></Line>
<Line Number="1"><![CDATA[Terms[2] := 20.0;]]></Line>
</STContent></Routine>
</Routines>
</AddOnInstructionDefinition>
</AddOnInstructionDefinitions>
<Tags>
<Tag Name="Delay" TagType="Base" DataType="TIMER"><Data Format="Decorated">
<Structure DataType="TIMER">
<DataValueMember Name="PRE" DataType="DINT" Radix="Decimal" Value="2000"/>
<DataValueMember Name="DN" DataType="BOOL" Value="0"/>
</Structure></Data></Tag>
<Tag Name="Label" TagType="Base" DataType="STRING"/>
<Tag Name="Place" TagType="Base" DataType="DINT"/>
</Tags>
<Programs>
<Program Name="MainProgram" MainRoutineName="MainRoutine">
<Tags>
<Tag Name="Raw" TagType="Base" DataType="REAL"/>
<Tag Name="Limit" TagType="Base" DataType="REAL"><Data Format="Decorated">
<DataValue DataType="REAL" Radix="Float" Value="20.0"/></Data></Tag>
<Tag Name="Curve1" TagType="Base" DataType="Curve"/>
<Tag Name="Above" TagType="Base" DataType="BOOL"/>
</Tags>
<Routines>
<Routine Name="MainRoutine" Type="RLL"><RLLContent>
<Rung Number="0" Type="N"><Text><![CDATA[XIC(Above)TON(Delay,?,?);]]></Text></Rung>
</RLLContent></Routine>
<Routine Name="Check" Type="ST"><STContent>
<Line Number="0"><![CDATA[Curve(Curve1, Raw);]]></Line>
<Line Number="1"><![CDATA[IF (Curve1.Value > Limit) & NOT Delay.DN THEN Above := 1;]]></Line>
<Line Number="2"><![CDATA[ELSE Above := 0; END_IF;]]></Line>
<Line Number="3"><![CDATA[FIND(Label, 'b', 3, Place);]]></Line>
</STContent></Routine>
</Routines>
</Program>
</Programs>
<Tasks>
<Task Name="MainTask" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="MainProgram"/></ScheduledPrograms>
</Task>
</Tasks>
</Controller>
</RSLogix5000Content>
"""

# --- Siemens: sources of blocks, of data blocks, and the PLC tags ---------------------------------

_GATE = """\
\ufeffFUNCTION_BLOCK "Gate Controller"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
   VAR_OUTPUT
      fault : Bool;
      faultID : Int := -1;
   END_VAR

   VAR
      state : Int;
      prevStart : Bool;
   END_VAR


BEGIN
    REGION Start
        IF #prevStart = FALSE AND "startCMD" = TRUE AND #state = 0 THEN
            #state := 1;
        END_IF;
    END_REGION

    CASE #state OF
        1:
            "wireTimer".TON(IN := TRUE,
                            PT := T#100ms);
            "holdTimer".TOF(IN := TRUE, PT := T#1s);
            IF "wireTimer".Q = TRUE THEN
                "wireTimer".TON(IN := FALSE, PT := T#100ms);
                #state := 2;
            END_IF;
        2:
            IF BOOL_TO_INT("limitSwitch") + BOOL_TO_INT(NOT "ultrasonic") = 2 THEN
                "relay" := TRUE;
                "Log"."THIS"[1].Count += 1;
            ELSE
                #faultID := 4;
                #fault := TRUE;
            END_IF;
            #state := 0;
    END_CASE;
    "holdTimer".TOF(IN := FALSE, PT := T#1s);
    #prevStart := "startCMD";
END_FUNCTION_BLOCK

ORGANIZATION_BLOCK "Main"
TITLE = "Main Program Sweep (Cycle)"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
   VAR_TEMP
      faultID : Int;
   END_VAR


BEGIN
    "Gate_DB"(faultID=>#faultID);
END_ORGANIZATION_BLOCK

"""
_BLOCKS = """\
TYPE "Entry"
VERSION : 0.1
   STRUCT
      Count : Int;
   END_STRUCT;

END_TYPE

DATA_BLOCK "Log"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
NON_RETAIN
Array[0..3] of "Entry"

BEGIN

END_DATA_BLOCK

DATA_BLOCK "wireTimer"
{InstructionName := 'IEC_TIMER'; LibVersion := '1.0'; S7_Optimized_Access := 'TRUE' }
AUTHOR : Simatic
FAMILY : IEC
NAME : IEC_TMR
VERSION : 1.0
NON_RETAIN
IEC_TIMER

BEGIN

END_DATA_BLOCK

DATA_BLOCK "holdTimer"
{InstructionName := 'IEC_TIMER'; LibVersion := '1.0'; S7_Optimized_Access := 'TRUE' }
VERSION : 1.0
IEC_TIMER
BEGIN
END_DATA_BLOCK

DATA_BLOCK "Gate_DB"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 0.1
NON_RETAIN
"Gate Controller"

BEGIN

END_DATA_BLOCK

"""


def _write(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(text.encode("utf-8"))
    return file


def _cell(files: list[Path], replace: dict[str, str | Path] | None = None) -> Cell:
    return Cell.build(
        [*files, _ROBOT],
        engine="builtin",
        robot=RobotConfig(points={19: Point(_POINT)}),
        replace=replace,
    )


def _arrived(cell: Cell, moves: int) -> None:
    """Check that the robot executed the given number of moves and is at its point.

    Source: chapter 5, 4.1: the code, its options, two words of the speed, the point.
    """
    telegrams = [one.rcx_si[:10] for one in cell.trace.cycles()]
    begun = [new for old, new in pairwise(telegrams) if any(new[:2]) and not any(old[:2])]
    assert begun == [struct.pack("<5H", 0x0001, 4, 0, 50, 19)] * moves
    assert cell.commands == moves
    assert tuple(cell.robot.positions) == _POINT[: len(cell.robot.positions)]


def test_a_codesys_project_runs(tmp_path: Path) -> None:
    """A CODESYS project with types, global lists, nested blocks and a procedure runs."""
    files = [_write(tmp_path, name, text) for name, text in _CODESYS.items()]
    files.append(_write(tmp_path, "Task.st", _TASK.format(main="PLC_PRG")))
    with _cell(files) as cell:
        cell.run("500ms")
        assert cell["PLC_PRG.eStage"] == "Idle"
        cell["IO.i_Scale"] = 100
        cell["IO.i_Part"] = True
        cell.run("250ms")
        cell["IO.i_Part"] = False
        assert cell["PLC_PRG.eStage"] == "Push"
        assert cell["IO.o_Push"] is True
        cell.run("5s")
        assert cell["PLC_PRG.eStage"] == "Idle"
        assert cell["PLC_PRG.pushed"] == 1
        assert cell["Robot_Prg.Cell.Moves"] == 1
        _arrived(cell, 1)


def test_a_twincat_project_with_interfaces_runs(tmp_path: Path) -> None:
    """A TwinCAT project with an array of interfaces runs with the user's CONFIGURATION."""
    names = ""
    for name, (tag, inside) in _TWINCAT.items():
        text = _OBJECT.format(tag=tag, name=Path(name).stem, inside=inside)
        _write(tmp_path, f"Plc/{name}", text.replace("\n", "\r\n"))
        names += f'    <Compile Include="{name.replace("/", chr(92))}" />\n'
    project = _write(tmp_path, "Plc/Plc.plcproj", _PLCPROJ.format(names))
    robot = _write(tmp_path, "Robot_Prg.st", _ROBOT_MAIN.format("MAIN.bReady"))
    task = _write(tmp_path, "Task.st", _TASK.format(main="MAIN"))
    with _cell([project, robot], {"Tasks": task}) as cell:
        cell.run("500ms")
        assert cell["MAIN.Stations[1]"] == "MAIN.fbCap"
        cell["MAIN.bStart"] = True
        cell.run("100ms")
        assert (cell["MAIN.fbFill.bBusy"], cell["MAIN.bReady"]) == (True, False)
        assert cell.commands == 0
        cell.run("5s")
        assert (cell["MAIN.fbFill.bBusy"], cell["MAIN.bReady"]) == (False, True)
        _arrived(cell, 1)


def test_a_rockwell_project_with_a_replaced_ladder_routine_runs(tmp_path: Path) -> None:
    """A Rockwell project runs with a body of the user in place of its ladder routine.

    The value 20.0 * 1.5 + ATAN(2) is above the limit of 20; ATAN(1) + 3.0 is below this limit.
    """
    project = _write(tmp_path, "plant.L5X", _L5X)
    body = "Check();\nDelay.DN := Delay.ACC >= Delay.PRE;\nRobot(Release := Above);\n"
    own = _write(tmp_path, "main.st", body)
    tags = _write(tmp_path, "Robot_Tags.st", "VAR_GLOBAL\n  Robot : Robot_Cell;\nEND_VAR\n")
    with _cell([project, tags], {"MainProgram": own}) as cell:
        assert cell["Delay.PRE"] == 2000
        cell["Label"] = "b, b"
        cell["MainProgram.Raw"] = 1.0
        cell.run("500ms")
        assert cell["Place"] == 4
        assert cell["MainProgram.Curve1.Value"] == pytest.approx(3.0 + 0.785398)
        assert cell.commands == 0
        cell["MainProgram.Raw"] = 2.0
        cell.run("5s")
        assert cell["MainProgram.Curve1.Value"] == pytest.approx(30.0 + 1.107149)
        assert cell["Robot.Moves"] == 1
        _arrived(cell, 1)


def test_a_siemens_project_with_data_blocks_and_tags_runs(tmp_path: Path) -> None:
    """A Siemens project runs with its timers and an array in data blocks of another file."""
    tags = "startCMD, limitSwitch, ultrasonic, relay : BOOL;"
    files = [
        _write(tmp_path, "Gate.scl", _GATE),
        _write(tmp_path, "Blocks.scl", _BLOCKS),
        _write(tmp_path, "Tags.st", f"VAR_GLOBAL\n  {tags}\nEND_VAR\n"),
        _write(tmp_path, "Robot_Prg.st", _ROBOT_MAIN.format("relay")),
        _write(tmp_path, "Task.st", _TASK.format(main="Main")),
    ]
    with _cell(files) as cell:
        cell.run("500ms")
        assert cell["Gate_DB.faultID"] == -1
        cell["Tags.limitSwitch"] = True
        cell["Tags.startCMD"] = True
        cell.run("60ms")
        assert cell["Gate_DB.state"] == 1
        assert cell["holdTimer.Q"] is True  # a TOF is ON at once, a TON would be ON after 1 s
        assert cell["Tags.relay"] is False
        cell.run("5s")
        assert cell["Tags.relay"] is True
        assert cell["Log[1].Count"] == 1
        _arrived(cell, 1)


def test_an_unused_diagram_is_reported_in_the_project_file(tmp_path: Path) -> None:
    """The message about an unused diagram names the project file, not the user's file."""
    ladder = _L5X.replace("MainRoutineName", "Main", 0).replace(
        '<Routine Name="Check"', '<Routine Name="Spare" Type="SFC"/>\n<Routine Name="Check"'
    )
    project = _write(tmp_path, "plant.L5X", ladder)
    own = _write(tmp_path, "main.st", "Check();\n")
    notes = project_sources([project], {"MainProgram": own}).notes
    assert [note.partition(":")[0] for note in notes] == [str(project)]
