"""What an editor needs: the language server and the formatter."""
