"""What is closed at the end of a `with`."""

from __future__ import annotations

from typing import TypeVar

__all__ = ["Closing"]

_Own = TypeVar("_Own", bound="Closing")


class Closing:
    """Something with a `close` that does no harm more than once."""

    def close(self) -> None:
        """End it."""
        raise NotImplementedError

    def __enter__(self: _Own) -> _Own:
        """It, at work."""
        return self

    def __exit__(self, *of: object) -> None:
        """End it."""
        self.close()
