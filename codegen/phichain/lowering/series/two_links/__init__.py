"""Taylor recurrences of two links on a base at rest: the matrix of a step inverted as a whole (lowering.series.planar)."""
