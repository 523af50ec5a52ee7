"""The manual's tables of signals, commands, alarms and errors, and telegrams in plain language."""

from rcx_harness.spec.tables import (
    Signal,
    alarms,
    command,
    command_name,
    commands,
    folder,
    public_alarms,
    signals,
    whole_number,
)
from rcx_harness.spec.telegram import Command, Field, FieldValue

__all__ = [
    "Command",
    "Field",
    "FieldValue",
    "Signal",
    "alarms",
    "command",
    "command_name",
    "commands",
    "folder",
    "public_alarms",
    "signals",
    "whole_number",
]
