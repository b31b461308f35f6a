"""Datasets and report lines that several studies share: coatings, casings that vibrate, air."""
