"""Evidence about this library: the checks, their list, and their page."""
