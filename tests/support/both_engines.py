"""Parameters for tests that must hold on each engine."""

from __future__ import annotations

import pytest

from structured_text.engines.load import why_not


def needs(engine: str) -> pytest.MarkDecorator:
    """Return a mark that skips a test if this engine is not installed."""
    reason = why_not(engine)
    return pytest.mark.skipif(bool(reason), reason=reason)


#: External engines. Their tests are skipped if they are not installed.
COMPILED = [pytest.param(name, marks=needs(name)) for name in ("matiec", "strucpp")]
ENGINES = ["builtin", *COMPILED]
