"""The panels that figures are put together from; each draws one thing on the axes it is given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from phichain.report.geometry import Drawn, joints
from phichain.report.style import ACCENT, INK, SOFT, shades

_MOMENTS = 14
_SMALLEST = 1e-17
_NAMED = 8
"""Curves that a legend can name."""
_SLIVER, _WIDE = 0.04, 0.28
"""Shares of a panel from which on words fit upright, and lying."""
_DOTTED = 17
"""Joints up to which each is a dot."""
VIEWS: Final = (("along $e_2$", 0, 2), ("along $e_1$", 1, 2), ("from above", 0, 1))
"""Views of a chain in space: which axes point to the right and up."""


def chain_in_motion(axes: Any, system: Drawn, q: ArrayLike, moments: int = _MOMENTS, view: tuple[int, int] = (0, -1)) -> None:
    """The chain at some moments, pale at first and dark at the end, over the path of its tip; seen along e_2 unless said.

    The moments are as far apart as the joints move between them, so that a chain that comes to rest is drawn while it
    still moves.

    Args:
        axes: Where to draw.
        system: The chain.
        q: Configurations (T, nq) in the order of time.
        moments: How many of them are drawn.
        view: Which axes point to the right and up, the last one downwards.
    """
    points = joints(system, q)
    right, up = view[0], view[1] % points.shape[-1]
    is_from_side = up == points.shape[-1] - 1
    across, high = points[..., right], -points[..., up] if is_from_side else points[..., up]
    axes.plot(across[:, -1], high[:, -1], color=ACCENT, linewidth=0.6, alpha=0.6, zorder=1)
    _at_moments(points, moments, lambda k, look: axes.plot(across[k], high[k], **look))
    if system.has_cart and is_from_side:
        _rail(axes, across[:, 0], float(np.ptp(high)) or 1.0)
    _frame(axes)
    axes.set(xlabel=f"$e_{right + 1}$ (m)", ylabel="height (m)" if is_from_side else f"$e_{up + 1}$ (m)")


def chain_in_space(axes: Any, system: Drawn, q: ArrayLike, moments: int = _MOMENTS) -> None:
    """The same in perspective, on axes of three dimensions."""
    points = joints(system, q) * np.array([1.0, 1.0, -1.0])
    axes.plot(*points[:, -1].T, color=ACCENT, linewidth=0.6, alpha=0.6)
    _at_moments(points, moments, lambda k, look: axes.plot(*points[k].T, **look))
    half = max(float(np.ptp(points[..., axis])) for axis in range(3)) / 2 or 1.0
    for axis, name in enumerate("xyz"):
        middle = (points[..., axis].max() + points[..., axis].min()) / 2
        getattr(axes, f"set_{name}lim")(middle - half, middle + half)
    axes.set_box_aspect((1, 1, 1))
    axes.locator_params(nbins=4)
    axes.tick_params(labelsize=6, pad=-2)


def _at_moments(points: NDArray[np.float64], count: int, draw: Callable[[int, dict[str, Any]], Any]) -> None:
    """Draw the chain at some moments, the last of them in full."""
    chosen = _moments(points, count)
    dotted = points.shape[1] <= _DOTTED
    for rank, k in enumerate(chosen):
        last = rank == len(chosen) - 1
        strength = 0.12 + 0.35 * rank / max(len(chosen) - 1, 1)
        draw(k, {
            "linestyle": "-", "marker": "o" if dotted else "", "color": INK, "alpha": 1.0 if last else strength, "linewidth": 1.6 if last else 0.9,
            "markersize": 4.0 if last else 2.0, "zorder": 3 if last else 2,
        })  # fmt: skip


def _moments(points: NDArray[np.float64], count: int) -> NDArray[np.int_]:
    """Indices of moments between which the joints travel equally far, the first and the last included."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=-1).sum(axis=-1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    found = np.searchsorted(travelled, np.linspace(0.0, travelled[-1], count))
    return np.unique(np.append(found, len(points) - 1))


def _frame(axes: Any) -> None:
    """Equal scales on both axes, in a frame that is neither too slender nor too flat to carry numbers."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    missing, lacking = max(0.0, 0.8 * (top - bottom) - (right - left)), max(0.0, 0.3 * (right - left) - (top - bottom))
    axes.set_xlim(left - missing / 2, right + missing / 2)
    axes.set_ylim(bottom - lacking / 2, top + lacking / 2)
    axes.set_aspect("equal", adjustable="box", anchor="C")
    axes.locator_params(axis="x", nbins=5)


def _rail(axes: Any, cart: NDArray[np.float64], height: float) -> None:
    axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=0)
    axes.plot(cart[-1], 0.0, marker="s", markersize=9, color=INK, zorder=4)
    axes.plot([cart.min(), cart.max()], [0.0, 0.0], color=SOFT, linewidth=3.0, alpha=0.5, zorder=0)
    axes.set_ylim(top=max(axes.get_ylim()[1], 0.12 * height))


def against_time(axes: Any, t: ArrayLike, values: ArrayLike, names: Sequence[str], label: str) -> None:
    """Curves over time, one colour each from base to tip; a legend above them where it can still be read."""
    columns = np.atleast_2d(np.asarray(values, dtype=float).T)
    for curve, colour, name in zip(columns, shades(len(columns)), names, strict=True):
        axes.plot(t, curve, color=colour, label=name)
    axes.set(ylabel=label, xlim=(np.min(t), np.max(t)))
    if 1 < len(columns) <= _NAMED:
        _legend_above(axes, len(columns) if len(columns) <= 5 else 4)
    elif len(columns) > _NAMED:
        _bar_beside(axes, names)


def _bar_beside(axes: Any, names: Sequence[str]) -> None:
    """Which colour is which of many curves: the first and the last named on a bar beside them."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    colours = ScalarMappable(Normalize(0, len(names)), ListedColormap(shades(len(names))))
    bar = axes.figure.colorbar(colours, ax=axes, pad=0.02, fraction=0.05)
    bar.set_ticks([0.5, len(names) - 0.5], labels=[names[0], names[-1]])
    bar.ax.tick_params(length=0)


