"""Figures that a notebook shows as they are; Matplotlib's own are shown only where pyplot was imported."""

from __future__ import annotations

from matplotlib.figure import Figure


class Drawing(Figure):
    """A figure of this project, without a window."""

    def _repr_png_(self) -> bytes:
        from phichain.report.style import png

        return png(self)
