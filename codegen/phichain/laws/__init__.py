"""Laws: frozen records of controllers, made by `control` and written as Programs by `lowering`."""

from phichain.laws.state_feedback import StateFeedback
from phichain.laws.trajectory import TrajectoryLaw

__all__ = ["StateFeedback", "TrajectoryLaw"]
