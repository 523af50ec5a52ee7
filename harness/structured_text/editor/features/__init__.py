"""The features of the language server, one module with a function of its name for each feature."""
