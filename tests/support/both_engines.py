"""The engines as parameters of tests that must hold on each of them."""

from __future__ import annotations

import pytest

from structured_text.engines.load import why_not


def needs(engine: str) -> pytest.MarkDecorator:
    """Skip a test if an engine is not installed."""
    reason = why_not(engine)
    return pytest.mark.skipif(bool(reason), reason=reason)


#: The engines that are another's work; those that are not installed are skipped.
COMPILED = [pytest.param(name, marks=needs(name)) for name in ("matiec", "strucpp")]
ENGINES = ["builtin", *COMPILED]
