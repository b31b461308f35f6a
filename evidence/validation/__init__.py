"""Validation of the contact kernel against solutions that share no code with it.

One module per case; `python -m evidence.validation` writes docs/validation.md and its figures.
"""
