"""Linear complementarity problems of the contact forces: λ ≥ 0, p − Wλ ≤ 0, λ·(p − Wλ) = 0."""
