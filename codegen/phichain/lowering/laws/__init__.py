"""Laws -> Programs: controllers in the same form as the dynamics, for the same printers."""

from phichain.lowering.laws.gain_table import TablePrograms, table_programs
from phichain.lowering.laws.output_feedback import NEXT, output_feedback, output_feedback_reset
from phichain.lowering.laws.output_table import OutputTablePrograms, output_table_programs
from phichain.lowering.laws.state_feedback import controller, full_turn

__all__ = [
    "NEXT", "OutputTablePrograms", "TablePrograms", "controller", "full_turn", "output_feedback", "output_feedback_reset",
    "output_table_programs", "table_programs",
]  # fmt: skip
