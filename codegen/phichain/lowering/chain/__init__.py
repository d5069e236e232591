"""What every sweep knows of a chain: its numbers and units, its links as bodies, what carries it, and what resists it."""
