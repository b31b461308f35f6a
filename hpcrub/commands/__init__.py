"""The commands, one module for each: run, plot, report, merge, inspect, import, keys.

A command only parses, calls, prints and returns an exit code. `notebook` is for use from Python.

This room imports every other one.
"""
