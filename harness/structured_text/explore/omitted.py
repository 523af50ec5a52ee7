"""Tables of the variables that have no later effect, for the types of a library.

A variable that no table names is stored unchanged. A table may name a variable only if every call
writes it before reading it (dropped), if it has the same value after every scan (fixed), or if it
is read only under a condition. The search checks the entries (`search`). For every new state it
repeats one scan. In the repeated scan, all omitted variables have arbitrary values, all tickets are
shifted by the same number, and the PLC time differs. This scan must lead to the same state.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

__all__ = ["Omitted", "Tables"]


@dataclass(frozen=True)
class Omitted:
    """The variables of one type that are not stored unchanged.

    Attributes:
        dropped: Variables that every scan writes before it reads them.
        fixed: Variables with the same value after every scan: constants, and requests that are
            cleared at the end of a scan.
        flags: Words that later scans only compare with zero, such as the displayed ErrorID.
        while_true: For each condition, the variables that are read only while the condition is
            true. A condition is a Python expression. In it, `o` is the object with the variables,
            and `robot` is the shared structure (`Tables.shared`).
        tickets: The channel of each ticket, as `command`, `sequence` or `own`.
        scans: Variables that contain the number of a scan. A state stores only whether this is the
            number of the last scan.
    """

    dropped: str = ""
    fixed: str = ""
    flags: str = ""
    while_true: Mapping[str, str] = field(default_factory=dict)
    tickets: Mapping[str, str] = field(default_factory=dict)
    scans: str = ""


@dataclass(frozen=True)
class Tables:
    """The blocks and structures of a library, for the abstraction; all names are in upper case.

    The blocks take tickets of channels and compare them with the channel's Serving. The shared
    structure contains the number of the scan. Without tables every variable is stored unchanged.

    Attributes:
        types: Variables that are not stored unchanged, by the name of the type.
        reference: A structure that a program has once: all blocks of one device refer to it.
        variable: The name of this structure in a program; it is stored only in part.
        member: The member of this structure that conditions call `robot`.
        shared: The type of this member.
        devices: A word for the devices in messages, if a program has several such structures.
        unless: Members of `shared`, each with a block. A member is stored only if the program has
            this block.
        channel: The structure of a channel, which counts the tickets.
        job: The block that works on the channel that its caller passes.
        owners: Blocks whose job works on another channel than `sequence`.
        own: Blocks whose job works on a private channel.
        clock: A block that restarts its timer in each scan, and reads the time since the last scan.
        core: Prefixes of the names of blocks and structures that no program uses directly.
    """

    types: Mapping[str, Omitted] = field(default_factory=dict)
    reference: str = ""
    variable: str = ""
    member: str = ""
    shared: str = ""
    devices: str = ""
    unless: Mapping[str, str] = field(default_factory=dict)
    channel: str = ""
    job: str = ""
    owners: Mapping[str, str] = field(default_factory=dict)
    own: Collection[str] = ()
    clock: str = ""
    core: tuple[str, ...] = ()
