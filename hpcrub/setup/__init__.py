"""Construction of what a configuration describes: tuned disk, mistuned disks, scene.

In: a `Config`. Out: models, modes and scenes for `response`; warnings about unresolved numbers.
"""
