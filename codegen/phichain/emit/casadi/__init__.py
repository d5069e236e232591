"""Programs -> CasADi: a Python module of functions, and C under the calling convention of `external`."""
