"""`rcx probe`: questions to a real controller, each tied to the assumed rules that it decides."""
