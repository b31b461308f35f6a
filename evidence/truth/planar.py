"""The planar disk as a model file: tips have directions, all other dof are generalised."""

import numpy as np

from evidence.truth.hexahedra import stored


def planar_arrays(disk):
    """Arrays of a model file of a planar Disk."""
    n, N = len(disk.mass), len(disk.contact_angle)
    dof = np.column_stack([np.full(n, -1), np.zeros(n, int)])
    for direction in (0, 1):
        dof[disk.contact_dof[:, direction]] = np.column_stack(
            [np.arange(N), np.full(N, direction + 1)]
        )
    blades = np.zeros((n, n))
    for rows, part in zip(disk.blade_dof, disk.blade_stiffness, strict=True):
        blades[np.ix_(rows, rows)] += part
    place = disk.contact_radius * np.array([np.cos(disk.contact_angle), np.sin(disk.contact_angle)])
    return {
        "hpcrub_model": np.array(1),
        "kind": np.array("disk"),
        "frame": np.array("cylindrical"),
        "nodes": np.column_stack([*place, np.zeros(N)]),
        "dof": dof,
        "contact_node": np.arange(N),
        "contact_blade": np.arange(N),
    } | stored(M=disk.mass, K=disk.stiffness, K_blade=blades)
