"""Signals from forces to angles: sheets, and a page to turn them by hand."""
