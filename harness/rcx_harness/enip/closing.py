"""A base class of objects that a `with` statement closes."""

from __future__ import annotations

from typing import TypeVar

__all__ = ["Closing"]

_Own = TypeVar("_Own", bound="Closing")


class Closing:
    """An object with a `close` method that may be called more than once."""

    def close(self) -> None:
        """Close the object and free its resources; a second call does nothing."""
        raise NotImplementedError

    def __enter__(self: _Own) -> _Own:
        """Return the object itself as the target of the `with` statement."""
        return self

    def __exit__(self, *of: object) -> None:
        """Close the object at the end of the `with` statement."""
        self.close()
