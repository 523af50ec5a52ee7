"""The virtual controller as an EtherNet/IP adapter, and a scanner that exchanges its areas.

The package cpppo provides the adapter's CIP objects. Only the module `objects` imports cpppo, and
only in the adapter's process.
"""
