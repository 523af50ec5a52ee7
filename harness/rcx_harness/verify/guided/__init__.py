"""Guided campaigns: rare states are kept, and further runs branch from them."""
