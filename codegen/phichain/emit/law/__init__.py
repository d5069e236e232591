"""Controllers as folders of C and CasADi text, each law printed once."""

from __future__ import annotations

from phichain.emit.law.closed_loop import closed_loop_files
from phichain.emit.law.controller import controller_files
from phichain.emit.law.output import output_feedback_files
from phichain.emit.law.output_table import output_table_files
from phichain.emit.law.table import table_files
from phichain.laws import GainTable, Law, OutputFeedback, OutputTable


def law_files(law: Law, real: str = "double") -> dict[str, str]:
    """The whole folder of a law by file name, whatever kind it is; arguments and errors as in `controller_files`."""
    if isinstance(law, GainTable):
        return table_files(law, real)
    if isinstance(law, OutputTable):
        return output_table_files(law, real)
    return output_feedback_files(law, real) if isinstance(law, OutputFeedback) else controller_files(law, real)


__all__ = ["closed_loop_files", "law_files"]
