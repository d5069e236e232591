"""The figures of docs/theory.md, drawn: `python -m docs.figures` writes them to docs/img/theory, the same bytes each time."""
