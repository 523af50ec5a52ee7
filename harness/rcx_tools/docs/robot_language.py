"""Generator of robot-language.md: the statements of robot programs, each with its source."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rcx_harness.robot.program.expressions import FUNCTIONS
from rcx_harness.robot.program.syntax import OPTIONS
from rcx_harness.robot.program.words import Word, words

__all__ = ["robot_language_page"]

_HEAD = """\
<!-- generated from harness/rcx_harness/robot/program/statements.toml by `make docs` -->

# The robot's own language

The virtual controller executes robot programs. They run on its 5 ms clock, beside the remote
commands and with the same movements. `rcx check MAIN.PGM` checks a program; a robot file names
it:

```toml
[[programs]]
file = "MAIN.PGM"          # the name is MAIN; the first program is the main program

[points.1]
mm = [100.0, 50.0, 0.0, 0.0]
```

`data_file = "CELL.ALL"` at the top of a robot file brings the programs, points, comments, shifts,
hands, pallets, variables and parameters of a file with all data of a controller. What the robot
file has itself comes first. `rcx points` reads and writes the data sections of such a file.

**The vendor's programming manual has the last word.** It was not at hand. The column "Source"
says where each statement comes from:

- guide: the remote command guide or chapter 3 of the manual defines what it does.
- public: public programs use it in this form.
- assumed: general knowledge of this family of controllers. Check it before you rely on it.

## A program

```text
*LOOP:
  WAIT SI(20)=1                 ' the PLC asks for a part
  MOVE P,P1,S=50
  MOVE L,P2,VEL=200
  WAIT ARM                      ' the movement has ended, not only come near
  SO(20)=1
  WAIT SI(20)=0
  SO(20)=0
GOTO *LOOP
```

- One statement a line, or several with `:` between them. `'` begins a comment. Upper and lower
  case mean the same.
- Labels are `*NAME:`. Numbers are decimal, `&H1F` or `&B101`.
- Variables are `A%` (integer of 32 bits), `A!` (real), `A$` (text), and `A`, which is real
  (`plain_variables`). `SGI0` to `SGI31` and `SGR0` to `SGR31` belong to all programs and remote
  commands.
- Points are `P10` or `P[A%+1]`, shifts `S1`, hands `H1`. Six numbers are a point: in mm if one of
  them has a decimal point, else in pulses.
- Inputs and outputs are `SI(20)`, `SI2()`, `SI2(3,1)`, `SIW(2)`, `SID(2)`, and `SO`, `DI`, `DO`,
  `MO`, `LO` and `TO` likewise. Of several bits the first is the highest.
- Operators, the strongest first: `^`; `-` before a value; `*`, `/`, `MOD`; `+`, `-`; comparisons;
  `NOT` or `~`; `AND` or `&`; `OR` or `|`; `XOR`. A true comparison is -1.
"""

_MOVEMENT = """\
## Movements

Each movement is the remote command of the same name, with its limits, times and alarms.

- The next statement begins when all axes are in the OUT position range (parameter OUTPOS). `WAIT
  ARM` waits for the end. The next movement waits for the end, too. With `CONT` it begins in the
  OUT position range.
- Several axes of one `DRIVE` or `DRIVEI` start and end together.
- `PATH SET` begins a path at the place of the robot, or at a point. `PATH L` and `PATH C` add lines
  and arcs with their own speeds, `PATH END` ends it. `PATH START` follows it without a stop between
  the parts; at a corner the tool is as slow as the accelerations of the axes demand. The robot must
  stand within OUTPOS of the start of the path, else the program gets an alarm.
- `STOPON condition` ends a movement early. `SO(20)=1@30.0` turns an output ON when the tool has
  moved 30 mm on a line or an arc.
- `A3=100.0{10.0,20.0}` moves in an arch with axis 3: arch position, arch distances 1 and 2.
- A stop ends the movement. The next start repeats the statement from where the robot stands;
  `PATH START` follows the rest of its path.
"""

_TIMES = """\
## Times and errors

A task executes at most `program_statements` (100) statements in a cycle of 5 ms. A loop without a
wait therefore slows down only itself; `rcx check` names its line.

`rcx check`, `rcx run` and all other commands that read a program refuse a value of a wrong type, a
function with a wrong number of arguments, and an array without DIM, with the line, before the
program runs.

An error, such as an undefined point or a division by 0, jumps to the label of `ON ERROR GOTO`.
Without one it stops the programs. The alarm is in the history. It is the one of the remote
command where there is one. The numbers 5.997 to 5.999 are not the vendor's: `PATH START` without a
path or away from its start, too many `GOSUB` in each other, and a value of a wrong type.

A program that an error has stopped is a finding: `rcx run` counts it and ends with exit code 1. A
stop input, an emergency stop and an alarm of the controller are not errors of a program.

## A file with all data (.ALL)

It is read leniently; `rcx check CELL.ALL` names what was passed over. No public file was at hand,
so the format is assumed, too.

```ini
[PGM]
NAME=MAIN
MOVE P,P1
[PNT]
P1=100.00 50.00 0.00 0.00 0.00 0.00
[PCM]
PC1=PICK
[SFT]
S1=1.00 2.00 3.00 4.00
[HND]
H1=0.00 150.00 15.00 R
[PLT]
PL3
NX=2 NY=3 NZ=1 PLP=100
[PRM]
/ACCEL/
A1=80 A2=70
/WEIGHTG/
R1=1500
[SGI]
SGI5=50
[SGR]
SGR5=0.5
```

Of the parameters those of the remote command guide (4.4.2) are read: `A1=` is axis 1 of the
controller, `R1=` robot 1.

The assumed rules and their keys are in [fidelity.md](../explanation/fidelity.md), rule robot-
language.
"""


def robot_language_page() -> str:
    """Return robot-language.md as Markdown."""
    return "\n".join([_HEAD, *_statements(), _MOVEMENT, _options(), _functions(), _TIMES])


def _statements() -> Iterator[str]:
    """Yield a table for each group of statements."""
    yield "## Statements\n"
    for group in dict.fromkeys(word.group for word in words().values()):
        entries = [word for word in words().values() if word.group == group]
        yield f"### {group.capitalize()}\n"
        yield from _refused(entries) if group == "not executed" else _table(entries)
        yield ""


def _table(entries: Sequence[Word]) -> Iterator[str]:
    yield "| Statement | Effect | Source |"
    yield "|---|---|---|"
    for word in entries:
        form = word.form.replace("|", "\\|")
        yield f"| `{form}` | {word.text} | {word.source} |"


def _refused(entries: Sequence[Word]) -> Iterator[str]:
    yield "These are refused with their line before the program runs."
    yield ""
    yield "| Statement | Instead |"
    yield "|---|---|"
    for word in entries:
        yield f"| `{word.name}` | {word.instead} |"


def _options() -> str:
    names = ", ".join(f"`{name}=`" for name in OPTIONS)
    return f"Options: {names}, `STOPON`, `CONT`.\n"


def _functions() -> str:
    names = ", ".join(f"`{name}`" for name in sorted(FUNCTIONS))
    return (
        f"## Functions\n\n{names}. Angles are in radians. "
        "`TCOUNTER` counts ms since power-on or `RESET TCOUNTER`, `TIMER` seconds since midnight. "
        "`LOC1` is `LOCX`. `ERR` and `ERL` are the alarm (as &HGGGGCCCC) and the line of the last "
        "error that was handled; `ERR(2)` is that of task 2.\n"
    )
