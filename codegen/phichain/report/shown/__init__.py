"""How records show themselves: looked up here by `phichain.records.Shown`, one function for each kind of record in the modules beside."""

from __future__ import annotations

from html import escape
from typing import Any

from phichain.report.shown import families, motions, regulators
from phichain.report.shown.datasets import to_xarray
from phichain.report.shown.kinds import animate, plot
from phichain.report.style import look, png

__all__ = ["animate", "families", "html", "motions", "plot", "regulators", "to_xarray"]


def html(record: Any) -> str:
    """What a notebook shows: what the record prints, and its picture where it can be drawn."""
    text = f"<pre>{escape(str(record))}</pre>"
    try:
        with look():
            picture = plot(record)
    except Exception:  # noqa: BLE001 - a notebook shows the words of what cannot be drawn, without matplotlib or without lengths
        return text
    from base64 import b64encode

    return f'{text}<img alt="{escape(repr(record))}" src="data:image/png;base64,{b64encode(png(picture)).decode()}">'
