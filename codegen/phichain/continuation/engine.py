"""Engine: the freely chosen parts of a continuation run."""

from __future__ import annotations

from dataclasses import dataclass

from phichain.continuation import correctors, predictors
from phichain.continuation.correctors import Corrector
from phichain.continuation.options import Options
from phichain.continuation.predictors import Predictor


@dataclass(frozen=True)
class Engine:
    """The freely chosen parts of a run."""

    predictor: Predictor = predictors.tangent
    corrector: Corrector = correctors.pseudo_arclength
    options: Options = Options()  # noqa: RUF009 - a frozen record
