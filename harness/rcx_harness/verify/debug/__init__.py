"""The cell-specific part of the debugger, and recordings of cells."""
