"""A recording as one page of HTML that is looked at in a browser."""

from rcx_harness.trace.view.page import BEGINNING, View

__all__ = ["BEGINNING", "View"]
