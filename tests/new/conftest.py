"""Load the plugin `pytester`, which runs the tests of a project written by `rcx new`."""

from __future__ import annotations

import rcx_harness.testing.cells  # noqa: F401 - stays loaded from one inner run to the next
