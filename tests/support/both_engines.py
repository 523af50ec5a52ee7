"""Fixtures for tests that must hold on both engines."""

from __future__ import annotations

import pytest

from rcx_harness.engine.load import MISSING, find_c_compiler, find_matiec

__all__ = ["ENGINES"]

_READY = find_matiec() is not None and find_c_compiler() is not None

#: The engines, as parameters of a test; without matiec its part is skipped.
ENGINES = [
    "builtin",
    pytest.param("matiec", marks=pytest.mark.skipif(not _READY, reason=MISSING)),
]
