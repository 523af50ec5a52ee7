"""Robot programs: their reader, their checks and their execution.

A program is text in the language of the controller. `reader` translates the text to a `Program`,
which is flat code with jumps. `checks` reports errors before the program runs. `execution` executes
one instruction for a `task`; the table of tasks is in robot/tasks.py. A statement that moves the
robot is executed as the equivalent remote command (`movements`).
"""

from rcx_harness.robot.program.reader import read_file, read_lines, read_program, text_of
from rcx_harness.robot.program.syntax import Program

__all__ = ["Program", "read_file", "read_lines", "read_program", "text_of"]
