"""Laws -> Programs: controllers in the same form as the dynamics, for the same printers."""

from phichain.lowering.laws.output_feedback import NEXT, output_feedback, output_feedback_reset
from phichain.lowering.laws.state_feedback import controller, full_turn

__all__ = ["NEXT", "controller", "full_turn", "output_feedback", "output_feedback_reset"]
