"""The tasks of a study, one a file; each holds a `TASK`."""
