"""Instructions that read or set values of the controller: GSV, SSV and EVENT.

No statement can compute these values. The destination of a GSV keeps its value, so that a test can
set it; a note names each instruction.
"""

from __future__ import annotations

from structured_text.errors import COMMAND

__all__ = ["SYSTEM_HINT", "is_known_class", "note_of"]

#: Objects of the controller whose values a program can read.
_CLASSES = frozenset(
    (
        "CONTROLLER",
        "CONTROLLERDEVICE",
        "CST",
        "FAULTLOG",
        "MODULE",
        "PROGRAM",
        "TASK",
        "TIMESYNCHRONIZE",
        "WALLCLOCKTIME",
    )
)
#: What to do with an instruction that is not supported.
SYSTEM_HINT = (
    f"write the routine in Structured Text with a block of your own instead: {COMMAND} "
    "--replace Program.Routine=file.st"
)


def is_known_class(name: str) -> bool:
    """Return whether GSV and SSV of a class of objects are read."""
    return name.upper() in _CLASSES


def note_of(name: str, *operands: str) -> str:
    """Return the note about GSV, SSV or EVENT with its operands."""
    if name == "EVENT":
        text = "because a task of events does not run"
        return f"EVENT does not start the task {operands[0]}, {text}"
    kind, instance, attribute, tag = operands
    what = f"{kind} {instance}".strip() + f", {attribute}"
    effect = (
        f"does not read it, and {tag} keeps its value; a test can set it"
        if name == "GSV"
        else "does not set it"
    )
    return f"{name} of {what} {effect}"
