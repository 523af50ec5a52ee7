"""The judges of a running program: rules of the wire, contract and calls of each block."""
