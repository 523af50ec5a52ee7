"""The metamorphic checks: a few of them, and the proof that each relation can fail."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from rcx_harness.enip import LockstepLink
from rcx_tools.evidence.metamorphic.changes import in_bytes, in_words, resized, shifted, slower
from rcx_tools.evidence.metamorphic.course import Course, Options, follow
from rcx_tools.evidence.metamorphic.programs import Subject, every_command, subjects
from rcx_tools.evidence.metamorphic.relations import RELATIONS
from rcx_tools.evidence.metamorphic.seeded import SEEDED, Seeded, find
from structured_text.engines.builtin import BuiltinProgram

SUBJECTS = {one.name: one for one in subjects()}
BUILTIN = Options(engine="builtin")
QUICK = ("example 03_general_io", "chart remote_command")


@cache
def _base(name: str) -> Course:
    return follow(SUBJECTS[name], BUILTIN)


@pytest.mark.exhaustive(
    but=[
        "example 03_general_io-engine",
        "chart remote_command-engine",
        "chart remote_command-areas",
        "chart remote_command-size",
        "chart remote_command-scan time",
        "example 03_general_io-areas",
    ]
)
@pytest.mark.parametrize("relation", RELATIONS)
@pytest.mark.parametrize("name", QUICK)
def test_what_must_not_matter_does_not_matter(name: str, relation: str) -> None:
    subject, one = SUBJECTS[name], RELATIONS[relation]
    if against := one.against(subject):
        pytest.skip(against)
    assert not _base(name).broken
    *_, variant = one.variants(subject, BUILTIN, 1)  # `make metamorphic` takes all of them
    course = follow(variant.subject, variant.options)
    assert one.differs(_base(name), course) == "", variant.name


@pytest.mark.exhaustive(but=["with 256 bytes a byte behind the head is written"])
@pytest.mark.parametrize("seeded", SEEDED, ids=lambda seeded: seeded.name)
def test_a_broken_block_is_found(seeded: Seeded) -> None:
    assert find(seeded, SUBJECTS[seeded.subject])


def test_an_engine_that_leaves_out_scans_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    subject, relation = SUBJECTS[QUICK[1]], RELATIONS["engine"]
    base = replace(_base(QUICK[1]), engine="matiec")
    whole = BuiltinProgram.scan

    def scan(self: BuiltinProgram, now_us: int) -> None:
        if not 600_000 <= now_us < 700_000:
            whole(self, now_us)

    monkeypatch.setattr(BuiltinProgram, "scan", scan)
    variants = relation.variants(subject, Options(engine="matiec"), 0)
    assert any(relation.differs(base, follow(one.subject, one.options)) for one in variants)


def test_a_link_that_alters_a_byte_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    subject, relation = SUBJECTS[QUICK[1]], RELATIONS["link"]
    base = _base(QUICK[1])
    whole = LockstepLink.scanner_read
    altered = bytes(20) + b"\x01" + bytes(27)

    def scanner_read(self: LockstepLink) -> bytes:
        area = whole(self)
        return bytes(one | two for one, two in zip(area, altered, strict=True))

    monkeypatch.setattr(LockstepLink, "scanner_read", scanner_read)
    variants = relation.variants(subject, BUILTIN, 0)
    assert any(relation.differs(base, follow(one.subject, one.options)) for one in variants)


def test_every_command_block_is_in_the_generated_program() -> None:
    source = every_command().files["EveryCommand.st"]
    blocks = sorted((SUBJECTS["every command"].files["EveryCommand.st"]).split())
    assert source.count(": FB_") == 98 + 3
    assert "FB_Jog;" in blocks


def test_a_program_is_really_changed() -> None:
    """A change that leaves the source as it is would prove nothing."""
    for subject in SUBJECTS.values():
        changes = [shifted(subject, 6, 8), slower(subject, 2)]
        changes += [] if subject.size == 256 else [resized(subject, 256)]
        changes.append(in_bytes(subject) if subject.words else in_words(subject))
        for changed in changes:
            assert _program(changed) != _program(subject)
        assert changes[-1].words is not subject.words


def test_what_lasts_so_long_lasts_so_many_times_as_long() -> None:
    """Inputs that are set for a time, and waits of robot programs."""
    name = "example 15_panel"
    delays = [step for one in slower(SUBJECTS[name], 3).robot.programs for step in one.steps]
    assert delays == ["SO2()=1", "DELAY 2700", "SO2()=2", "DELAY 1200", "SO2()=4"]
    stimulus = slower(SUBJECTS["example 13_pallet_by_table"], 2).stimulus
    assert stimulus is not None
    assert [one.held_us for one in stimulus.entries][:2] == [None, 400_000]


def _program(subject: Subject) -> str:
    return next(text for text in subject.files.values() if "PROGRAM " in text)


def test_a_relation_tells_where_the_first_difference_is() -> None:
    base = _base(QUICK[1])
    other = replace(base, scans=[*base.scans])
    seen = other.scans[10]
    other.scans[10] = seen._replace(si=b"\x01" + seen.si[1:])
    text = RELATIONS["offsets"].differs(base, other)
    assert text.startswith("scan 10 (100 ms): the area written differs from byte 0 on")
    assert "beside the area" in RELATIONS["offsets"].differs(base, replace(base, outside=1))
