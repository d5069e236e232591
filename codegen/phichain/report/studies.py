"""One output of a study as a picture: a map over two axes, lines over one, points over what was drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from phichain.contract.words import nearest
from phichain.errors import StudyError
from phichain.report.style import ACCENT, SOFT, figure, look, shades

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_LINES = 12
"""Lines that can be told apart."""


def study_picture(dataset: xr.Dataset, of: str | None = None) -> Figure:
    """One output over the axes of a study.

    Args:
        dataset: What a study left.
        of: Name of an output, with the entry of a vector in brackets, such as q[2]; the first that is a number unless given.

    Raises:
        StudyError: No output has that name, or it has more dimensions than a picture shows.
    """
    values = _chosen(dataset, of)
    axes_of_study = [str(dim) for dim in values.dims if dim == "sample" or (dim in values.coords and values[dim].dtype.kind in "fiu")]
    if not axes_of_study or values.ndim > 2 or len(axes_of_study) < values.ndim:
        raise StudyError("of", of, f"has the dimensions {', '.join(map(str, values.dims)) or 'of one point'}", "name one entry, as q[2], of a study over one or two numbers")
    with look():
        drawing = figure(6.4, 4.8)
        axes = drawing.add_subplot()
        if "sample" in values.dims:
            _points(axes, values, dataset)
        elif values.ndim == 2:
            _map(drawing, axes, values)
        else:
            axes.plot(values[axes_of_study[0]], values, marker=".", color=shades(2)[0])
            axes.set(xlabel=axes_of_study[0], ylabel=_label(values))
        axes.set_title(f"{dict(_said(dataset)).get('study', 'study')}: {values.attrs.get('long_name', values.name)}")
    return drawing


def _chosen(dataset: xr.Dataset, of: str | None) -> Any:
    """The output of that name, one entry of it where its name says which."""
    numbers = [str(name) for name, value in dataset.data_vars.items() if value.dtype.kind in "fu" and name != "status"]
    name, _, entry = (of or numbers[0]).partition("[")
    if name not in numbers:
        near = nearest(name, numbers)
        guess = f'did you mean "{near}"? There are' if near else "there are"
        raise StudyError("of", of, "is no output of this study", f"{guess} {', '.join(numbers)}")
    values = dataset[name].astype(float)
    values = values.where(values != 255) if dataset[name].dtype.kind == "u" else values
    values.attrs |= dataset[name].attrs
    inner = [dim for dim in values.dims if dim not in _outer(dataset)]
    if not inner:
        return values
    places = [int(word) - 1 for word in entry.rstrip("]").split(",") if word.strip().isdecimal()] or [0] * len(inner)
    if len(places) != len(inner) or any(not 0 <= k < values.sizes[dim] for k, dim in zip(places, inner, strict=False)):
        raise StudyError("of", of, f"has the entries {' x '.join(str(values.sizes[dim]) for dim in inner)}", f"write {name}[{','.join('1' * len(inner))}]")
    chosen = values.isel(dict(zip(inner, places, strict=True)), drop=True)
    chosen.attrs |= dataset[name].attrs
    return chosen.rename(f"{name}[{','.join(str(k + 1) for k in places)}]")


def _outer(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dimensions of the study itself: those of its status."""
    return tuple(str(dim) for dim in dataset["status"].dims)


def _map(drawing: Figure, axes: Any, values: Any) -> None:
    y, x = (str(dim) for dim in values.dims)
    finite = np.asarray(values)[np.isfinite(np.asarray(values))]
    # A few runaways must not take all the colours; the bar's pointed ends say that there are some.
    low, high = np.quantile(finite, [0.02, 0.98]) if len(finite) else (0.0, 1.0)
    shown = axes.pcolormesh(
        values[x], values[y], np.asarray(values), shading="nearest", cmap="viridis", rasterized=True, vmin=low, vmax=high
    )
    axes.grid(False)
    axes.set(xlabel=x, ylabel=y)
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    beyond = (bool(np.any(finite < low)), bool(np.any(finite > high)))
    drawing.colorbar(shown, ax=axes, label=_label(values), extend=ends[beyond])
    missing = np.argwhere(~np.isfinite(np.asarray(values)))
    if len(missing):
        axes.plot(values[x].values[missing[:, 1]], values[y].values[missing[:, 0]], "x", color=ACCENT, markersize=3, label="no result")
        axes.legend(loc="upper right")


def _points(axes: Any, values: Any, dataset: xr.Dataset) -> None:
    drawn = [str(name) for name, coordinate in dataset.coords.items() if coordinate.dims == ("sample",) and coordinate.dtype.kind in "fiu"]
    others = [str(dim) for dim in values.dims if dim != "sample"]
    x = np.asarray(dataset[drawn[0]]) if drawn else np.arange(values.sizes["sample"])
    columns = np.asarray(values.transpose("sample", *others)).reshape(len(x), -1)
    for k, colour in zip(range(min(columns.shape[1], MOST_LINES)), shades(min(columns.shape[1], MOST_LINES)), strict=True):
        label = f"{others[0]} = {np.asarray(values[others[0]])[k]:.4g}" if others else None
        axes.plot(x, columns[:, k], ".", color=colour, markersize=3, label=label)
    if others:
        axes.legend(title=None if columns.shape[1] <= MOST_LINES else f"the first {MOST_LINES} of {columns.shape[1]}")
    axes.axhline(0.0, color=SOFT, linewidth=0.6)
    axes.set(xlabel=drawn[0] if drawn else "sample", ylabel=_label(values))


def _label(values: Any) -> str:
    units = values.attrs.get("units", "")
    return f"{values.name} ({units})" if units else str(values.name)


def _said(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """What the line of provenance says, by its first words."""
    parts = (part.strip().partition(" ") for part in str(dataset.attrs.get("phichain", "")).split(";"))
    return [(name, value) for name, _, value in parts]
