"""The part of the debugger that is specific to cells with robots, and recordings of cells."""
