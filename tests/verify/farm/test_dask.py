"""A farm runs its work on a cluster of dask.distributed, here with processes on this computer."""

from __future__ import annotations

import itertools
import math
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

from farm_work import Counted, Killed, process_number, refuse
from rcx_harness.cli.app import main
from structured_text.errors import InputError
from structured_text.farm import Cluster, Farm, Lost

pytestmark = pytest.mark.exhaustive

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")

Captured = pytest.CaptureFixture[str]

_COUNT = """PROGRAM Count
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Button : BOOL; Number : INT;
  END_VAR
  IF Button THEN
    Number := (Number + 1) MOD 3;
  END_IF;
END_PROGRAM
"""
_ALONE = {"threads_per_worker": 1, "dashboard_address": ":0"}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Return a cluster of two workers. A killed worker is replaced.

    An item of work may kill one worker before it counts as failed.
    """
    import dask

    failures = {"distributed.scheduler.allowed-failures": 0}
    with dask.config.set(failures), distributed.LocalCluster(n_workers=2, **_ALONE) as found:
        yield found


@pytest.fixture
def farm(cluster: Any) -> Farm:
    """Return a farm (pool of workers) on the cluster."""
    return Farm(cluster=Cluster(cluster.scheduler_address))


def test_results_come_in_the_order_of_the_items(farm: Farm) -> None:
    items = [4, 0, 3, 5, 2] * 5
    assert list(farm.run(math.factorial, items)) == list(Farm(0).run(math.factorial, items))


def test_each_worker_sets_up_once(farm: Farm, tmp_path: Path) -> None:
    file = tmp_path / "set_up"
    did = {process for _, process in farm.run(Counted(file), range(20))}
    prepared = [int(line) for line in file.read_text().split()]
    assert len(prepared) == len(set(prepared))
    assert did == set(prepared)
    assert os.getpid() not in did


@pytest.mark.exhaustive
def test_an_item_whose_worker_is_killed_is_done_again(farm: Farm, tmp_path: Path) -> None:
    (tmp_path / "0").touch()
    found = list(farm.run(Killed(tmp_path), range(8)))
    assert found == [(item, item * 10) for item in range(8)]
    assert not list(tmp_path.iterdir())


@pytest.mark.exhaustive
def test_an_item_whose_result_was_lost_is_run_again(
    farm: Farm, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If a result is lost with its worker, the item is run again.

    In the test, another item ends the worker before the result is fetched.
    """
    result = distributed.Future.result
    taken = iter([True])

    def lost_once(future: Any) -> Any:
        if next(taken, False):
            raise CancelledError
        return result(future)

    monkeypatch.setattr(distributed.Future, "result", lost_once)
    assert list(farm.run(math.factorial, [3, 4])) == [(3, 6), (4, 24)]
    assert next(taken, None) is None


