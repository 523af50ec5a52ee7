"""The code of `rcx serve`: virtual controllers for a real PLC, shown in a terminal and a page."""

__all__: list[str] = []
