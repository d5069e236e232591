"""The integrators behind `simulate`, one file each."""
