"""The garbage collector pauses while a tree is built."""

from __future__ import annotations

import gc
from threading import Barrier, Thread

from structured_text.language.compiling import uncollected


def test_the_collector_is_off_until_the_last_pause_has_ended() -> None:
    """With two overlapping pauses, garbage collection is off until the second one has ended."""
    assert gc.isenabled()
    first, second = uncollected(), uncollected()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert not gc.isenabled()
    second.__exit__(None, None, None)
    assert gc.isenabled()


def test_pauses_of_several_threads_leave_the_collector_on() -> None:
    """After pauses in several threads, garbage collection is on."""
    barrier = Barrier(8)

    def pause() -> None:
        barrier.wait()
        for _ in range(200):
            with uncollected():
                pass

    threads = [Thread(target=pause) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert gc.isenabled()
