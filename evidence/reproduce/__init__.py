"""All studies of the paper in one go, and the report that holds them against its numbers."""
