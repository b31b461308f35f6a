"""The blisk of inputs/blisk: its mesh, its CalculiX decks, its model file, and their checks."""
