"""`rcx serve`: virtual controllers in real time, for a real PLC, in the terminal and on a page."""

__all__: list[str] = []
