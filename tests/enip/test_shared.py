"""A reader of a shared assembly never gets a partly written image."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

import exchange_bench
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import GAPS, Drop, LinkState, SharedImage, SharedImages, Word
from structured_text.output.system import SharedMemory

OWNER = replace(exchange_bench.OWNER, o_to_t_api_us=4_000)


@pytest.fixture
def images() -> Iterator[SharedImages]:
    with SharedImages.create(48) as images:
        yield images
        images.unlink()


@pytest.mark.parametrize(("to_master", "to_robot"), [(48, 48), (256, 256), (5, 700)])
def test_images_are_read_completely_by_a_process_that_attaches_by_name(
    to_master: int, to_robot: int
) -> None:
    with SharedImages.create(to_master, to_robot) as ours, SharedImages.attach(ours.name) as theirs:
        ours.unlink()
        assert (ours.to_master.read(), ours.to_robot.read()) == (bytes(to_master), bytes(to_robot))
        for _ in range(20):
            ours.to_master.write(b"\xa5" * to_master)
            theirs.to_robot.write(b"\x5a" * to_robot)
        assert theirs.size == to_master
        assert theirs.to_master.read() == b"\xa5" * to_master
        assert ours.to_robot.read() == b"\x5a" * to_robot


def test_memory_that_was_not_created_is_not_found() -> None:
    """Memory with a wrong name is not found.

    On Windows, a wrong name gives new memory with zeros, which is rejected as well.
    """
    with pytest.raises(FileNotFoundError):
        SharedImages.attach("/dev/shm/rcx-of-nobody")
    nobodys = SharedMemory(size=4096)
    try:
        with pytest.raises(FileNotFoundError):
            SharedImages.attach(nobodys.name)
    finally:
        nobodys.unlink()
        nobodys.close()


def test_the_version_counts_the_writes(images: SharedImages) -> None:
    for _ in range(20):
        images.to_master.write(bytes(48))
    assert images.to_master.version == 20
    assert images.to_robot.version == 0


def test_an_image_of_another_size_is_refused(images: SharedImages) -> None:
    images.to_master.write(bytes([1] * 48))
    for wrong in (bytes(47), bytes(49)):
        with pytest.raises(ValueError, match="different structures"):
            images.to_master.write(wrong)
    assert images.to_master.read() == bytes([1] * 48)


def watched(memory: memoryview, parts: Mapping[int, object]) -> Any:
    """Return an object that behaves as `memory`, but has replaced parts at some offsets."""

    class Watched:
        def __getitem__(self, part: slice) -> object:
            return parts.get(part.start or 0, memory[part])

    return Watched()


def test_if_a_writer_dies_readers_get_the_previous_image() -> None:
    """If the writer dies while it writes an image, readers get the previous image.

    An image is valid only after its version is written, which is the last step.
    """
    memory = memoryview(bytearray(SharedImage.needs(4)))
    image = SharedImage(memory, 4)
    image.write(b"whol")
    # Version 1 is in the second slot of eight bytes; the third slot is half written.
    memory[8 + 2 * 8 : 8 + 2 * 8 + 2] = b"xx"
    assert image.read() == b"whol"


def test_a_reader_reads_again_if_its_image_may_be_overwritten() -> None:
    """If seven newer images are written during a read, the reader reads again.

    The eighth write would use the slot that is being read.
    """
    memory = memoryview(bytearray(SharedImage.needs(4)))
    writer = SharedImage(memory, 4)
    writer.write(b"0000")

    class OvertakenSlot:
        """A replacement for the slot of version 1, which is overwritten during a read."""

        def __bytes__(self) -> bytes:
            for number in range(2, 9):
                writer.write(f"{number:04}".encode())
            return b"torn"

    # The memory has a word of eight bytes, then slots of eight bytes. Version 1 is in the second
    # slot.
    reader = SharedImage(watched(memory, {8 + 8: OvertakenSlot()}), 4)
    assert reader.read() == b"0008"


def test_no_reader_gets_a_partly_written_image() -> None:
    """While another process writes images of equal bytes, each read image has equal bytes."""
    writer = textwrap.dedent(
        """
        import sys
        from rcx_harness.enip.cyclic.shared import SharedImages
        with SharedImages.attach(sys.argv[1]) as images:
            patterns = [bytes([number]) * 256 for number in range(256)]
            print("ready", flush=True)
            while images.link == 0:
                for pattern in patterns:
                    images.to_robot.write(pattern)
        """
    )
    seen = set()
    with SharedImages.create(256) as images:
        process = subprocess.Popen(
            [sys.executable, "-c", writer, images.name], stdout=subprocess.PIPE
        )
        assert process.stdout is not None
        process.stdout.readline()
        images.unlink()
        try:
            for _ in range(20_000_000):
                seen.add(images.to_robot.read())
                if len(seen) >= 64:
                    break
        finally:
            images.link = LinkState.CUT
            process.communicate(timeout=60)
    assert len(seen) >= 64, "the writer did not write during the test"
    assert all(len(set(image)) == 1 for image in seen)


def test_the_status_names_the_owner_and_counts_its_changes(images: SharedImages) -> None:
    status = images.status()
    assert (status.owner, status.generation, status.peer) == (OwnerState.NONE, 0, "")
    images.set_owner(OwnerState.WAITING, OWNER)
    images.set_owner(OwnerState.RUN, OWNER)
    status = images.status()
    assert (status.owner, status.generation) == (OwnerState.RUN, 2)
    assert status.peer == "192.168.0.7"
    assert (status.o_to_t_api_us, status.t_to_o_api_us) == (4_000, 10_000)
    images.set_owner(OwnerState.CLOSED, None)
    status = images.status()
    assert (status.owner, status.generation, status.peer) == (OwnerState.CLOSED, 3, "")
    assert (status.o_to_t_api_us, status.t_to_o_api_us) == (0, 0)


class Recorder:
    """A replacement for memory. It records each write and the result of `look` at this time."""

    def __init__(self, look: Callable[[], int] = lambda: 0) -> None:
        self.written: list[object] = []
        self.seen: list[int] = []
        self._look = look

    def cast(self, kind: str) -> Recorder:
        """Return the recorder itself, as if the memory were cast."""
        return self

    def __getitem__(self, at: object) -> int:
        return 48  # the code reads the size of an image from here

    def __setitem__(self, at: object, value: object) -> None:
        self.written.append(at)
        self.seen.append(self._look())


def test_the_version_changes_after_the_image_is_complete() -> None:
    """The version changes only after the whole image is written."""
    memory = memoryview(bytearray(SharedImage.needs(4)))
    SharedImage(memory, 4).write(b"one.")
    slots = [Recorder(lambda: image.version) for _ in range(8)]
    image = SharedImage(watched(memory, {8 + 8 * k: slot for k, slot in enumerate(slots)}), 4)
    image.write(b"two.")
    assert [slot.seen for slot in slots if slot.seen] == [[1]]
    assert image.version == 2


def test_the_owner_state_is_written_after_its_parameters() -> None:
    words = Recorder()
    whole = watched(memoryview(bytearray(100_000)), {0: words})
    images = SharedImages(SimpleNamespace(name="", buf=whole))  # type: ignore[arg-type]
    images.set_owner(OwnerState.RUN, OWNER)
    assert words.written[-1] is Word.OWNER
    assert set(words.written[:-1]) == {Word.PEER, Word.O_TO_T_API, Word.T_TO_O_API}


def test_the_status_counts_packets_and_connections(images: SharedImages) -> None:
    for number, counter in enumerate(
        (Word.OWNERS, Word.INPUT_ONLY, Word.LISTEN_ONLY, Word.SENT), 1
    ):
        images.count(counter, number)
    for reason, number in ((Drop.UNKNOWN, 2), (Drop.JUMP, 3)):
        for _ in range(number):
            images.drop(reason)
    images.count(Word.MISSING, 6)
    images.count(Word.SKIPPED, 7)
    images.arrive(1_000, None)
    images.arrive(3_500, 2_500)
    status = images.status()
    assert (status.owners, status.input_only, status.listen_only) == (1, 2, 3)
    assert status.connections == 6
    assert (status.sent, status.dropped, status.missing, status.skipped) == (4, 5, 6, 7)
    assert status.drops == (2, 0, 0, 0, 3)
    assert status.received == 2
    assert images.arrived_us == 3_500
    assert images.gaps_us() == [2_500]


def test_the_latest_gaps_are_stored(images: SharedImages) -> None:
    for gap in range(GAPS + 2):
        images.arrive(gap, gap)
    gaps = images.gaps_us()
    assert len(gaps) == GAPS
    assert sorted(gaps) == list(range(2, GAPS + 2))


def test_a_gap_too_long_for_its_word_is_stored_as_the_largest_number(images: SharedImages) -> None:
    images.arrive(0, 2**32 + 5)
    assert images.gaps_us() == [2**32 - 1]


@pytest.mark.parametrize("state", list(LinkState))
def test_one_process_cuts_the_link_and_the_other_sees_it(
    images: SharedImages, state: LinkState
) -> None:
    with SharedImages.attach(images.name) as theirs:
        images.link = state
        assert theirs.link is state


def test_shared_images_can_be_closed_twice() -> None:
    images = SharedImages.create(48)
    images.unlink()
    images.close()
    images.close()


def test_a_journal_entry_is_read_once_by_the_other_process(images: SharedImages) -> None:
    with SharedImages.attach(images.name) as theirs:
        for number in range(3):
            theirs.events.write({"number": number})
        theirs.refusals.write({"text": "no"})
        assert images.events.read() == ([{"number": 0}, {"number": 1}, {"number": 2}], 0)
        assert images.events.read() == ([], 0)
        theirs.events.write({"number": 3})
        assert images.events.read() == ([{"number": 3}], 0)
        assert images.refusals.read() == ([{"text": "no"}], 0)


def test_a_slow_reader_of_a_journal_gets_the_number_of_lost_entries(
    images: SharedImages,
) -> None:
    """A slow reader gets the newest 127 entries and the number of lost entries.

    Of 128 entries, 127 are valid, because the writer may be writing the next one.
    """
    for number in range(1000):
        images.events.write({"number": number})
    records, lost = images.events.read()
    assert [one["number"] for one in records] == list(range(873, 1000))
    assert lost == 873


def test_a_process_shows_that_it_is_alive_by_the_clock(images: SharedImages) -> None:
    images.beat(Word.CYCLIC_ALIVE, 7_000)
    images.beat(Word.ADAPTER_ALIVE, 8_000)
    assert images.heard_us(Word.CYCLIC_ALIVE) == 7_000
    assert images.heard_us(Word.ADAPTER_ALIVE) == 8_000
