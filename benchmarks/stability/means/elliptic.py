"""One link in closed form: Jacobi's elliptic functions of the exact double inputs.

With k^2 = sin^2(theta_0/2) + (theta_0'/(2 omega_0))^2 and u = omega_0 t + u_0: sin(theta/2) = k sn(u, k) below the
separatrix (k < 1); theta/2 = am(k omega_0 t, 1/k) above it. Only starts at rest or at the bottom are needed.
"""

from __future__ import annotations

import mpmath as mp

DIGITS = 110


def state(theta: mp.mpf, rate: mp.mpf, omega0: mp.mpf, t: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """(theta, theta') at time t, from (theta, rate) at 0, at the working precision.

    Raises:
        ValueError: neither the rate nor the angle is zero.
    """
    if rate != 0 and theta != 0:
        raise ValueError("the closed form is written for starts at rest or at the bottom")
    if rate == 0:
        k = mp.sin(theta / 2)
        m = k * k
        u = omega0 * t + mp.ellipk(m)
        return 2 * mp.asin(k * mp.ellipfun("sn", u, m)), 2 * k * omega0 * mp.ellipfun("cn", u, m)
    k = rate / (2 * omega0)
    m = k * k
    if m < 1:
        u = omega0 * t
        return 2 * mp.asin(k * mp.ellipfun("sn", u, m)), 2 * k * omega0 * mp.ellipfun("cn", u, m)
    u, m = k * omega0 * t, 1 / m
    turns = mp.nint(u / (4 * mp.ellipk(m)))
    amplitude = mp.atan2(mp.ellipfun("sn", u, m), mp.ellipfun("cn", u, m)) + 2 * mp.pi * turns
    return 2 * amplitude, 2 * k * omega0 * mp.ellipfun("dn", u, m)


def frequency(amplitude: mp.mpf, omega0: mp.mpf) -> mp.mpf:
    """omega = pi omega_0 / (2 K(sin(A/2))), rad/s."""
    return mp.pi * omega0 / (2 * mp.ellipk(mp.sin(amplitude / 2) ** 2))
