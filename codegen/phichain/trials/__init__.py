"""Compiled laws tried on compiled chains: many runs with parameters of their own, and the search that is judged by them."""

from phichain.trials.climb import Climbed, climb
from phichain.trials.compiled import Compiled
from phichain.trials.monte_carlo import Trials, monte_carlo
from phichain.trials.swing_up import SwingUp, swing_up

__all__ = ["Climbed", "Compiled", "SwingUp", "Trials", "climb", "monte_carlo", "swing_up"]
