"""`rcx compare`: compare a recorded controller with the virtual one at the same input."""
