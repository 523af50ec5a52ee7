"""Rockwell L5X of Studio 5000: its Structured Text with tags, data types and tasks."""

from structured_text.projects.rockwell.read import read_l5x

__all__ = ["read_l5x"]
