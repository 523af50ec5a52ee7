"""The checks of programs: the rules of the wire, and the contract and calls of each block."""
