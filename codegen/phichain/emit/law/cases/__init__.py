"""Calls of the self-tests of laws: what is measured, and what follows in 60 digits, one kind of law a file."""
