"""`rcx points`: points and the other stored data of a controller, to a file and back."""
