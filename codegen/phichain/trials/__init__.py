"""Compiled laws tried on compiled chains: many runs with parameters of their own, and the search that is judged by them."""

from phichain.trials.climb import Climbed, climb
from phichain.trials.law_trials import law_trials
from phichain.trials.monte_carlo import Trials, monte_carlo
from phichain.trials.on_file import LawOnFile, law_on_file
from phichain.trials.runs import Disturbed, Runs
from phichain.trials.swing_up import SwingUp, swing_up

__all__ = [
    "Climbed", "Disturbed", "LawOnFile", "Runs", "SwingUp", "Trials", "climb", "law_on_file", "law_trials", "monte_carlo", "swing_up",
]  # fmt: skip
