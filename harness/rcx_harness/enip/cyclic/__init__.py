"""The cyclic I/O of a connection, from whichever end, in a process of its own."""
