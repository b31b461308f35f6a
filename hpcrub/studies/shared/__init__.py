"""What studies store and say beside their own results: of coatings, casings and air."""
