"""Robot programs: their reader, their checks and their execution.

A program is text in the language of the controller. `reader` makes a `Program` of it, a flat code
with jumps. `checks` finds what cannot work. `execution` executes one instruction for a task; the
tasks themselves are in robot/tasks.py. Movements are the remote commands that do the same.
"""

from rcx_harness.robot.program.reader import read_file, read_lines, read_program, text_of
from rcx_harness.robot.program.syntax import Program

__all__ = ["Program", "read_file", "read_lines", "read_program", "text_of"]
