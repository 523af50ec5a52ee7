"""Bytes of CIP and its encapsulation; nothing here opens a socket."""
