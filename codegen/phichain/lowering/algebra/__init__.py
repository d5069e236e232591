"""Vectors and small matrices of Program scalars, free of cancellation."""
