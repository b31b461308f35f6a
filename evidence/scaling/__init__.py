"""How a study scales, measured on the ranks that are at hand."""
