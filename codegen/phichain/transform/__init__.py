"""Program -> Program: tangents, Jacobians, and what parameters alone determine. It knows no scene."""

from phichain.transform.blocks import Block
from phichain.transform.tangent import jacobian, sparsity

__all__ = ["Block", "jacobian", "sparsity"]
