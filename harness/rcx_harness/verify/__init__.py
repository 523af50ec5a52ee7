"""Evidence that the blocks are right; works on the repository, not on an installed package."""
