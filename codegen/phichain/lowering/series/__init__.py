"""Taylor recurrences of a chain: order by order with one factorisation a step (docs/theory.md, Taylor flow)."""
