"""Benchmarks of phichain: every figure is measured beside its peers, in one run, on the machine at hand."""
