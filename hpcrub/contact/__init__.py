"""The contact kernel: time steps of many angular speeds at once, and the contact forces.

In: modes of a sample, time step, casing. Out: displacements and contact forces, status codes.
Imports `model`.

Compiled functions take ``lanes``, a tuple of as many zeros as there are lanes, whose length tells
the compiler the width; a `Bank`, or its parts ``scheme``, ``state`` and ``law``, of which they
modify state and law; ``step``, the row of the bump table; ``n_active``, the entries of
`State.active` that count; ``deepest``, the deepest penetration of the step (L,) [m]; and ``begin``
and ``end``, the first mode and the one after the last; ``n_groups``, the groups of blades with
listed points, and ``group``, one of them; ``threshold``, the penetration from which on a blade
counts in a lane (L,) [m], and ``limit``, the tolerance of a multiplier or penetration (L,) [m].
Their docstrings name what else there is.
"""
