"""One step in time as a Program: explicit, structure-preserving, implicit."""
