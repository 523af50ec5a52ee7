"""The guard of a child process: it runs one program, and ends it when the parent ends.

`structured_text.output.programs` starts this script, except on Windows. The script imports few
modules and leads a session of its own. Its argument is the number of one end of a socket. Only the
parent has the other end, so the socket closes when the parent ends. Then the guard ends all
processes of the session.
"""

from __future__ import annotations

import os
import select
import signal
import sys
from contextlib import suppress
from typing import NoReturn

assert sys.platform != "win32"

#: Time for the program to write its data after SIGTERM, before it is killed [s].
_GRACE_S = 2.0
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGPIPE)


def _main(parent: int, command: list[str]) -> NoReturn:
    try:
        _run(parent, command)
    finally:  # this also runs after an error in the guard
        os.killpg(0, signal.SIGKILL)
        os._exit(1)  # not reached, because the signal also ends the guard


def _run(parent: int, command: list[str]) -> None:
    """Run the program until the parent ends, then terminate it."""
    os.set_inheritable(parent, False)
    # the guard ignores these signals, so that only the program handles them
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    ended, waking = os.pipe()
    os.set_blocking(waking, False)
    signal.set_wakeup_fd(waking, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    try:
        pid = os.posix_spawnp(
            command[0], command, os.environ, setsigmask=[], setsigdef=list(_SIGNALS)
        )
    except OSError as error:
        _say(parent, str(error.errno))
        os._exit(1)
    _say(parent, "0")
    while True:
        ready = select.select([parent, ended], [], [])[0]
        _leave_with(pid)
        if parent in ready and not _says_anything(parent):
            break
        if ended in ready:
            os.read(ended, 512)
    os.killpg(0, signal.SIGTERM)
    select.select([ended], [], [], _GRACE_S)


def _say(parent: int, word: str) -> None:
    with suppress(OSError):  # the parent may have ended already
        os.write(parent, word.encode())


def _says_anything(parent: int) -> bool:
    try:
        return bool(os.read(parent, 1))
    except OSError:
        return False


def _leave_with(pid: int) -> None:
    """Exit with the code or signal of the program, if it has ended."""
    found, status = os.waitpid(pid, os.WNOHANG)
    if not found:
        return
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        os._exit(code)
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # the guard itself must not write a core file
    if -code != signal.SIGKILL:
        signal.signal(-code, signal.SIG_DFL)
    os.kill(os.getpid(), -code)
    os._exit(1)  # if the signal does not end a process, exit with a code


if __name__ == "__main__":
    _main(int(sys.argv[1]), sys.argv[2:])
