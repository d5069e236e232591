"""heyoka, the Taylor integrator, and its compiled functions."""
