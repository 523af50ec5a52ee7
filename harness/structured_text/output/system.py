"""The differences between Windows, macOS and Linux.

No other module uses functions that only some systems have.

docs/reference/platforms.md lists what is missing on which system.
"""

from __future__ import annotations

import _thread
import ctypes
import errno
import gc
import mmap
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Final, Literal, NoReturn

from structured_text.errors import COMMAND

__all__ = [
    "APART",
    "COPIES",
    "DLL",
    "GUARDED",
    "MOST_PROCESSES",
    "WHOLE",
    "DirectInput",
    "PipedCopy",
    "RelayedInput",
    "SharedMemory",
    "StandardInput",
    "addresses",
    "ask_for_priority",
    "be_apart",
    "cache_root",
    "copied",
    "copy_ended",
    "end_apart",
    "end_as_by_ctrl_c",
    "fine_timers",
    "interrupt_main_thread",
    "interrupts_later",
    "limit_process",
    "loaded",
    "nobody_reads",
    "processors",
    "settings_root",
    "told_to_end",
    "unload",
    "without_waiting",
]

if sys.platform == "win32":
    from _ctypes import FreeLibrary
else:
    from _ctypes import dlclose

_PRIORITY = 1
_STANDARD_ERROR = 2
_SHOWN = 15
#: Interval of checks whether a copy of this process has ended [s].
_LOOK_S = 0.005
_CHUNK = 65536
_FINEST_MS = 1
#: The folder for the files behind shared memory.
_SHARED = "/dev/shm" if os.path.isdir("/dev/shm") else os.environ.get("TMPDIR", "/var/tmp")
#: Real time after which a copy of this process counts as hanging: a number of seconds, plus a
#: multiple of the processor time that it may use.
_HANGS_S, _BUSY = 600, 8
_TOO_LONG = ("SIGXCPU", "SIGALRM", "SIGKILL")

APART: dict[str, Any]
"""Arguments of `Popen` for a process that Ctrl-C does not reach; its parent ends it."""

DLL: Final = ".dll" if sys.platform == "win32" else ".so"
"""The suffix of the file of a shared object."""

WHOLE: Final = ("-static-libgcc", "-static-libstdc++") if sys.platform == "win32" else ()
"""Options of gcc and clang, so that a shared object needs no library of the compiler."""

GUARDED: Final = sys.platform != "win32"
"""Whether a process can notice the end of its parent, and end its own child processes."""

COPIES: Final = sys.platform != "win32"
"""Whether a process can make copies of itself (fork)."""
MOST_PROCESSES: Final = 60 if sys.platform == "win32" else sys.maxsize
"""The largest number of processes that can be waited for at once."""

_ENDS = [signal.SIGINT, signal.SIGTERM]

if sys.platform == "win32":
    APART = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    _ENDS.append(signal.SIGBREAK)
else:
    APART = {"start_new_session": True}


def cache_root() -> Path:
    """Return the user's folder for caches: files that programs can create again.

    Raise RuntimeError if the user has no home.
    """
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named)
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return Path(local) if local else Path.home() / "AppData" / "Local"
    return Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")


def end_as_by_ctrl_c() -> list[int]:
    """Make SIGTERM, SIGHUP and Ctrl-Break end this process in order, as Ctrl-C does.

    Temporary files are then removed. A signal that is ignored stays ignored (nohup).

    Returns:
        A list that will contain the number of the first signal. Further signals are ignored.
    """
    came: list[int] = []

    def end(number: int, frame: object) -> None:
        came.append(number)
        for one in numbers:
            signal.signal(one, signal.SIG_IGN)
        raise KeyboardInterrupt

    both: list[signal.Signals] = [signal.SIGTERM]
    if sys.platform == "win32":
        both.append(signal.SIGBREAK)
    else:
        both.append(signal.SIGHUP)
    numbers = [one for one in both if signal.getsignal(one) is signal.SIG_DFL]
    for number in numbers:
        signal.signal(number, end)

    def leave() -> None:
        """Restore default signal handling; a copy of this process has no files to remove."""
        for number in numbers:
            if signal.getsignal(number) is end:
                signal.signal(number, signal.SIG_DFL)

    if sys.platform != "win32":
        os.register_at_fork(after_in_child=leave)
    return came


