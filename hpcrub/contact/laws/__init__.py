"""Contact laws: which forces the casing exerts on the tips. One law, one module, one class.

`planar.Planar` is the law of planar disks, `solid.Solid` that of disks that move in three
dimensions; `protocols.Law` says what another one needs. The arrays of a law are a NamedTuple in its
`bank.Bank`, and its class has the methods. What the points of these two laws meet is a surface,
`hard.Hard` or `surfaces.Coated` (`protocols.Surface`).
"""
