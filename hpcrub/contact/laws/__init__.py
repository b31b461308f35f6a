"""Contact laws: which forces the casing exerts on the tips. One law, one module, one class.

A law is a NamedTuple of arrays, its state in a `bank.Bank`. Its type chooses the code when the
kernel is compiled, so that no scene compiles or pays for another law. `planar.Planar` is the law of
planar disks, `solid.Solid` that of disks that move in three dimensions, both before any of the
`surfaces`. Another one needs:

``per_lane()``
    Static method: names of its arrays whose last axis are the lanes, and of groups of such arrays.
    They are zero in an idle lane, which must then get no force.
``allocate(modes, scene, grid, width)``
    Class method: its state for idle lanes.
``loads(modes, scene)``
    Class method: modal forces of unit multipliers (K, F), columns in the order of
    ``State.multiplier``, without its last row.
``fill(bank, lane, modes, scene)``
    Give a lane what depends on its speed and step; its arrays are zero before.
``forces_on_points(multiplier, scene)``
    Normal, tangential and axial forces of recorded multipliers (R, F, L).
``steps_touched(lane)``
    Steps in which every blade carried a force, (0,) if the law does not count them.
``memory(lane)``
    What a later run of the lane goes on from beside its motion, None if it is nothing; else
    ``remember(lane, memory)`` gives it to a lane that is filled.
``predict(lanes, bank, step, n_active)``
    Static method, compiled: corrector of the step before, predictor and penetrations of this one;
    returns the deepest penetration. `passes.predict` serves most laws.
``forces(lanes, bank, step, deepest)``
    Static method, compiled: multipliers of a step in which something penetrates. It lists the rows
    of ``State.multiplier`` that the corrector has to apply in ``State.active``; returns how many
    they are.

What the points of these two laws meet is a *surface*, ``hard.Hard`` or ``surfaces.Coated``. A step
calls its compiled static methods in this order; `Hard` has the last argument, or nothing, for most:

``tick(lanes, surface, deepest)``
    A step begins. Returns the deepest penetration, or something positive while forces go on.
``meet(lanes, surface, state, stiffness, deepest)``
    Penetrations of the surface as it is now, in place of those of the casing.
``press(lanes, law, state, deepest)``
    All contact forces of a planar disk. A disk in three dimensions calls those below instead.
``near(lanes, surface, j, stiffness, depth)``
    Depth of a point that counts when the active set is guessed.
``relieve(lanes, surface, state, law, start, end, n)``
    Take from the depths of points what the forces of earlier steps undo.
``follow(lanes, surface, j, d)``
    Depth that the force of a point undoes of d, and the code of the line that it is on.
``line(lanes, surface, j, code)``
    Slope and start of the line of a code, with which a group of points is solved for.
``check(lanes, surface, j, p, x, code, limit, trying)``
    Where the solution does not belong to its code, and which code it belongs to.
``comply(lanes, surface, j, compliance)``
    Give a point the compliance that it has since its friction turned.
``despair(state, law, n_active)``
    What becomes of lanes whose points have no solution.
``wear(lanes, surface, state, n_active)``, ``keep(lanes, surface, i, force)``
    The surface after the step, and the forces that the next step needs.
``total(lanes, surface, i, force)``
    The force of a point with what goes on of earlier steps.

A law may stand anywhere, in a notebook for example: `response.scene.Scene.law` takes the class.
"""
