"""Evidence about this library: the checks, their list, and the page with their results."""
