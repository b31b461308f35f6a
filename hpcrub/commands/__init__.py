"""The commands, one module for each: run, plot, merge, inspect, import, keys.

Thin: parse, call, print, exit code. `notebook` has what `import hpcrub` offers to Python.

Imports every other room.
"""
