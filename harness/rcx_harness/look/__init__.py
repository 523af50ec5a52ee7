"""Tools that observe a controller: they show, record, judge and compare its areas and signals."""