@pytest.mark.exhaustive
def test_an_item_that_kills_its_workers_is_named(farm: Farm, tmp_path: Path) -> None:
    """An item that kills its workers is named in the error.

    At the second attempt an item runs alone, so items on the same worker are not blamed.
    """
    for number in range(4):
        (tmp_path / str(number)).touch()

    def lost(one: Lost[int]) -> int:
        assert one.why.startswith("the last one on 127.0.0.1")
        return -one.times

    found = list(farm.run(Killed(tmp_path), range(8), lost=lost))
    assert found == [(item, item * 10 if item != 3 else -2) for item in range(8)]
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.exhaustive
def test_a_program_is_explored_on_the_cluster_from_its_first_state(
    cluster: Any, tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program is explored on the cluster from its first state on.

    The states by hand: before the first scan, and after one scan for each value of Button, 0 to
    2.
    """
    from structured_text.farm.dask import ClusterCrew

    file, given, give = tmp_path / "Count.st", [], ClusterCrew.give
    file.write_text(_COUNT)

    def noted(self: ClusterCrew, number: int, item: Any) -> None:
        given.append(repr(item))
        give(self, number, item)

    monkeypatch.setattr(ClusterCrew, "give", noted)
    command = ["explore", str(file), "--input", "Main.Button", "--faults", "none"]
    assert main([*command, "--cluster", cluster.scheduler_address]) == 0
    there = capsys.readouterr().out
    assert given == [f"state {number}" for number in range(7)]
    assert main([*command, "--workers", "0"]) == 0
    assert capsys.readouterr().out == there
    assert "explored to the end: 7 states, 14 scans judged" in there


@pytest.mark.exhaustive
def test_a_users_error_arrives_as_it_was_raised(farm: Farm) -> None:
    running = farm.run(refuse, range(8))
    assert [next(running) for _ in range(2)] == [(0, 0), (1, 1)]
    with pytest.raises(InputError) as caught:
        next(running)
    assert str(caught.value) == "a.st:2: no such pin; name another"


@pytest.mark.exhaustive
def test_a_worker_that_is_added_meanwhile_gets_work() -> None:
    with distributed.LocalCluster(n_workers=1, **_ALONE) as cluster:
        farm = Farm(cluster=Cluster(cluster.scheduler_address))
        with closing(farm.run(process_number, itertools.count())) as running:
            _, first = next(running)
            cluster.scale(2)
            assert next(worker for _, worker in running if worker != first)


@pytest.mark.exhaustive
def test_a_worker_does_one_item_at_a_time_despite_threads(tmp_path: Path) -> None:
    import io

    from rich.console import Console

    shown = io.StringIO()
    options = {"processes": False, "threads_per_worker": 4, "dashboard_address": ":0"}
    with distributed.LocalCluster(n_workers=1, protocol="tcp://", **options) as cluster:
        farm = Farm(cluster=Cluster(cluster.scheduler_address), console=Console(file=shown))
        list(farm.run(Counted(tmp_path / "set_up"), range(8)))
    assert (tmp_path / "set_up").read_text() == f"{os.getpid()}\n"
    assert "start more of them, each with --nthreads 1" in shown.getvalue()


@pytest.mark.exhaustive
def test_a_cluster_that_ends_is_reported() -> None:
    with distributed.LocalCluster(n_workers=1, **_ALONE) as cluster:
        address = cluster.scheduler_address
        running = Farm(cluster=Cluster(address, patience_s=5)).run(math.factorial, range(100_000))
        assert next(running) == (0, 1)
        cluster.close()
        with pytest.raises(InputError, match=f"the cluster at {address} has "):
            list(running)


@pytest.mark.exhaustive
def test_a_cluster_without_workers_is_reported() -> None:
    with distributed.LocalCluster(n_workers=0, **_ALONE) as cluster:
        address = cluster.scheduler_address
        with pytest.raises(InputError) as caught:
            list(Farm(cluster=Cluster(address, patience_s=3)).run(math.factorial, [1]))
    assert str(caught.value) == (
        f"the cluster at {address} has no workers; start some: dask worker {address} --nthreads 1"
    )


def other_package(folder: Path, repository: Path) -> Path:
    """Copy this package, add a line, and return the folder from which it can be imported."""
    harness = folder / "harness"
    shutil.copytree(repository / "harness/structured_text", harness / "structured_text")
    with (harness / "structured_text/output/units.py").open("a") as stream:
        stream.write("# another line\n")
    return harness


@contextmanager
def worker_with(package: Path, address: str) -> Iterator[None]:
    """Run a worker that imports from a folder."""
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny"]
    worker = subprocess.Popen(
        [*command, "--nthreads", "1", "--no-dashboard"],
        env={**os.environ, "PYTHONPATH": str(package)},
        cwd=package,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        worker.kill()
        worker.wait()


@pytest.mark.exhaustive
def test_a_worker_with_other_sources_is_refused(tmp_path: Path, repository: Path) -> None:
    with distributed.LocalCluster(n_workers=0, **_ALONE) as cluster:
        address = cluster.scheduler_address
        worker = worker_with(other_package(tmp_path, repository), address)
        with worker, pytest.raises(InputError) as caught:
            list(Farm(cluster=Cluster(address)).run(math.factorial, [1]))
    assert re.fullmatch(
        r"the worker tcp://127\.0\.0\.1:\d+ differs from this computer: its sources \w{16} here, "
        r"\w{16} there; install the same rcx-harness and distributed on both",
        str(caught.value),
    )


@pytest.mark.exhaustive
def test_a_worker_without_us_is_refused(tmp_path: Path) -> None:
    (tmp_path / "structured_text").mkdir()
    (tmp_path / "structured_text/__init__.py").touch()
    with distributed.LocalCluster(n_workers=0, **_ALONE) as cluster:
        address = cluster.scheduler_address
        told = pytest.raises(
            InputError, match=r"the worker tcp.* it has a different version of rcx-harness \("
        )
        with worker_with(tmp_path, address), told:
            list(Farm(cluster=Cluster(address)).run(math.factorial, [1]))


@pytest.mark.exhaustive
def test_a_later_worker_with_other_sources_is_refused(tmp_path: Path, repository: Path) -> None:
    with distributed.LocalCluster(n_workers=1, **_ALONE) as cluster:
        address = cluster.scheduler_address
        running = Farm(cluster=Cluster(address)).run(process_number, itertools.count())
        _, first = next(running)
        did = {first}
        told = pytest.raises(InputError, match=r"^a worker on .* differs from this computer: its")
        with worker_with(other_package(tmp_path, repository), address), told:
            for _, worker in running:
                did.add(worker)
        assert did == {first}


@pytest.fixture
def certificates(tmp_path: Path, repository: Path) -> Path:
    """Return two folders, each with an authority and a certificate, made as cluster.md says."""
    if shutil.which("openssl") is None:
        pytest.skip("openssl not found (PATH)")
    page = (repository / "docs/how-to/cluster.md").read_text(encoding="utf-8")
    commands = re.findall(r"^(?:openssl|printf) .*$", page, re.MULTILINE)
    assert len(commands) == 4
    for name in ("ours", "theirs"):
        (tmp_path / name).mkdir()
        for command in commands:
            subprocess.run(command, shell=True, cwd=tmp_path / name, check=True, stderr=-1)
    return tmp_path


@pytest.mark.exhaustive
def test_with_tls_only_clients_with_a_certificate_are_accepted(certificates: Path) -> None:
    """Source: docs/how-to/cluster.md, certificates."""

    def tls(address: str, name: str) -> Farm:
        made = certificates / name
        cluster = Cluster(address, made / "ca.pem", made / "farm.pem", made / "farm.key")
        return Farm(cluster=cluster)

    ours = certificates / "ours"
    files = {
        f"tls_{who}_{what}": str(ours / file)
        for who in ("scheduler", "worker", "client")
        for what, file in (("cert", "farm.pem"), ("key", "farm.key"))
    }
    security = distributed.Security(
        require_encryption=True, tls_ca_file=str(ours / "ca.pem"), **files
    )
    options = {"protocol": "tls://", "security": security, **_ALONE}
    with distributed.LocalCluster(n_workers=1, **options) as cluster:
        address = cluster.scheduler_address
        assert list(tls(address, "ours").run(math.factorial, [4])) == [(4, 24)]
        with pytest.raises(InputError, match=r"no cluster at tls://.*CERTIFICATE_VERIFY_FAILED"):
            list(tls(address, "theirs").run(math.factorial, [4]))
