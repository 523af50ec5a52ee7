"""Proofs about the tickets and turns on both channels, for any number of blocks."""

from rcx_tools.evidence.prove.tickets import free, turns

__all__ = ["PROPERTIES"]

PROPERTIES = (*turns.PROPERTIES, *free.PROPERTIES)
