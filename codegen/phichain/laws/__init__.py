"""Laws: frozen records of controllers, made by `control` and written as Programs by `lowering`."""

from phichain.laws.family import FamilyLaw
from phichain.laws.gain_table import GainTable
from phichain.laws.learning import FORGOTTEN, STILL, Learning
from phichain.laws.observer import Observer
from phichain.laws.observer_along import ObserverAlong
from phichain.laws.output_feedback import OutputFeedback
from phichain.laws.output_table import OutputTable
from phichain.laws.state_feedback import StateFeedback
from phichain.laws.table_memory import TableMemory
from phichain.laws.trajectory import TrajectoryLaw

Law = StateFeedback | OutputFeedback | GainTable | OutputTable
"""Whatever a controller is made of."""

__all__ = [
    "FORGOTTEN", "STILL", "FamilyLaw", "GainTable", "Law", "Learning", "Observer", "ObserverAlong", "OutputFeedback", "OutputTable", "StateFeedback",
    "TableMemory", "TrajectoryLaw",
]  # fmt: skip
