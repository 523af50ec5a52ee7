"""Structured Text on a PC: reads, runs, measures, proves, debugs and exports any program.

What surrounds a program (a process image, a machine, a stimulus) is given by whoever uses this
package; it imports nothing of them.
"""

__all__ = ["COMMAND", "DISTRIBUTION"]

COMMAND = "rcx"
"""The command that users know this package by, for messages and the names of files."""
DISTRIBUTION = "rcx-harness"
"""What is installed to have it."""
