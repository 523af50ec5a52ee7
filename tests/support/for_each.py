"""Run a short test for each value of a list, in one item of pytest.

An item of pytest costs some milliseconds. A check of a table that takes less time than that is one
item for the whole table. `pytest.mark.parametrize` stays the choice for all other tests.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

__all__ = ["for_each"]


def for_each(
    names: str, values: Iterable[Any]
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Return a decorator that calls a test once for each value, and reports all that fail.

    Args:
        names: Names of the test's arguments, separated by commas.
        values: Values of the argument; tuples of values if there are several names.

    Raises:
        AssertionError: The test failed for some values; the message names them, and the cause is
            the first failure.
    """
    arguments = [name.strip() for name in names.split(",")]
    every = [value if len(arguments) > 1 else (value,) for value in values]
    assert every, "a test without values tests nothing"

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def run(**fixtures: Any) -> None:
            failed: list[tuple[str, Exception]] = []
            for value in every:
                given = dict(zip(arguments, value, strict=True))
                try:
                    test(**fixtures, **given)
                except Exception as error:
                    failed.append((", ".join(map(str, value)), error))
            if failed:
                told = "\n".join(f"{value}: {error}" for value, error in failed)
                count = f"{len(failed)} of {len(every)} values"
                raise AssertionError(f"{count} failed:\n{told}") from failed[0][1]

        signature = inspect.signature(test)
        own = [item for name, item in signature.parameters.items() if name not in arguments]
        run.__signature__ = signature.replace(parameters=own)  # type: ignore[attr-defined]
        return run

    return decorate
