"""Addresses of a cluster are read, and a cluster that cannot be used is reported."""

from __future__ import annotations

import math
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from structured_text.errors import InputError
from structured_text.farm import Cluster, Farm
from structured_text.farm.cluster import is_here


@pytest.fixture
def pem(tmp_path: Path) -> Path:
    """Return the path of an existing certificate file."""
    file = tmp_path / "one.pem"
    file.touch()
    return file


@pytest.mark.parametrize(
    "address", ["host:8786", "tcp://host", "http://host:80", "tcp://host:99999", "tls://:8786", ""]
)
def test_a_wrong_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match=r"no such address; write it as --cluster tls://host:8786"):
        Farm(cluster=Cluster(address))


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::1]"])
def test_plain_connections_stay_on_this_computer(host: str) -> None:
    if host == "[::1]" and not socket.has_ipv6:
        pytest.skip("no IPv6 here")
    Cluster(f"tcp://{host}:8786").check()


def test_plain_connections_to_other_computers_have_to_be_allowed() -> None:
    """An unencrypted connection to another computer is refused unless the user allows it.

    Source: 192.0.2.0/24 is nobody's, RFC 5737.
    """
    with pytest.raises(InputError) as caught:
        Cluster("tcp://192.0.2.1:8786").check()
    assert str(caught.value) == (
        "tcp://192.0.2.1:8786 is not on this computer, and nothing would be encrypted; "
        "set up TLS (docs/how-to/cluster.md), or allow it with --cluster-plain"
    )
    Cluster("tcp://192.0.2.1:8786", plain=True).check()


def test_an_unknown_host_name_is_not_this_computer() -> None:
    """A host name that cannot be resolved does not count as this computer.

    Source: .invalid has no hosts, RFC 2606.
    """
    assert not is_here("nowhere.invalid")


def test_tls_needs_three_files_that_are_there(pem: Path) -> None:
    Cluster("tls://192.0.2.1:8786", pem, pem, pem).check()
    with pytest.raises(InputError, match="needs --cluster-key"):
        Cluster("tls://192.0.2.1:8786", pem, pem).check()
    with pytest.raises(InputError, match="gone: --cluster-ca: no such file"):
        Cluster("tls://192.0.2.1:8786", Path("gone"), pem, pem).check()
    with pytest.raises(InputError, match="--cluster-cert is for tls://"):
        Cluster("tcp://127.0.0.1:8786", cert=pem).check()


def test_a_missing_extra_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "structured_text.farm.dask", raising=False)
    farm = Farm(cluster=Cluster("tcp://127.0.0.1:8786"))
    with pytest.raises(InputError) as caught:
        list(farm.run(math.factorial, [1]))
    assert str(caught.value) == (
        "--cluster needs dask.distributed; pip install 'rcx-harness[cluster]'"
    )


@pytest.fixture
def silent() -> Iterator[int]:
    """Return the port of a server that never answers."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        one.listen()
        yield one.getsockname()[1]


def test_a_cluster_that_does_not_answer_is_reported(silent: int) -> None:
    pytest.importorskip("distributed")
    farm = Farm(cluster=Cluster(f"tcp://127.0.0.1:{silent}", patience_s=0.1))
    with pytest.raises(InputError) as caught:
        list(farm.run(math.factorial, [1]))
    assert str(caught.value).startswith(
        f"there is no cluster at tcp://127.0.0.1:{silent}: the program at this address does "
        "not answer like a scheduler; start one (docs/how-to/cluster.md), its scheduler with "
        "distributed 20"
    )


def test_a_missing_cluster_is_reported() -> None:
    pytest.importorskip("distributed")
    with socket.socket() as one:  # bound without listening, so that no other process takes the port
        one.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{one.getsockname()[1]}"
        with pytest.raises(InputError, match=f"no cluster at {address}: Connection refused; start"):
            list(Farm(cluster=Cluster(address)).run(math.factorial, [1]))
