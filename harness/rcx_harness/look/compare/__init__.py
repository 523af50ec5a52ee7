"""`rcx compare`: compare a recorded and the virtual controller at the same input."""
