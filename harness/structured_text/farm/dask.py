"""Workers of a dask.distributed cluster; imported only if a cluster is used.

A plugin takes the pickled work to each worker. An item is a dask task of the function `_one`.
Before each item the worker compares its fingerprint with ours, because workers may join at any
time. Dask repeats a task if its worker ends; if that happens too often, it reports `KilledWorker`.
"""

from __future__ import annotations

import asyncio
import logging
import pickle
import socket
import threading
import time
import uuid
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import suppress
from queue import Empty, Queue
from typing import Any

from distributed import Client, Future, KilledWorker, Security, Worker, WorkerPlugin
from distributed import __version__ as distributed_version
from distributed.client import ClosedClientError
from distributed.comm import connect, get_address_host

from structured_text.errors import COMMAND, DISTRIBUTION, InputError
from structured_text.farm.cluster import Cluster
from structured_text.farm.fingerprint import Fingerprint, differences
from structured_text.farm.work import Died, Done, Ended, NotBegun, Work, attempt, doer

__all__ = ["ClusterCrew"]

#: Items per worker: the worker executes one while the next one is transferred.
_DEPTH = 2
#: Interval at which the cluster's workers are listed [s].
_LOOK_S = 1.0
#: Loggers of dask that report errors. They are silenced, because the user gets a message for those
#: errors.
_LOGS = ("distributed", "distributed.client")


class _Bench:
    """The work in a worker process.

    It runs one item at a time, because programs are not thread-safe.
    """

    def __init__(self, work: bytes) -> None:
        self._work = work
        self._lock = threading.Lock()
        self._do: Callable[[Any], Any] | None = None

    def one(self, item: bytes) -> Any:
        """Return the result of an item."""
        with self._lock:
            self._do = self._do or doer(pickle.loads(self._work))
            return self._do(pickle.loads(item))


#: In a worker process: the work of each run, by the name of the run.
_BENCHES: dict[str, _Bench] = {}


class _Carrier(WorkerPlugin):  # type: ignore[misc]
    """The dask plugin that takes the work to each worker, including workers that join later."""

    def __init__(self, run: str, work: bytes) -> None:
        self.name = f"{COMMAND}-{run}"
        self._run, self._work = run, work

    def setup(self, worker: Worker) -> None:
        """Store the work in a worker."""
        _BENCHES[self._run] = _Bench(self._work)

    def teardown(self, worker: Worker) -> None:
        """Remove the work from a worker."""
        _BENCHES.pop(self._run, None)


def _one(run: str, here: Callable[[], Fingerprint], of: Fingerprint, item: bytes) -> bytes:
    """Execute an item in a worker and return the pickled `Done`."""

    def one() -> Any:
        if differ := differences(of, here()):
            raise _other(f"a worker on {socket.gethostname()}", differ)
        return _BENCHES[run].one(item)

    return attempt(one)


