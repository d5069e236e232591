"""How models print."""

from __future__ import annotations

from phichain.mechanics import derive, with_symbols
from phichain.scene import Scene, standard_scene


def test_text_says_what_the_chain_is_and_writes_short_ones_out() -> None:
    text = str(derive(standard_scene(2)))
    assert text.splitlines()[0] == (
        "planar chain of 2 links on a fixed base, relative angles, phi_k = theta_1 + ... + theta_k"
    )
    assert "mu = [3/8, 1/8]" in text
    assert "c  = [5/32, 1/16]\n     [1/16, 1/32]" in text
    assert "V = -3.67875*cos(theta_1) - 1.22625*cos(theta_1 + theta_2)" in text
    assert text.endswith("= T_2")
    assert "M00" not in text


def test_text_of_long_chains_is_short() -> None:
    text = str(
        derive(Scene("a", 40, mass=0.1, length=0.1, base="cart", cart_mass=0.5, stiffness=0.2, damping=0.1))
    )
    assert len(text.splitlines()) == 16
    assert "F = M00 x'' + sum_k mu_k [cos(phi_k) phi_k'' - sin(phi_k) phi_k'^2]" in text
    assert "mu = [0.4, 0.39, 0.38, 0.37, 0.36, 0.35, ...]" in text
    assert "J_k = k_k (phi_k - phi_{k-1}) + d_k (phi_k' - phi_{k-1}')" in text
    assert text.endswith("M00 = 4.5")


def test_latex_is_one_aligned_block() -> None:
    block = derive(with_symbols(standard_scene(1))).latex()
    assert block.startswith("\\begin{aligned}T &= \\frac{m_{1} r_{1}^{2} \\dot{\\theta}_{1}^{2}}{2}")
    assert block.endswith("\\end{aligned}")
    general = derive(Scene("a", 2, "spatial", mass=1.0, length=1.0))._repr_latex_()
    assert general.startswith("$\\displaystyle \\begin{aligned}") and "\\dot\\omega_i" in general


def test_spatial_chains_print_both_forms_of_paper_b() -> None:
    """(16) in angular velocities and (15) in unit vectors, and the cart's row."""
    chain = Scene("b", 5, "spatial", mass=0.1, length=0.1, base="cart", cart_mass=0.5, stiffness=0.2)
    text = str(derive(chain))
    assert (
        "0 = c_ii (q_i'' + |q_i'|^2 q_i) + (I - q_i q_i^T) (sum_{j != i} c_ij q_j'' - g mu_i e_3 + mu_i C x'')"
        " + (J_i - J_{i+1}) x q_i\nu = M00 x'' + sum_k mu_k C^T q_k''\n"
    ) in text
    assert "c_ii omega_i'" in text
