"""The front door: the command `phichain`, what it prints, and the tour of `make run`."""
