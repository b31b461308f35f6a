"""The outer faces of a solid mesh, to draw it."""

import numpy as np

TETRAHEDRON = ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))
WEDGE = ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (0, 2, 5, 3))
HEXAHEDRON = (
    (0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 3, 7, 4),
)  # fmt: skip
FACES = {4: TETRAHEDRON, 10: TETRAHEDRON, 6: WEDGE, 15: WEDGE, 8: HEXAHEDRON, 20: HEXAHEDRON}


def skin(elements: list) -> np.ndarray:
    """Faces that belong to one element only.

    elements: (n,) nodes of each, corners first, of tetrahedra, wedges and hexahedra;
        others have no faces.
    Returns (F, 4) int; corners of every outer face, a triangle's last one twice.
    """
    seen = {}
    for nodes in elements:
        for face in FACES.get(len(nodes), ()):
            corners = [int(nodes[k]) for k in face]
            key = tuple(sorted(corners))
            seen[key] = None if key in seen else corners
    faces = [face if len(face) == 4 else [*face, face[-1]] for face in seen.values() if face]
    return np.array(faces, dtype=np.int64).reshape(-1, 4)
