"""Ladder and Function Block Diagrams: their model and their translation to statements."""
