"""Figures, pages and tables from results; the only place that draws."""
