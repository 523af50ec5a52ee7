"""`rcx compare`: a recorded controller beside the virtual one with the same input."""
