"""The address of a dask.distributed cluster, and the security of the connections to the cluster."""

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
    """A cluster and the files that TLS needs; used by `Farm`.

    Attributes:
        address: Address of the scheduler: `tls://host:port`, or `tcp://host:port` on this computer.
        ca: Certificate of the authority that signed the cluster's certificates (PEM).
        cert: Our own certificate (PEM).
        key: The private key of our certificate (PEM).
        plain: Allow connections to other computers without TLS. Anybody who can reach these
            computers can then run any code on them.
        patience_s: Longest wait for a scheduler or a first worker [s].
        fingerprint: A function that returns the properties that must be equal on all computers of
            the cluster.
    """

    address: str
    ca: Path | None = None
    cert: Path | None = None
    key: Path | None = None
    plain: bool = False
    patience_s: float = 30.0
    fingerprint: Callable[[], Fingerprint] = fingerprint

    def check(self) -> None:
        """Check the address and the options without connecting."""
        scheme, host, _ = self.parts()
        for name, file in (("ca", self.ca), ("cert", self.cert), ("key", self.key)):
            if scheme == "tls" and file is None:
                hint = "create it as docs/how-to/cluster.md describes"
                raise InputError(f"{self.address} needs --cluster-{name}", hint=hint)
            if scheme == "tcp" and file is not None:
                raise InputError(f"--cluster-{name} is for tls://, not for {self.address}")
            if file is not None and not file.is_file():
                raise InputError(f"--cluster-{name}: no such file", file=file)
        if scheme == "tcp":
            self.check_plain(self.address, host)

    def check_plain(self, address: str, host: str) -> None:
        """Raise InputError if a connection to an address needs TLS but does not have it."""
        if not self.plain and not is_here(host):
            raise InputError(
                f"{address} is not on this computer, and nothing would be encrypted",
                hint="set up TLS (docs/how-to/cluster.md), or allow it with --cluster-plain",
            )

    def parts(self) -> tuple[str, str, int]:
        """Return scheme, host and port of the address, or raise InputError."""
        try:
            found = urlsplit(self.address)
            scheme, host, port = found.scheme, found.hostname, found.port
        except ValueError:
            scheme, host, port = "", None, None
        if scheme not in ("tcp", "tls") or not host or not port or found.path.strip("/"):
            raise InputError(f"--cluster {self.address}: no such address", hint=_FORM)
        return scheme, host, port


def is_here(host: str) -> bool:
    """Return whether all addresses of a host name belong to this computer."""
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_DGRAM)
    except OSError:
        return False
    for family, kind, protocol, _, address in found:
        with socket.socket(family, kind, protocol) as one:
            try:
                one.bind(address)  # a socket can be bound only to an address of this computer
            except OSError:
                return False
    return True
