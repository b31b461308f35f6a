"""The contact kernel: time steps of many angular speeds at once, and the contact forces.

From the modes of a sample, a time step and a casing, the room computes displacements, contact
forces and status codes. It imports `model`.

Parameters of compiled functions, whose docstrings describe only further ones:

    lanes             zeros, one per lane: the length of this tuple tells the compiler the width
    bank              `Bank`; or its parts scheme, state (modified) and law (modified)
    step              row of the bump table
    n_active          number of entries of `State.active` that count
    deepest           deepest penetration of the step (L,) [m]
    begin, end        first mode of a block, and the mode after the last
    n_listed          number of listed points, those of blades that touch or nearly do
    threshold         penetration from which on a blade counts in a lane (L,) [m]
    limit             tolerance of a multiplier or penetration (L,) [m]
"""
