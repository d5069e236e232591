"""Program -> Program: tangents and Jacobians, Taylor recurrences, factors and columns. It knows no scene."""

from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian, sparsity

__all__ = ["Block", "jacobian", "sparsity"]
