"""The settings of the language server, which an editor gives in its `initializationOptions`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from structured_text.errors import InputError, did_you_mean, similar
from structured_text.export.refused import tools
from structured_text.language.dialects import rules_of

__all__ = ["Settings"]

#: Settings with another name in Python, because the name is a keyword of Python.
_NAMES: dict[Any, str] = {"for": "tool"}
#: Longest pause that makes sense [ms].
_LONGEST_PAUSE = 60_000


@dataclass(frozen=True)
class Settings:
    """The settings of the language server.

    Attributes:
        files: The sources of the program: files, projects or folders, relative to the workspace.
            Empty: the folder of the workspace.
        lib: Folder of the library; empty: the library of the package.
        tool: The PLC tool for which the program is; what it refuses is reported.
        dialect: The PLC tool whose behaviour the program gets; empty: the tool of its format.
        replace: Files with Structured Text for POUs of a project, by name.
        device: The device to read if a project has several devices.
        pause: Time without a change before a check [ms].
    """

    files: tuple[str, ...] = ()
    lib: str = ""
    tool: str = ""
    dialect: str = ""
    replace: Mapping[str, str] = field(default_factory=dict)
    device: str = ""
    pause: int = 150

    @classmethod
    def of(cls, options: Any) -> Settings:
        """Return the settings that an editor gives; raise InputError for a wrong one."""
        if options is None:
            return cls()
        if not isinstance(options, Mapping):
            raise InputError("the settings are not an object with names and values")
        names = [{"tool": "for"}.get(one.name, one.name) for one in fields(cls)]
        found: dict[str, Any] = {}
        for key, value in options.items():
            if key not in names:
                hint = did_you_mean(similar(str(key), names)) or f"use {', '.join(names)}"
                raise InputError(f"there is no setting {key}", hint=hint)
            if value is not None:
                found[_NAMES.get(key) or key] = _checked(key, value)
        return cls(**found)

    def within(self, folder: Path) -> Settings:
        """Return the settings with names of files that begin at a folder."""
        return replace(
            self,
            files=tuple(str(folder / one) for one in self.files),
            lib=str(folder / self.lib) if self.lib else "",
            replace={name: str(folder / one) for name, one in self.replace.items()},
        )


def _checked(key: str, value: Any) -> Any:
    """Return the value of a setting; raise InputError if it is of another kind."""
    if key == "files":
        several = [value] if isinstance(value, str) else value
        if not isinstance(several, list) or not all(isinstance(one, str) for one in several):
            raise InputError("the setting files is not a list of names")
        return tuple(several)
    if key == "replace":
        if not isinstance(value, Mapping) or not all(
            isinstance(one, str) for one in value.values()
        ):
            raise InputError("the setting replace is not an object: the name of a POU, and a file")
        return dict(value)
    if key == "pause":
        if (
            isinstance(value, bool)
            or not isinstance(value, int)
            or not 0 <= value <= _LONGEST_PAUSE
        ):
            raise InputError(f"the setting pause is not a number from 0 to {_LONGEST_PAUSE} [ms]")
        return value
    if not isinstance(value, str):
        raise InputError(f"the setting {key} is not a text")
    if key == "for" and value and value not in tools():
        raise InputError(f"for {value}: no such tool", hint=f"use {', '.join(tools())}")
    if key == "dialect" and value:
        return rules_of(value).name
    return value
