"""The interactive form of signal propagation: one HTML file that opens anywhere, without server, network or packages.

The surfaces travel inside the page, as 16-bit numbers in units of every order's own size; some two hundred lines of
plain JavaScript draw them on canvases. A plotting library would weigh five megabytes in every file and add a
dependency, and would not know the one thing worth turning here: where along the signal one looks.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from phichain.report.origins import in_page, told
from phichain.report.signals.propagation import PATH_NAMES, Wave, plain_names

if TYPE_CHECKING:
    from phichain.fractional import Propagation

NOTHING = -32768
"""What stands for a sample that does not exist; `viewer.js` knows it too."""

FULL = 32767 / 2
"""The whole number that one size is stored as; twice a size is the most that can be."""


def viewer(title: str, lead: str, motions: Mapping[str, Propagation]) -> str:
    """The page as HTML text.

    Args:
        title: Its heading.
        lead: What is shown, in a sentence or two.
        motions: The surfaces by the name of their chain; more than one can be switched between.
    """
    data = {
        "motions": [_motion(name, result) for name, result in motions.items()],
        "paths": {path: words.replace("$", "") for path, words in PATH_NAMES.items()},
        "initial": all(result.initial for result in motions.values()),
    }
    # A "<" would end the script early, and JSON may say it otherwise.
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    parts = {"title": escape(title), "lead": escape(lead), "data": text, "script": _asset("viewer.js"), "origin": in_page(told(motions.values()))}
    return re.sub(r"@(title|lead|origin|data|script)@", lambda found: parts[found[1]], _asset("viewer.html"))


def _asset(name: str) -> str:
    return files("phichain.report.signals").joinpath(name).read_text(encoding="utf-8")


def _motion(name: str, result: Propagation) -> dict[str, Any]:
    coordinates = range(len(result.coordinates))
    waves = {
        path: [_packed(Wave.of(result, coordinate, path)) for coordinate in coordinates]
        for path in result.forces
    }
    thinned = Wave.of(result, 0, next(iter(result.forces)))
    orders = [*thinned.p.tolist(), *(1.0 - thinned.alpha[::-1][1:]).tolist()]
    return {
        "name": name,
        "times": thinned.time.size,
        "end": float(result.time[-1] - result.time[0]),
        "orders": [round(order, 12) for order in orders],
        "coordinates": plain_names(result),
        "waves": waves,
    }


def _packed(wave: Wave) -> dict[str, Any]:
    """The samples of a wave order by order, theta_p first and psi from alpha = 0 down without its first order."""
    values = np.concatenate([wave.theta_p.T, wave.psi.T[::-1][1:]])
    sizes = np.concatenate([wave.sizes[0], wave.sizes[1][::-1][1:]])
    return {"sizes": [float(f"{size:.6g}") for size in sizes], "values": pack(values / sizes[:, None])}


def pack(values: NDArray[np.float64]) -> str:
    """Values between -2 and 2 (larger ones are cut) as base64 of little-endian 16-bit numbers; NaN as `NOTHING`."""
    whole = np.round(np.clip(np.nan_to_num(values), -2.0, 2.0) * FULL)
    whole = np.where(np.isnan(values), NOTHING, whole)
    return base64.b64encode(whole.astype("<i2").tobytes()).decode("ascii")
