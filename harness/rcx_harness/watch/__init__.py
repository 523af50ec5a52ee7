"""The checks of programs: the data on the network, and the behaviour and calls of blocks."""
