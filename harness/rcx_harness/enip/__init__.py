"""The virtual controller as an EtherNet/IP adapter, and a scanner to exchange its areas.

The adapter's CIP objects are objects of the package cpppo. Only the module `objects` imports cpppo,
in the process of the adapter.
"""
