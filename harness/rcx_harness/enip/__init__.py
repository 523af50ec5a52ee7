"""The virtual controller as an EtherNet/IP adapter, and a scanner to exchange its areas.

cpppo holds the adapter's objects; `objects` alone imports it, in the adapter's own process.
"""
