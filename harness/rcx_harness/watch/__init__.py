"""Who judges a run while it goes on: the wire, the contract of each block, and how it is called."""
