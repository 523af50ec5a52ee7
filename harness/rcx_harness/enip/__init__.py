"""The virtual controller as an EtherNet/IP adapter, and a scanner to exchange its areas.

The package cpppo holds the adapter's objects; only `objects` imports it, in the process of the
adapter.
"""
