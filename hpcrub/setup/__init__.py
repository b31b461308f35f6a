"""What a configuration describes: the tuned disk, the disks of all samples, the scene.

In: a `Config`. Out: models, modes and scenes for `response`; what of the numbers is not resolved.
"""
