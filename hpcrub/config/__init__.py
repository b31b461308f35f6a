"""YAML text and command-line overrides to one validated `Config`, with units and one clear message.

In: text. Out: `Config`. Imports `model`, and default values from `response`.
"""
