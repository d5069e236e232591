"""Programs: the operations of every function of a scene, as plain data."""

from phichain.program.evaluate import evaluate, evaluate_exactly
from phichain.program.lower import Lowered, lower, lower_function
from phichain.program.nodes import Program
from phichain.program.passes import count_operations, prune, total_operations, unroll
from phichain.program.tangent import Block, jacobian, sparsity

__all__ = [
    "Block", "Lowered", "Program", "count_operations", "evaluate", "evaluate_exactly", "jacobian", "lower",
    "lower_function", "prune", "sparsity", "total_operations", "unroll",
]  # fmt: skip
