"""The command line: run, merge, inspect, plot. Thin: parse, call, print, exit code.

Imports every other room.
"""
