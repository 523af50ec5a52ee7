"""The cyclic I/O of a connection, for either end, in its own process."""
