"""The translation for the solver against the engines, on random scans."""
