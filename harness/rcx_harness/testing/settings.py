"""The settings of a test's cell. Their precedence is: marker, command line, ini file, defaults."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from difflib import get_close_matches
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cell import Cell
from rcx_harness.robot import RobotConfig
from rcx_harness.testing import OPTIONS, VALUES
from structured_text.engines.load import why_not
from structured_text.errors import InputError, did_you_mean, near
from structured_text.language.dialects import rules_of
from structured_text.output.units import parse_us
from structured_text.testing.settings import is_on, project

__all__ = ["RULES", "artifacts", "check_settings", "header", "known", "settings_of", "wrong_marker"]

#: Arguments of the marker and of `rcx_build`: the arguments of `Cell.build`, with `sources` instead
#: of `program`.
_INSIDE = ("program", "trace", "keep", "through")
_BUILD = inspect.signature(Cell.build).parameters
_KEYS = ("sources", *(name for name in _BUILD if name not in _INSIDE))

_ON_COMMAND_LINE = [name for name in OPTIONS if name != "artifacts"]
_IN_INI = [n for n in (*OPTIONS, *VALUES) if n not in ("robot", "watch", "artifacts")]
_NUMBERS = ("seed", "size", "m", "n")
_DURATIONS = ("scan", "rpi", "jitter")

#: All rules that can be reported as broken, grouped by the monitor that reports them.
RULES = {
    "monitor": (
        "interval",
        "start against stop",
        "reserved",
        "data before code",
        "command held",
        "ready before code",
    ),
    "contract": ("contract",),
    "calls": ("calls",),
    "robot": ("interval", "reserved", "ready-first", "hold-command"),
}

_NO_SOURCES = (
    "no program is named; write `rcx_sources = plc/*.st` into pytest.ini, or mark the test with "
    '@pytest.mark.rcx(sources="plc/*.st")'
)


def check_settings(config: pytest.Config) -> None:
    """Check the ini file and the command line before any test runs."""
    try:
        settings = dict(_of_run(config))
        for name in _DURATIONS:
            if name in settings:
                parse_us(settings[name])
        if "dialect" in settings:
            rules_of(settings["dialect"])
        for path in settings.get("robot", ()):
            RobotConfig.load(path)
        if "sources" in settings:
            _files(project(config), settings["sources"])
        _replacements(project(config), settings.get("replace", {}))
        folder = artifacts(config)
        if folder is not None and folder.exists() and not folder.is_dir():
            raise InputError("is not a folder", file=folder, hint="give another --rcx-artifacts")
        _engine(settings)
        if is_on(config, "coverage") and settings.get("engine", "auto") not in ("auto", "builtin"):
            hint = f"leave out the engine {settings['engine']}, or the coverage"
            from structured_text.coverage.output import ENGINE

            raise InputError(ENGINE, hint=hint)
    except InputError as error:
        raise pytest.UsageError(f"rcx: {error}") from None


def header(config: pytest.Config) -> str:
    """Return version, engine, link and seed in one line."""
    settings = _of_run(config)
    counts = is_on(config, "coverage") and settings.get("engine", "auto") == "auto"
    engine = "builtin (it counts coverage)" if counts else _engine(settings)
    parts = [f"engine {engine}", f"link {settings.get('link', 'direct')}"]
    parts += [f"seed {settings.get('seed', 0)}"]
    parts += [f"{name} {settings[name]}" for name in ("scan",) if name in settings]
    return f"rcx-harness {version('rcx-harness')}: {', '.join(parts)}"


def artifacts(config: pytest.Config) -> Path | None:
    """Return the folder for charts and traces of failed tests.

    None means pytest's temporary folder.
    """
    given = config.getoption("rcx_artifacts")
    if given is not None:
        return config.invocation_params.dir / str(given)
    named = config.getini("rcx_artifacts")
    return project(config) / str(named) if named else None


def known(changes: Mapping[str, Any]) -> None:
    """Raise InputError for arguments that `Cell.build` does not have."""
    for name in changes:
        if name not in _KEYS:
            raise InputError(f"a cell has no option {name!r}", hint=near(name, _KEYS, "use"))


def settings_of(item: pytest.Item, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `Cell.build` for a cell of this test.

    The nearest marker `rcx` has precedence over other markers. `changes` have precedence over all
    markers.
    """
    settings = dict(_of_run(item.config))
    for marker in reversed(list(item.iter_markers("rcx"))):
        if marker.args:
            raise InputError(
                f"@pytest.mark.rcx takes names, not {marker.args[0]!r}",
                hint='write it as @pytest.mark.rcx(scan="5ms")',
            )
        known(marker.kwargs)
        settings |= marker.kwargs
    known(changes)
    settings |= changes
    home = project(item.config)
    if "sources" not in settings:
        raise InputError(_NO_SOURCES)
    settings["program"] = _files(home, settings.pop("sources"))
    for name in ("robot", "lib"):
        if name in settings:
            settings[name] = _below(home, settings[name])
    if "replace" in settings:
        settings["replace"] = _replacements(home, settings["replace"])
    return settings


