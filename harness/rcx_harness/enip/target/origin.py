"""Where a request comes from, as far as the answer depends on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Origin"]


@dataclass
class Origin:
    """The sender of one request.

    Attributes:
        peer: Its IPv4 address.
        local: Our IPv4 address that it has reached.
        session: Handle of its session; an explicit connection lives as long as that.
        addresses: Socket address items it has sent along, by their type.
        items: Socket address items to send along with the reply; filled by who answers.
    """

    peer: str = "127.0.0.1"
    local: str = "127.0.0.1"
    session: int = 0
    addresses: Mapping[int, bytes] = field(default_factory=dict)
    items: list[tuple[int, bytes]] = field(default_factory=list)