def settings_root() -> Path:
    """Return the user's folder for settings and private files.

    Raise RuntimeError if the user has no home.
    """
    if named := os.environ.get("XDG_CONFIG_HOME"):
        return Path(named)
    if sys.platform == "win32":
        roaming = os.environ.get("APPDATA")
        return Path(roaming) if roaming else Path.home() / "AppData" / "Roaming"
    mac = Path("Library", "Application Support")
    return Path.home() / (mac if sys.platform == "darwin" else ".config")


@contextmanager
def told_to_end(tell: Callable[[], object]) -> Iterator[None]:
    """Call `tell` in the main thread on Ctrl-C, Ctrl-Break, SIGTERM or SIGHUP."""
    numbers = [*_ENDS]
    # The signal stays ignored under nohup.
    if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    before = [(number, signal.signal(number, lambda *_: tell())) for number in numbers]
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)


@contextmanager
def interrupts_later() -> Iterator[None]:
    """Delay Ctrl-C. A process that is started inside the `with` gets it only after `be_apart`."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def be_apart() -> None:
    """Protect this process from Ctrl-C, and let `end_apart` also end its child processes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        os.setsid()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        signal.signal(signal.SIGINT, signal.default_int_handler)


def interrupt_main_thread() -> None:
    """Raise KeyboardInterrupt in the main thread, even while the thread waits.

    A real signal ends the wait for a lock; `_thread.interrupt_main` alone does not.
    """
    main = threading.main_thread().ident
    if sys.platform != "win32" and main is not None:
        signal.pthread_kill(main, signal.SIGINT)
    else:
        _thread.interrupt_main()


