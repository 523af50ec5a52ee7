"""The virtual controller as an EtherNet/IP adapter, and a scanner to exchange its areas.

cpppo holds the adapter's objects; `objects` alone imports it, in the adapter's own process.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rcx_harness.enip.errors import CipError, EnipError, ProcessDiedError
    from rcx_harness.enip.links import LockstepLink
    from rcx_harness.enip.options import AdapterOptions, Identity
    from rcx_harness.enip.originator.client import Client
    from rcx_harness.enip.target.adapter import Adapter

_HOME = {"LockstepLink": "links", "Client": "originator.client", "Adapter": "target.adapter"}
_HOME |= dict.fromkeys(("CipError", "EnipError", "ProcessDiedError"), "errors")
_HOME |= dict.fromkeys(("AdapterOptions", "Identity"), "options")

__all__ = [
    "Adapter",
    "AdapterOptions",
    "CipError",
    "Client",
    "EnipError",
    "Identity",
    "LockstepLink",
    "ProcessDiedError",
]


def __getattr__(name: str) -> Any:
    """Import a name on first use, so that each process of the adapter loads only what it needs."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
