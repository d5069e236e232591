"""Orbits as Fourier series: harmonic balance with as many harmonics as the tail of the spectrum asks for, by alternating frequency-time."""
