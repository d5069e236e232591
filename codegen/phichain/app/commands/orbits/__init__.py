"""Commands that follow oscillations: families, single orbits, responses, connections."""
