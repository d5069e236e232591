"""The documentation site: `python -m docs.site` stages the pages, writes the references, runs every code block and builds."""
