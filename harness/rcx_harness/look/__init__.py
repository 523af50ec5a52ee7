"""Tools that look at a controller: they show, record, judge and compare its areas and signals."""
