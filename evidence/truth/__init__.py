"""What the product is held against: the paper's disk, exact solutions, twins in plain Python."""
