"""What a debugger shows of a cell, and recordings of cells."""
