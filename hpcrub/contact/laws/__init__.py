"""Contact laws, the forces of the casing on the tips: one module and one class for each law.

`planar.Planar` is the law of planar disks, `solid.Solid` the law of disks that move in three
dimensions; `protocols.Law` lists the methods of a law. The class of a law is a NamedTuple of its
arrays, and a member of `arrays.Bank`. In both laws the points meet a surface, `hard.Hard` or
`surfaces.Coated`.
"""