class ClusterCrew:
    """The present workers of a cluster, as a crew of `Farm`.

    `say` takes a line for the user.

    Raises:
        InputError: There is no such cluster, or it differs from this computer.
    """

    attempts = 2

    def __init__(
        self, work: Work[Any, Any], cluster: Cluster, say: Callable[[str], None] = lambda _: None
    ) -> None:
        self._cluster, self._say = cluster, say
        self._carrier = _Carrier(uuid.uuid4().hex, pickle.dumps(work))
        self._of = cluster.fingerprint()
        self._ended: Queue[tuple[int, Future]] = Queue()
        self._futures: dict[int, Future] = {}
        self._workers: dict[str, Any] = {}
        self._looked_s = 0.0
        self._lonely_s: float | None = None
        self._levels = [(name, logging.getLogger(name).level) for name in _LOGS]
        for name in _LOGS:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self._client: Client | None = None
        try:
            self._client = _connected(cluster)
            self._begin(self._client)
        except BaseException:
            self.close()
            raise

    @property
    def size(self) -> int:
        """Return the number of workers; 1 if all workers have left, because others may come."""
        return max(1, len(self._workers))

    def has_room(self) -> bool:
        """Return whether a new item would be started now or soon."""
        if time.monotonic() - self._looked_s > _LOOK_S:
            self._look()
        return len(self._futures) < _DEPTH * len(self._workers)

    def give(self, number: int, item: Any) -> None:
        """Give an item, with its number, to the workers."""
        assert self._client is not None
        run = self._carrier.name
        key = f"{run}-{uuid.uuid4().hex}"
        of = (self._cluster.fingerprint, self._of)
        arguments = (run.removeprefix(f"{COMMAND}-"), *of, pickle.dumps(item))
        try:
            future = self._client.submit(_one, *arguments, key=key, pure=False)
        except ClosedClientError:
            raise self._gone() from None
        self._futures[number] = future
        future.add_done_callback(lambda one: self._ended.put((number, one)))

    def ended(self) -> Iterator[tuple[int, Ended]]:
        """Wait at most 1 s for an item to end; yield its number and its outcome."""
        try:
            number, future = self._ended.get(timeout=_LOOK_S)
        except Empty:
            self._look()
            return
        del self._futures[number]
        yield number, self._how(future)

    def close(self) -> None:
        """Cancel items that have not been started.

        Started items run to their end, and their results are discarded.
        """
        if self._client is not None:
            try:
                self._client.cancel(list(self._futures.values()), force=True)
                self._client.unregister_worker_plugin(self._carrier.name)
            except Exception:  # the cluster has ended, and so have its items
                pass
            self._client.close()
            self._client = None
        for name, level in self._levels:
            logging.getLogger(name).setLevel(level)

    def _begin(self, client: Client) -> None:
        """Wait for a first worker, compare all workers with this computer, and send the work."""
        seen = client.get_versions(check=False)
        others = {"its scheduler": seen["scheduler"], **seen["workers"]}
        for name, one in others.items():
            there = one["packages"]["distributed"] if one else distributed_version
            if there != distributed_version:
                differ = f"distributed {distributed_version} here, {there} there"
                raise _other(f"{self._cluster.address}, {name}", differ)
        try:
            client.wait_for_workers(1, timeout=self._cluster.patience_s)
        except TimeoutError:
            hint = f"start some: dask worker {self._cluster.address} --nthreads 1"
            raise _failed(self._cluster, "has no workers", hint) from None
        self._look()
        for address, one in client.run(self._cluster.fingerprint, on_error="return").items():
            if isinstance(one, Exception):
                raise _other(
                    f"the worker {address}", f"it has a different version of {DISTRIBUTION} ({one})"
                )
            if differ := differences(self._of, one):
                raise _other(f"the worker {address}", differ)
        client.register_plugin(self._carrier)

    def _look(self) -> None:
        """List the workers and check their connections.

        Raise InputError if the cluster is gone, needs TLS, or has had no worker for too long.
        """
        assert self._client is not None
        self._looked_s = time.monotonic()
        if self._client.status not in ("running", "connecting"):
            raise self._gone()
        before = self._workers
        # An empty list may also mean that the connection is lost.
        self._workers = dict(self._client.scheduler_info(n_workers=-1).get("workers", {}))
        for address in self._workers.keys() - before.keys():
            if address.startswith("tcp://"):
                self._cluster.check_plain(address, get_address_host(address))
        if self._workers:
            self._lonely_s = None
        elif self._lonely_s is None:
            self._lonely_s = self._looked_s
        elif self._looked_s - self._lonely_s > self._cluster.patience_s:
            raise _failed(self._cluster, "has lost all its workers", "start some more")
        threads = [one["nthreads"] for one in self._workers.values()]
        if not before and any(one > 1 for one in threads):
            self._say("workers do one item at a time: start more of them, each with --nthreads 1")

    def _how(self, future: Future) -> Ended:
        assert self._client is not None
        if future.status == "finished":
            with suppress(CancelledError):  # the worker has left, so the result is lost
                done: Done = pickle.loads(future.result())
                return done
        if future.status == "error":
            error = future.exception()
            if isinstance(error, KilledWorker):
                host = get_address_host(error.last_worker.address)
                return Died(f"the last one on {host}", error.allowed_failures + 1)
            return Done(error=_other("a worker", f"it cannot take work from here ({error})"))
        if self._client.status == "running":
            return NotBegun()
        raise self._gone()

    def _gone(self) -> InputError:
        return _failed(self._cluster, "has ended", "start it again")


def _connected(cluster: Cluster) -> Client:
    scheme, host, port = cluster.parts()
    files = {"ca_file": cluster.ca, "client_cert": cluster.cert, "client_key": cluster.key}
    given = {f"tls_{name}": str(file) for name, file in files.items() if file is not None}
    security = Security(require_encryption=True, **given) if scheme == "tls" else Security()
    try:
        # This connection and its first message show an error at once. The client would report the
        # error only after many attempts, or never.
        socket.create_connection((host, port), cluster.patience_s).close()
        asyncio.run(_greet(cluster, security))
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # this module compares the versions more strictly than dask, which warns
            return Client(
                cluster.address, security=security, timeout=cluster.patience_s, set_as_default=False
            )
    except (TimeoutError, asyncio.TimeoutError):  # before Python 3.11 these are two classes
        raise _not_there(
            cluster, "the program at this address does not answer like a scheduler"
        ) from None
    except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
        raise _not_there(cluster, _words(error)) from None


async def _greet(cluster: Cluster, security: Security) -> None:
    arguments = security.get_connection_args("client")
    greeted = connect(cluster.address, timeout=cluster.patience_s, **arguments)
    (await asyncio.wait_for(greeted, cluster.patience_s)).abort()


def _words(error: BaseException) -> str:
    """Return the innermost cause of an error, on one line."""
    while error.__cause__ is not None:
        error = error.__cause__
    return " ".join((getattr(error, "strerror", None) or str(error) or repr(error)).split())


def _not_there(cluster: Cluster, why: str) -> InputError:
    hint = (
        f"start one (docs/how-to/cluster.md), its scheduler with distributed {distributed_version}"
    )
    return InputError(f"there is no cluster at {cluster.address}: {why}", hint=hint)


def _failed(cluster: Cluster, what: str, hint: str) -> InputError:
    return InputError(f"the cluster at {cluster.address} {what}", hint=hint)


def _other(name: str, differ: str) -> InputError:
    hint = f"install the same {DISTRIBUTION} and distributed on both"
    return InputError(f"{name} differs from this computer: {differ}", hint=hint)
