"""Check of the translation for the solver: it is compared with the engines on random scans."""