def end_apart(pid: int, *, has_ended: bool = False, number: int | None = None) -> None:
    """End a process that may have called `be_apart`, and its child processes (not on Windows).

    If it `has_ended`, only its child processes are ended. If a `number` is given, this signal is
    sent instead of SIGKILL, and only to the process group.
    """
    if sys.platform == "win32":
        if not has_ended:
            with suppress(OSError):
                os.kill(pid, signal.SIGTERM)
        return
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL if number is None else number)
    if not has_ended and number is None:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def processors() -> int:
    """Return the number of processors that this process may use, at least 1."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def fine_timers() -> None:
    """Let this process sleep by the millisecond; otherwise Windows wakes it every 15.6 ms."""
    if sys.platform == "win32":
        ctypes.WinDLL("winmm").timeBeginPeriod(_FINEST_MS)


def ask_for_priority(policy: Literal["first", "in turn"]) -> None:
    """Request real-time priority for this thread and future ones; ignore a refusal.

    Only Linux supports this. The thread runs until it waits, or in turn with other threads of the
    same priority.
    """
    if sys.platform == "linux":
        number = os.SCHED_FIFO if policy == "first" else os.SCHED_RR
        with suppress(OSError):
            os.sched_setscheduler(0, number, os.sched_param(_PRIORITY))


def limit_process(*, memory: int, file: int, seconds: int) -> None:
    """Limit this process and its later child processes.

    Windows has no such limits, and macOS ignores the limit of the memory.

    Args:
        memory: Greatest size of the address space [bytes].
        file: Greatest size of a written file [bytes].
        seconds: Greatest processor time [s].
    """
    if sys.platform == "win32":
        return
    import resource

    limits = (
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_FSIZE, file),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_CORE, 0),
    )
    for kind, wanted in limits:
        _, highest = resource.getrlimit(kind)
        most = wanted if highest == resource.RLIM_INFINITY else min(wanted, highest)
        with suppress(OSError, ValueError):  # the system does not have this limit
            resource.setrlimit(kind, (most, most))


def copied(work: Callable[[], object], seconds: float) -> int:
    """Execute a function in a silent copy of this process, and return the copy's process number.

    The copy ends with exit code 0, or 1 if the function raises. `seconds` limit its processor time;
    the limit of real time is longer, for a busy machine.
    """
    if sys.platform == "win32":
        raise NotImplementedError
    import resource

    if pid := os.fork():
        return pid
    code = 1
    try:
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nothing, stream)
        limit = int(seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(_HANGS_S + _BUSY * limit)
        work()
        code = 0
    finally:
        os._exit(code)


def copy_ended(pid: int = -1) -> tuple[int, int | str, float]:
    """Wait until a copy has ended; without an argument, until any copy has.

    Returns:
        Its process number, its exit code or the name of its signal (`time` if it took too long),
        and its processor time [s].
    """
    if sys.platform == "win32":
        raise NotImplementedError
    found, status, usage = os.wait4(pid, 0)
    how: int | str = os.waitstatus_to_exitcode(status)
    if isinstance(how, int) and how < 0:
        name = signal.Signals(-how).name
        how = "time" if name in _TOO_LONG else name
    return found, how, usage.ru_utime + usage.ru_stime


class PipedCopy:
    """A copy of this process that executes another task; used like a `subprocess.Popen` with pipes.

    It starts in half the time of a new Python, and shares unmodified memory with this process.
    Ctrl-C does not reach it. Of this process's open files it has only standard error. This process
    must have one thread. No object of this process may be collected as garbage in the copy, since
    it could close files of the copy. Therefore all objects are frozen before the fork.

    Args:
        work: The task; the copy ends with exit code 0, with that of a SystemExit, or with 1 and a
            traceback if it raises.
        name: Name in the process list of Linux, which shows the last 15 bytes.

    Attributes:
        pid: Number of the process.
        returncode: Exit code of the process, negative for a signal; None until its end was noticed.
        stdin: Its standard input, for writing.
        stdout: Its standard output, for reading.
    """

    pid: int
    returncode: int | None
    stdin: IO[str]
    stdout: IO[str]

    def __init__(self, work: Callable[[], object], name: str) -> None:
        if sys.platform == "win32":
            raise NotImplementedError
        theirs, orders = os.pipe()
        reports, said = os.pipe()
        gc.collect()
        gc.freeze()
        sys.stdout.flush()
        self.returncode = None
        self.pid = os.fork()
        if not self.pid:
            os.dup2(theirs, 0)
            os.dup2(said, 1)
            _be_another(work, name)
        os.close(theirs)
        os.close(said)
        self.stdin = open(orders, "w", encoding="utf-8")  # noqa: SIM115
        self.stdout = open(reports, encoding="utf-8")  # noqa: SIM115

    def poll(self) -> int | None:
        """Return the exit code of the process, or None while it runs."""
        if sys.platform == "win32":
            raise NotImplementedError
        if self.returncode is None:
            found, status = os.waitpid(self.pid, os.WNOHANG)
            self.returncode = os.waitstatus_to_exitcode(status) if found else None
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the end of the process, and return its exit code.

        Raise subprocess.TimeoutExpired if the process has not ended within this time [s].
        """
        end = None if timeout is None else time.monotonic() + timeout
        while (code := self.poll()) is None:
            if end is not None and time.monotonic() >= end:
                assert timeout is not None
                raise subprocess.TimeoutExpired("", timeout)
            time.sleep(_LOOK_S)
        return code

    def kill(self) -> None:
        """Kill the process."""
        if sys.platform != "win32" and self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


def _be_another(work: Callable[[], object], name: str) -> NoReturn:
    """Run the whole life of a copy, from the fork to its exit."""
    code = 1
    try:
        if sys.platform != "win32":
            os.setsid()
        for number in map(int, os.listdir("/dev/fd")):
            if number > _STANDARD_ERROR:
                with suppress(OSError):  # this is the descriptor with which listdir read the folder
                    os.close(number)
        if sys.platform == "linux":
            Path("/proc/self/comm").write_bytes(name.encode()[-_SHOWN:].lstrip(b"."))
        work()
        sys.stdout.flush()
        code = 0
    except SystemExit as ended:
        if ended.code is None or isinstance(ended.code, int):
            code = ended.code or 0
        else:
            print(ended.code, file=sys.stderr)
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        os._exit(code)


