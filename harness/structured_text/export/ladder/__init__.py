"""Bodies in Structured Text written as ladder: statements become rungs of contacts and blocks."""
