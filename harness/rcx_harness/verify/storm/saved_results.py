"""Saved results of earlier calls. The next call continues with them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rcx_harness.verify.storm.campaign import Explained, Seed, Unexplained
from rcx_harness.verify.storm.replay import Replay
from rcx_harness.verify.storm.sweep import Moments, Shown
from structured_text.errors import InputError
from structured_text.farm import ResultFile
from structured_text.output.limits import MOST_LINE_BYTES, OTHER
from structured_text.output.reading import open_file

__all__ = ["saved_results"]

#: Parts of the result of a seed that are left out if they are empty.
_EMPTY = ("lines", "reached")


def saved_results(file: Path, about: Mapping[str, str]) -> tuple[ResultFile[Any, Any], str]:
    """Return the saved results in a file, and a notice if they must be computed again.

    The results depend on the files and options in `about`.

    Raises:
        InputError: The file exists, and this program has not written it.
    """
    fresh = _rests_on_other(file, about)
    kept: ResultFile[Any, Any] = ResultFile(
        file, about, key=_key, to_json=_to_json, from_json=_from_json, fresh=fresh
    )
    notice = f"{file}: results of other files or options; all is run anew" if fresh else ""
    return kept, notice


def _rests_on_other(file: Path, about: Mapping[str, str]) -> bool:
    """Return whether the file contains results for other files or options."""
    try:
        with open_file(file, OTHER) as stream:
            first = json.loads(stream.readline(MOST_LINE_BYTES))
        return bool(first["about"] != dict(about))
    except (InputError, ValueError, TypeError, KeyError, RecursionError):
        return False


def _key(item: Any) -> str:
    if isinstance(item, Moments):
        return f"{item.inject.name} {item.inject.held_us} {item.first} {item.end} {item.step}"
    if isinstance(item, Shown):
        return f"shown {item.inject.name} {item.inject.held_us} {item.scan} {item.kind}"
    if isinstance(item, Unexplained):
        return f"{item.kind}: {','.join(map(str, item.seeds))}"
    return str(item)


def _to_json(result: Any) -> Any:
    if isinstance(result, Replay) or result is None:
        return {"shown": None if result is None else asdict(result)}
    if isinstance(result, dict):
        return {"failing": result}
    if isinstance(result, Explained):
        told = None if result.replay is None else asdict(result.replay)
        return {**result._asdict(), "replay": told}
    return {key: value for key, value in result._asdict().items() if value or key not in _EMPTY}


def _from_json(given: Any) -> Any:
    if "shown" in given:
        return None if given["shown"] is None else Replay(**given["shown"])
    if "failing" in given:
        return {int(scan): found for scan, found in given["failing"].items()}
    if "replay" in given:
        told = None if given["replay"] is None else Replay(**given["replay"])
        lists = (tuple(given[name]) for name in ("causes", "rest", "seeds"))
        return Explained(told, *lists)
    failures = {kind: (t_us, text) for kind, (t_us, text) in given["failures"].items()}
    lines = tuple((number, name, line) for number, name, line in given.get("lines", ()))
    reached = tuple(given.get("reached", ()))
    return Seed(failures, given["virtual_us"], given["scans"], given["acts"], lines, reached)