def without_waiting(path: str, flags: int) -> int:
    """Open a file for `open(opener=...)`; never block, even if the path has become a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def nobody_reads(error: OSError) -> bool:
    """Return whether the error says that the reader of a pipe has gone."""
    if sys.platform == "win32":
        return error.errno in (errno.EPIPE, errno.EINVAL)
    return error.errno == errno.EPIPE


class DirectInput:
    """Standard input, which `select` can wait for beside sockets."""

    def fileno(self) -> int:
        """Return the number for `select`."""
        return 0

    def read(self) -> bytes:
        """Return the available input; empty at its end."""
        return os.read(0, _CHUNK)


class RelayedInput:
    """Standard input on a system whose `select` takes only sockets; a thread relays the data.

    Data may therefore arrive after data that another socket received later.
    """

    def __init__(self) -> None:
        self._socket, into = socket.socketpair()
        threading.Thread(target=self._relay, args=(into,), daemon=True).start()

    def fileno(self) -> int:
        """Return the number for `select`."""
        return self._socket.fileno()

    def read(self) -> bytes:
        """Return the available input; empty at its end."""
        return self._socket.recv(_CHUNK)

    def _relay(self, into: socket.socket) -> None:
        with into:
            while some := os.read(0, _CHUNK):
                into.sendall(some)


StandardInput = RelayedInput if sys.platform == "win32" else DirectInput
"""The class of standard input on this system."""


class SharedMemory:
    """Memory that several processes share by its name.

    `multiprocessing.shared_memory` would start a process that tracks the memory, and its imports
    take 3 MiB in each process.

    Args:
        name: Name of memory that another process has created. If it is empty, new memory is
            created, with all bytes zero.
        size: Size of new memory in bytes.

    Attributes:
        name: Name for other processes.
        buf: The bytes.

    Raises:
        FileNotFoundError: There is no memory of this name. On Windows, new memory is created
            instead.
    """

    def __init__(self, name: str = "", size: int = 0) -> None:
        if sys.platform == "win32":
            self.name = name or f"{COMMAND}-{os.urandom(8).hex()}-{size}"
            self._map = mmap.mmap(-1, int(self.name.rpartition("-")[2]), tagname=self.name)
            self.buf = memoryview(self._map)
            return
        new = not name
        self.name = name or f"{_SHARED}/{COMMAND}-{os.urandom(8).hex()}"
        file = os.open(self.name, os.O_RDWR | (os.O_CREAT | os.O_EXCL if new else 0), 0o600)
        try:
            if new:
                os.ftruncate(file, size)
            self._map = mmap.mmap(file, size)
        except BaseException:
            if new:
                self.unlink()
            raise
        finally:
            os.close(file)
        self.buf = memoryview(self._map)

    def close(self) -> None:
        """Release the memory and its mapping."""
        self.buf.release()
        self._map.close()

    def unlink(self) -> None:
        """Remove the name; the system frees the memory when all processes have closed it."""
        if sys.platform != "win32":  # Windows frees the memory itself
            os.unlink(self.name)


def addresses() -> Iterator[tuple[str, str, bytes]]:
    """Yield IPv4 address, netmask and hardware address of each interface; only on Linux."""
    if sys.platform != "linux":
        return
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        for _, name in socket.if_nameindex():
            with suppress(OSError):  # the interface has no IPv4 address, or has gone
                own, mask = (_ask(any_socket, name, one)[4:8] for one in (0x8915, 0x891B))
                hardware = _ask(any_socket, name, 0x8927)[2:8]
                yield socket.inet_ntoa(own), socket.inet_ntoa(mask), hardware


def _ask(any_socket: socket.socket, name: str, question: int) -> bytes:
    """Query an interface by ioctl; return a `struct sockaddr`.

    It contains the family, then port or hardware address.
    """
    if sys.platform != "linux":
        return b""
    import fcntl

    request = struct.pack("256s", name.encode()[:15])
    return fcntl.ioctl(any_socket.fileno(), question, request)[16:32]


def loaded(file: str) -> None:
    """Remove the file of a library that was just loaded; on Windows this is possible only later."""
    if sys.platform != "win32":
        os.unlink(file)


def unload(handle: int, file: str) -> None:
    """Unload a library, and remove its file if the system could not do so while it was loaded."""
    if sys.platform == "win32":
        FreeLibrary(handle)
        with suppress(OSError):
            os.unlink(file)
    else:
        dlclose(handle)
