"""selftest.c: inputs, references that come another way through the mathematics, and their text."""
