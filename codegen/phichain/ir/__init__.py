"""The intermediate representation: Programs as plain data, what writes them, runs them and rewrites them. It knows no scene."""

from phichain.ir.evaluate import evaluate, evaluate_exactly
from phichain.ir.nodes import Program
from phichain.ir.passes import count_operations, prune, total_operations, unroll

__all__ = ["Program", "count_operations", "evaluate", "evaluate_exactly", "prune", "total_operations", "unroll"]
