"""Options of commands that distribute their work: `--workers`, `--cluster`, cluster details."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from rcx_harness.verify.fingerprint import fingerprint
from structured_text.errors import InputError
from structured_text.farm import Cluster, Farm

__all__ = ["MOST", "FarmOptions", "WorkersOrNone"]

#: Upper limit of `--workers`. It is above the number of processors of any computer.
MOST = 4096


#: The option `--workers` of commands that can also work without worker processes.
WorkersOrNone = Annotated[
    int | None,
    typer.Option(
        help="Number of processes. Default: one for each processor; 0: run in this process.",
        min=0,
        max=MOST,
    ),
]


@dataclass(frozen=True, kw_only=True)
class FarmOptions:
    """The options for workers. A command has a subclass of this class and uses `with_options`."""

    workers: Annotated[
        int | None,
        typer.Option(help="Number of processes. Default: one for each processor.", min=1, max=MOST),
    ] = None
    cluster: Annotated[
        str | None,
        typer.Option(help="Scheduler of a cluster: tls://HOST:PORT, or tcp:// on this computer."),
    ] = None
    cluster_ca: Annotated[
        Path | None,
        typer.Option(help="With tls: certificate of the authority (CA) of the cluster (PEM)."),
    ] = None
    cluster_cert: Annotated[
        Path | None, typer.Option(help="With tls: certificate of this computer (PEM).")
    ] = None
    cluster_key: Annotated[Path | None, typer.Option(help="With tls: its private key (PEM).")] = (
        None
    )
    cluster_plain: Annotated[
        bool, typer.Option("--cluster-plain", help="Allow unencrypted tcp to other computers.")
    ] = False

    def farm(self, console: Console) -> Farm:
        """Return the farm that distributes the work; it shows its progress on `console`."""
        if self.cluster is None:
            given = {
                "--cluster-ca": self.cluster_ca,
                "--cluster-cert": self.cluster_cert,
                "--cluster-key": self.cluster_key,
                "--cluster-plain": self.cluster_plain or None,
            }
            for name, value in given.items():
                if value is not None:
                    raise InputError(f"{name} needs --cluster", hint="name the scheduler, too")
            return Farm(self.workers, console=console)
        if self.workers is not None:
            hint = "start the workers on the cluster (docs/how-to/cluster.md)"
            raise InputError("--workers cannot be combined with --cluster", hint=hint)
        files = (self.cluster_ca, self.cluster_cert, self.cluster_key)
        cluster = Cluster(self.cluster, *files, plain=self.cluster_plain, fingerprint=fingerprint)
        return Farm(cluster=cluster, console=console)
