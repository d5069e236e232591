"""Model -> Programs: the operations of every function of a scene, as plain data."""

from phichain.lowering.lower import Lowered, lower, lower_function

__all__ = ["Lowered", "lower", "lower_function"]
