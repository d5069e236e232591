"""From gains, an observer and integrals to the frozen law that C is made of."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from phichain.control.gains import Gains
from phichain.control.rig.integral import Integrating, with_integrals
from phichain.control.rig.observer import Estimator
from phichain.errors import ControlError
from phichain.laws import OutputFeedback, StateFeedback


def output_law(
    gains: Gains,
    estimate: Estimator | None = None,
    integrals: Mapping[str, float] | Integrating | None = None,
    target: ArrayLike | None = None,
    *,
    u_0: ArrayLike | None = None,
    limit: ArrayLike | None = None,
    wrap: bool = True,
) -> OutputFeedback:
    """The law of a sampled regulator with an observer in front of it, integrals beside it, or both.

    Args:
        gains: A sampled regulator.
        estimate: Its observer, from `estimator`; None where the whole state is measured.
        integrals: Weights of integrals by name, or what `with_integrals` made of them.
        target: Where the cart is to stand (cart,), m; the origin unless given.
        u_0: Input that keeps the chain there (nu,); zero unless given.
        limit: Largest size of every input; no limit unless given.
        wrap: Whether angles count modulo a full turn.

    Raises:
        ControlError: The regulator is not sampled, neither is asked for, or what is integrated is not measured.
        ArrayError: As `Gains.law`.
    """
    if estimate is None and not integrals:
        raise ControlError("observer, integrals", None, "are both left out", "give one, or take gains.law()")
    if isinstance(integrals, Integrating):
        integrating: Integrating | None = integrals
    else:
        integrating = with_integrals(gains, integrals) if integrals else None
    plain = gains.law(target, u_0=u_0, limit=limit, wrap=wrap)
    K = gains.K if integrating is None else integrating.K
    reads = tuple(range(len(plain.state_names))) if estimate is None else estimate.reads
    on = gains.on_state(K)
    at = gains.on_state(np.eye(K.shape[1])).wraps if gains.space == "planar" else (False,) * K.shape[1]
    return OutputFeedback(
        name=plain.name,
        digest=plain.digest,
        measured_names=tuple(plain.state_names[k] for k in reads),
        measured_units=tuple(plain.state_units[k] for k in reads),
        reads=reads,
        offsets=tuple(plain.target[k] for k in reads),
        wraps=tuple(plain.wraps[k] for k in reads),
        deviation_names=plain.state_names if estimate is None else gains.state_names,
        turns=plain.wraps if estimate is None else tuple(turns and wrap for turns in at),
        input_names=plain.input_names,
        input_units=plain.input_units,
        rest=plain.rest,
        gains=on.gains if estimate is None else K,  # type: ignore[arg-type]
        low=plain.low,
        high=plain.high,
        sample=plain.sample,
        p=plain.p,
        observer=None if estimate is None else estimate.observer,
        integrated=_integrated(plain, reads, integrating),
        integral_gains=() if integrating is None else integrating.K_i,  # type: ignore[arg-type]
    )


def _integrated(plain: StateFeedback, reads: tuple[int, ...], integrating: Integrating | None) -> tuple[int, ...]:
    if integrating is None:
        return ()
    for name, at in zip(integrating.integrated, integrating.reads, strict=True):
        if at not in reads:
            shown = ", ".join(plain.state_names[k] for k in reads)
            raise ControlError("integral", name, f"is not measured: only {shown} is", "measure it too")
    return tuple(reads.index(at) for at in integrating.reads)
