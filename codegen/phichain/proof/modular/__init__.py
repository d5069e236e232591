"""Programs and expressions in the integers modulo 2^61 - 1: the field, its points, and compiled functions over it."""
