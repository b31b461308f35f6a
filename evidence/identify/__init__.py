"""Search for the dimensions of the paper's disk, which are not published."""
