"""What the package structured_text is called here: it has no names of its own."""

__all__ = ["COMMAND", "DISTRIBUTION"]

COMMAND = "rcx"
"""The command that users know it by, for messages and the names of files."""
DISTRIBUTION = "rcx-harness"
"""What is installed to have it."""
