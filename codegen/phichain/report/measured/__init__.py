"""Pictures of what was measured: verdicts, and error against run time."""
