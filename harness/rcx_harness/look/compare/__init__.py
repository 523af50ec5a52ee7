"""`rcx compare`: what a controller did, beside what the virtual one does with the same input."""
