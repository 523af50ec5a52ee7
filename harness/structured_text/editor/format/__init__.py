"""The formatter of Structured Text: indentation, spaces, columns and capitals."""