def _of_run(config: pytest.Config) -> dict[str, Any]:
    """Return the settings of ini file and command line. File names become absolute."""
    settings: dict[str, Any] = {}
    for name in ("sources", "watch", "robot", "replace"):
        if config.getini(f"rcx_{name}"):
            settings[name] = list(config.getini(f"rcx_{name}"))
    for name in _IN_INI:
        value = config.getini(f"rcx_{name}")
        if value:
            settings[name] = _number(name, value) if name in _NUMBERS else str(value)
    for name in ("robot", "lib"):
        if name in settings:
            settings[name] = _below(project(config), settings[name])
    for name in _ON_COMMAND_LINE:
        value = config.getoption(f"rcx_{name}")
        if value is not None:
            here = config.invocation_params.dir
            settings[name] = _below(here, value) if name == "robot" else value
    return settings


def _below(folder: Path, named: Any) -> Any:
    """Return one or several file names as paths below a folder. Return other values unchanged."""
    if isinstance(named, (str, Path)):
        return folder / named
    return [_below(folder, one) for one in named] if isinstance(named, (list, tuple)) else named


def _replacements(home: Path, given: Any) -> dict[str, Path]:
    """Return the replacement files by POU, from a table or from lines `POU=file.st`."""
    pairs = given.items() if isinstance(given, Mapping) else [_pair(str(one)) for one in given]
    return {name: home / file for name, file in pairs}


def _pair(text: str) -> tuple[str, str]:
    name, is_, file = (part.strip() for part in text.partition("="))
    if not (name and is_ and file):
        raise InputError(
            f"rcx_replace: {text!r} does not have the form POU=file.st",
            hint="write for example Main=cell/Main.st",
        )
    return name, file


def _number(name: str, value: object) -> int | list[int]:
    """Return a setting as a whole number. If areas of several robots are set, return a list."""
    try:
        numbers = [int(part) for part in str(value).split()]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        return numbers[0]
    if not numbers or name not in ("m", "n"):
        raise InputError(f"rcx_{name} is {value!r}, not a whole number")
    return numbers


def _files(home: Path, sources: Any) -> list[Path]:
    """Return the files that names, patterns and folders select, in the given order."""
    found: list[Path] = []
    for source in [sources] if isinstance(sources, (str, Path)) else sources:
        place = home / source
        if place.exists():
            found.append(place)
            continue
        try:
            matching = sorted(home.glob(str(source)), key=lambda file: file.parts)
        except (NotImplementedError, ValueError):  # the pattern is absolute or empty
            matching = []
        if not matching:
            raise InputError(f"no file is called {source}", file=home, hint="correct rcx_sources")
        found += matching
    return list(dict.fromkeys(found))


@lru_cache(maxsize=1)
def _auto_engine() -> str:
    return "builtin" if why_not("matiec") else "matiec"


def _engine(settings: Mapping[str, Any]) -> str:
    """Return the name of the engine. If it was chosen automatically, add the reason."""
    engine = str(settings.get("engine", "auto"))
    if engine != "auto":
        return engine
    if "dialect" in settings and not rules_of(settings["dialect"]).is_matiec:
        return f"builtin (dialect {settings['dialect']})"
    found = _auto_engine()
    return found if found == "matiec" else "builtin (matiec not found)"


def wrong_marker(marker: pytest.Mark) -> str:
    """Return a text about the mistake in a marker `allow_violations`. Empty if there is none."""
    names = list(dict.fromkeys(name for some in RULES.values() for name in some))
    every = f"the rules are: {', '.join(names)}"
    if marker.kwargs:
        written = ", ".join(f"{name}=" for name in marker.kwargs)
        hint = 'write it as @pytest.mark.allow_violations("interval")'
        return f"@pytest.mark.allow_violations takes names of rules, not {written}; {hint}"
    for rule in marker.args:
        if rule not in names:
            near = get_close_matches(rule, names) if isinstance(rule, str) else []
            return f"there is no rule {rule!r}; {did_you_mean(near) or every}"
    return ""
