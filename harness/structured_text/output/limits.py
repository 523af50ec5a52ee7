"""The limits of files and programs, defined here only.

They lie well above real projects and well below the memory of a small computer.
docs/reference/limits.md explains each limit to users and what to do; a test compares the numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "CAPTURE",
    "MOST_BLOCKS",
    "MOST_CHARACTERS",
    "MOST_ELEMENTS",
    "MOST_LEVELS",
    "MOST_LINE_BYTES",
    "MOST_MISTAKES",
    "MOST_NESTED",
    "MOST_REPLAYED_US",
    "MOST_TOKENS",
    "MOST_TOOL_S",
    "MOST_TRACE_US",
    "MOST_WATCHED",
    "OTHER",
    "PROJECT",
    "SOURCE",
    "TABLE",
    "TRACE",
    "Kind",
]

_MEGABYTE = 1 << 20


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Attributes:
        name: Name of the kind in messages.
        most_bytes: Maximum size; None for files that are read piece by piece.
        hint: Advice for a user with a larger file.
    """

    name: str
    most_bytes: int | None
    hint: str = ""


#: The limit of a file of Structured Text or SCL. The whole OSCAT library is 3 MB.
SOURCE = Kind("a source", 8 * _MEGABYTE, "divide it into several files")
#: The limit of a file of XML or L5X, which may contain diagrams, pictures and trends.
PROJECT = Kind("a project file", 128 * _MEGABYTE, "export only the part that is needed")
#: The limit of a TOML file: robot, stimulus, properties, points or reasons.
TABLE = Kind("a TOML file", 16 * _MEGABYTE, "divide it, or leave out what is not needed")
#: Traces are read line by line, and captures packet by packet, so they have no limit. A trace of
#: several hours has some gigabytes.
TRACE = Kind("a trace", None)
CAPTURE = Kind("a capture", None)
#: The limit of other files: recordings of failed tests, results of campaigns, earlier reports.
OTHER = Kind("a file", 512 * _MEGABYTE, "name another file")

#: Greatest number of characters, and of tokens, in all sources of a program together.
MOST_CHARACTERS = 32 * _MEGABYTE
MOST_TOKENS = 2_000_000
#: Greatest number of bytes of one line of a trace or recording.
MOST_LINE_BYTES = 16 * _MEGABYTE

#: Greatest number of elements of all variables of a program. language/extent.py defines how they
#: are counted.
MOST_ELEMENTS = 4_000_000
#: Greatest number of function block instances in a program, including instances inside others.
MOST_BLOCKS = 200_000
#: Greatest length of a chain of types, functions, blocks and constants in which each uses the next.
MOST_LEVELS = 100
#: Greatest nesting depth of arrays, structures and blocks, including types without a name.
MOST_NESTED = 120
#: Greatest number of reported mistakes of one file, and of all files together.
MOST_MISTAKES = 500

#: Longest time for another tool (matiec, STruC++, a C compiler) to translate one program [s].
MOST_TOOL_S = 900

#: Greatest number of elementary variables that can be watched, and that a pattern examines.
MOST_WATCHED = 100_000

#: Longest time between the first and the last record of a trace or capture.
MOST_TRACE_US = 366 * 86_400_000_000
#: Longest time of a recording that is replayed in cycles of 5 ms.
MOST_REPLAYED_US = 24 * 3_600_000_000
