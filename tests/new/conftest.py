"""Enable pytest inside pytest, for the tests of a project that `rcx new` has written."""

from __future__ import annotations

import rcx_harness.testing.cells  # noqa: F401 - stays loaded from one inner run to the next
