"""Sequential Function Charts: their model, their text form, and their translation to statements."""
