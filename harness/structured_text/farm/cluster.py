"""Where a cluster of dask.distributed is, and how it may be spoken to."""

from __future__ import annotations

import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from structured_text.errors import InputError
from structured_text.farm.fingerprint import Fingerprint, fingerprint

__all__ = ["Cluster", "is_here"]

_FORM = "write it as --cluster tls://host:8786, or tcp://host:8786 on this computer"


@dataclass(frozen=True)
class Cluster:
    """A cluster.

    Attributes:
        address: Of its scheduler: `tls://host:port`, or `tcp://host:port` on this computer.
        ca: Certificate of who has signed those of the cluster (PEM).
        cert: Our own (PEM).
        key: Its key (PEM).
        plain: Connections to other computers may be without TLS: who can reach them can run
            anything on each of the computers.
        patience_s: How long a scheduler, or a first worker, is waited for [s].
        fingerprint: What has to be the same on each of its computers.
    """

    address: str
    ca: Path | None = None
    cert: Path | None = None
    key: Path | None = None
    plain: bool = False
    patience_s: float = 30.0
    fingerprint: Callable[[], Fingerprint] = fingerprint

    def check(self) -> None:
        """Without asking anybody.

        Raises:
            InputError: it cannot be used like this.
        """
        scheme, host, _ = self.parts()
        for name, file in (("ca", self.ca), ("cert", self.cert), ("key", self.key)):
            if scheme == "tls" and file is None:
                hint = "docs/how-to/cluster.md says how to make it"
                raise InputError(f"{self.address} needs --cluster-{name}", hint=hint)
            if scheme == "tcp" and file is not None:
                raise InputError(f"--cluster-{name} is for tls://, not for {self.address}")
            if file is not None and not file.is_file():
                raise InputError(f"--cluster-{name}: no such file", file=file)
        if scheme == "tcp":
            self.check_plain(self.address, host)

    def check_plain(self, address: str, host: str) -> None:
        """May this address of the cluster be spoken to without TLS?"""
        if not self.plain and not is_here(host):
            raise InputError(
                f"{address} is not on this computer, and nothing would be encrypted",
                hint="set up TLS (docs/how-to/cluster.md), or allow it with --cluster-plain",
            )

    def parts(self) -> tuple[str, str, int]:
        """Scheme, host and port of the address.

        Raises:
            InputError: it is not one.
        """
        try:
            found = urlsplit(self.address)
            scheme, host, port = found.scheme, found.hostname, found.port
        except ValueError:
            scheme, host, port = "", None, None
        if scheme not in ("tcp", "tls") or not host or not port or found.path.strip("/"):
            raise InputError(f"--cluster {self.address}: no such address", hint=_FORM)
        return scheme, host, port


def is_here(host: str) -> bool:
    """Has this computer every address of that name?"""
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_DGRAM)
    except OSError:
        return False
    for family, kind, protocol, _, address in found:
        with socket.socket(family, kind, protocol) as one:
            try:
                one.bind(address)  # only what is here can be bound to
            except OSError:
                return False
    return True
