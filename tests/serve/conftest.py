"""Fixtures of the tests of `rcx serve`."""

from __future__ import annotations

import pytest

from served import ServedHost, image


@pytest.fixture
def served() -> ServedHost:
    """Return a served controller whose master has set SI(00) and SI(06) to ON."""
    host = ServedHost()
    host.network.send(image(0x01))
    host.run(150)
    host.network.send(image(0x41))
    host.run(150)
    return host
