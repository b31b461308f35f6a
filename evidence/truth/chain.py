"""Matrices of a chain of equal finite elements."""

import numpy as np


def assemble(element, n_elements, closed=False):
    """Matrices of a chain, of those of one element; a closed one ends where it starts."""
    per_node = len(element[0]) // 2
    n_dof = per_node * (n_elements + (not closed))
    matrices = np.zeros((len(element), n_dof, n_dof))
    for total, part in zip(matrices, element, strict=True):
        for e in range(n_elements):
            dof = (per_node * e + np.arange(2 * per_node)) % n_dof
            total[np.ix_(dof, dof)] += part
    return matrices
