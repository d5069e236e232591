"""A picture of verdicts: cases down, methods across, one colour each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from phichain.report.style import figure, look, save

COLOURS = ("#2f7d4f", "#d9b44a", "#b42318", "#e07b39", "#6b7fa3", "#c9d0d9")


def draw_verdicts(
    path: Path | str,
    cases: Sequence[str],
    methods: Sequence[str],
    cells: Mapping[tuple[str, str], str],
    verdicts: Sequence[str],
) -> Path:
    """Draw the table of verdicts as a PNG.

    Args:
        path: The file.
        cases: Labels of the rows.
        methods: Labels of the columns.
        cells: Verdict by (case, method); a missing one stays empty.
        verdicts: All verdicts, best first, at most as many as there are colours.
    """
    with look():
        drawing = figure(1.6 + 0.062 * max(map(len, cases)) + 0.34 * len(methods), 1.9 + 0.175 * len(cases))
        axes = drawing.add_subplot()
        axes.grid(False)
        for row, case in enumerate(cases):
            for column, method in enumerate(methods):
                verdict = cells.get((case, method))
                if verdict is not None:
                    colour = COLOURS[verdicts.index(verdict)]
                    axes.fill(
                        [column, column + 0.94, column + 0.94, column],
                        [row, row, row + 0.9, row + 0.9],
                        color=colour,
                    )
        axes.set_xlim(0, len(methods))
        axes.set_ylim(len(cases), 0)
        axes.set_xticks([k + 0.47 for k in range(len(methods))], methods, rotation=60, ha="left", fontsize=7)
        axes.set_yticks([k + 0.45 for k in range(len(cases))], cases, fontsize=7)
        axes.xaxis.tick_top()
        axes.tick_params(length=0)
        for side in axes.spines.values():
            side.set_visible(False)
        for verdict, colour in zip(verdicts, COLOURS, strict=False):
            axes.fill([], [], color=colour, label=verdict.lower())
        drawing.legend(loc="outside lower center", ncols=3)
        return save(drawing, path)