def beyond(axes: Any, holds_until: float, end: float) -> None:
    """Grey from the time until which a run holds to its end; nothing where it holds to the end, or nobody knows."""
    if abs(end - holds_until) > 0:
        axes.axvspan(holds_until, end, color=SOFT, alpha=0.2, linewidth=0)
        share = abs(end - holds_until) / abs(axes.get_xlim()[1] - axes.get_xlim()[0])
        if share > _SLIVER:
            axes.annotate(
                "errors may be large", (end, 1.0), xycoords=("data", "axes fraction"), xytext=(-3, -3), textcoords="offset points", ha="right", va="top",
                fontsize=7, color=INK, zorder=5, rotation=0 if share > _WIDE else 90,
                bbox={"boxstyle": "square,pad=0.1", "color": "#ffffff", "alpha": 0.7, "linewidth": 0},
            )  # fmt: skip


def energy_error(axes: Any, t: ArrayLike, energy: ArrayLike, balance: ArrayLike | None = None) -> None:
    """How far the energy has moved from what it should be, relative to the largest; logarithmic.

    Args:
        axes: Where to draw.
        t: Times (m,), s.
        energy: Total energy (m,), J.
        balance: E - E(0) - work + loss (m,), J, where work is done or lost.
    """
    total = np.asarray(energy, dtype=float)
    scale = max(float(np.max(np.abs(total))), np.finfo(float).tiny)
    off = total - total[0] if balance is None else np.asarray(balance, dtype=float)
    moved = np.maximum(np.abs(off) / scale, _SMALLEST)
    axes.semilogy(np.asarray(t)[1:], moved[1:], color=ACCENT, linewidth=0.9)
    label = "energy error, relative" if balance is None else "energy balance, relative"
    axes.set(xlabel="t (s)", ylabel=label, xlim=(np.min(t), np.max(t)))


def decay(axes: Any, t: ArrayLike, curves: dict[str, ArrayLike]) -> None:
    """Norms that should vanish, over time on a logarithmic scale."""
    for (name, values), colour in zip(curves.items(), (ACCENT, INK, SOFT), strict=False):
        norms = np.asarray(values, dtype=float)
        # A chain released at rest starts with a rate of exactly zero, which has no place on this scale.
        axes.semilogy(t, np.where(norms > 0, norms, np.nan), color=colour, label=name)
    axes.set(xlabel="t (s)", ylabel="off the target", xlim=(np.min(t), np.max(t)))
    _legend_above(axes, len(curves))


def column_of_fit(above: Any, below: Any, t: ArrayLike, measured: ArrayLike, fitted: ArrayLike, name: str) -> None:
    """One measured column with its prediction, and below what is left of it."""
    above.plot(t, measured, ".", color=SOFT, markersize=2.5, label="measured", rasterized=True)
    above.plot(t, fitted, color=ACCENT, linewidth=1.0, label="fitted")
    above.set(ylabel=name, xlim=(np.min(t), np.max(t)))
    above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=2, markerscale=2.0)
    below.plot(t, np.asarray(measured) - np.asarray(fitted), ".", color=INK, markersize=1.5, rasterized=True)
    below.axhline(0.0, color=SOFT, linewidth=0.8)
    below.set(ylabel="left over")


def relative_errors(axes: Any, names: Sequence[str], share: ArrayLike) -> None:
    """Standard errors of parameters, relative to their values, on a logarithmic scale."""
    places = np.arange(len(names))
    axes.plot(np.maximum(share, _SMALLEST), places, "o", color=ACCENT, markersize=5)
    axes.set(xscale="log", yticks=places, yticklabels=names, xlabel="standard error / value", ylim=(len(names) - 0.5, -0.5))
    axes.set_title("how well each is told")


def correlations(axes: Any, names: Sequence[str], correlation: ArrayLike) -> None:
    """Correlations of estimates as a chart of colours, -1 to 1."""
    places = np.arange(len(names))
    shown = axes.imshow(correlation, cmap="PuOr", vmin=-1.0, vmax=1.0)
    axes.set_xticks(places, names, rotation=90, fontsize=7)
    axes.set_yticks(places, names, fontsize=7)
    axes.grid(False)
    axes.set_title("correlation")
    axes.figure.colorbar(shown, ax=axes, shrink=0.8)


def _legend_above(axes: Any, columns: int) -> None:
    place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
    handles, labels = axes.get_legend_handles_labels()
    # A legend fills column by column, and is read row by row.
    order = [k for column in range(columns) for k in range(column, len(handles), columns)]
    axes.legend([handles[k] for k in order], [labels[k] for k in order], ncols=columns, handlelength=1.0, columnspacing=1.0, **place)
