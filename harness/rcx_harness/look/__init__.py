"""A look at a controller: its areas, its identity, its signals in plain words."""
