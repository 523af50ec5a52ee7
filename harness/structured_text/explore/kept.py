"""What of a program's state has an effect later: what a library says of its types.

A variable that is not named here is kept as it is. One is named only if every call writes it
before it is read (dropped), or if it has the same value after every scan (fixed), or if it is read
only under a condition. No entry is believed: for every state that is found one scan is repeated
with arbitrary values in whatever the tables leave out, with all tickets shifted and at another
time, and must lead to the same state (`search`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

__all__ = ["Kept", "Tables"]


@dataclass(frozen=True)
class Kept:
    """Which variables of one type are not kept as they are.

    Attributes:
        dropped: Written before they are read, in every scan in which they are read.
        fixed: The same after every scan: constants, and requests that are cleared at its end.
        flags: Words of which only "is it 0" has an effect later: the shown ErrorID.
        while_true: Condition -> what is read only while it is true. The condition is Python, with
            `o` for the object itself and `robot` for what the blocks share: `Tables.shared`.
        tickets: Ticket -> channel on which it stands, as `command`, `sequence` or `own`.
        scans: Numbers of scans: that of the last one, or of one before.
    """

    dropped: str = ""
    fixed: str = ""
    flags: str = ""
    while_true: Mapping[str, str] = field(default_factory=dict)
    tickets: Mapping[str, str] = field(default_factory=dict)
    scans: str = ""


@dataclass(frozen=True)
class Tables:
    """What is known of a library's blocks and structures; all names are in upper case.

    Its blocks take tickets of channels and compare them with the channel's Serving, and they have
    the number of the scan in what they share. Without tables everything is kept as it is.

    Attributes:
        types: What is not kept as it is, by the name of the type.
        reference: A structure that a program has once: all blocks of one device have it.
        variable: How programs call that variable, of which not all is kept.
        member: The member of it that conditions call `robot`.
        shared: The type of this member.
        devices: What a program has several of, if it has that structure more than once.
        unless: Members of `shared` that are dropped unless the program has a block.
        channel: The structure of a channel, whose tickets count.
        job: The block that works on the channel that it is given.
        owners: Blocks whose job works on another channel than `sequence`.
        own: Blocks whose job works on a channel of their own.
        clock: A block that starts its timer anew in each scan, and reads the time since the last.
        core: How the names of blocks and structures begin that no program uses by itself.
    """

    types: Mapping[str, Kept] = field(default_factory=dict)
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
