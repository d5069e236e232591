"""Commands of `phichain`, one a file; each adds itself to the command line by `register`."""
