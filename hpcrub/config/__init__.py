"""Validation of YAML text and command-line overrides into a `Config`, with clear error messages.

In: text. Out: `Config`. It imports `model`, and default values from `response`.
"""
