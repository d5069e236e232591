"""Families of orbits, how they hang together, and responses to a forcing."""

from __future__ import annotations

from typing import Any

from phichain.continuation import Branch
from phichain.orbits import Network
from phichain.orbits.forced import Response
from phichain.report import figures
from phichain.report.orbits import parameter, plane, responses
from phichain.report.shown.kinds import demand_figure, plot


@plot.register
def _(record: Branch, ax: Any = None) -> Any:
    """A family: its rate over every amplitude, folds marked; as a figure over its energy, too. A run in a parameter over that."""
    if record.names[-1] != "omega" and "omega" in record.names:
        if ax is None:
            return parameter.in_parameter(record)
        parameter.frequency(ax, record)
        return ax
    if ax is None:
        return figures.family(record)
    figures.against_amplitude(ax, record)
    return ax


@plot.register
def _(record: Network, ax: Any = None) -> Any:
    """Branches over energy, and where they hang together."""
    demand_figure(ax, record)
    return plane.network(record)


@plot.register
def _(record: Response, ax: Any = None) -> Any:
    """A response: peaks and phases over the forcing's frequency; on axes the peaks."""
    if ax is None:
        return responses.response(record)
    responses.peaks(ax, record)
    return ax
