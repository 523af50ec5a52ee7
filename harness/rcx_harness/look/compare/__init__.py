"""`rcx compare`: compare a recorded controller with the virtual controller at the same input."""
