"""What the project's own pages, library and evidence are made with; not in the wheel."""
