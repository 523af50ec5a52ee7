"""The virtual controller as an EtherNet/IP adapter, and a scanner to exchange its areas.

cpppo holds the adapter's objects; `objects` alone imports it, in the adapter's own process.
"""

from __future__ import annotations

from rcx_harness.enip.errors import CipError, EnipError, ProcessDiedError
from rcx_harness.enip.links import LockstepLink
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter

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
