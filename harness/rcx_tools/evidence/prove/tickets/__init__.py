"""Turns on the two channels, for any number of blocks: tickets are taken, served and passed on."""

from rcx_tools.evidence.prove.tickets import free, turns

__all__ = ["PROPERTIES"]

PROPERTIES = (*turns.PROPERTIES, *free.PROPERTIES)
