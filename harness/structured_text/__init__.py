"""Structured Text on a PC: reads, runs, measures, proves, debugs and exports any program.

What surrounds a program (a process image, a machine, a stimulus) is given by whoever uses this
package; it imports nothing of them.
"""

try:  # what whoever ships this package calls it
    from structured_text_names import COMMAND, DISTRIBUTION
except ModuleNotFoundError:
    COMMAND, DISTRIBUTION = "st", "structured-text"

__all__ = ["BLOCKS", "COMMAND", "DISTRIBUTION", "VARIABLES"]

BLOCKS = f"{COMMAND.upper()}_"
"""What the names of blocks begin with that are added to a program."""
VARIABLES = COMMAND.capitalize()
"""What the names of variables begin with that are added to a program."""
