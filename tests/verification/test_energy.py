"""Energy over long runs (E7). The reference's 1e5 steps are shortened to 1e4."""

from __future__ import annotations

import numpy as np
import pytest
from support import LOCAL, PD_BOND, Array, Tree, box, energy, scene

import perimpm

STEPS = 10_000
SPACING = 0.1  # m
DENSITY = 1000.0


def energies(sim: perimpm.Simulation, steps: int, every: int) -> Array:
    values = [energy(sim)]
    for _ in range(steps // every):
        sim.step(every)
        values.append(energy(sim))
    return np.array(values)


def trend(values: Array, every: int) -> float:
    """Slope of the straight line through the energies, relative, per step."""
    slope = np.polynomial.Polynomial.fit(np.arange(len(values)) * every, values, 1).convert().coef[1]
    return float(slope / values[0])


@pytest.mark.parametrize("omega_dt", [0.1225, 0.61])
def test_two_points_oscillate_as_verlet_does(omega_dt: float) -> None:
    """One bond of stiffness k = 18 K h (own family: c = 18 K / (h V)), so omega^2 = 2 k / m. Velocity Verlet keeps
    m v^2 / 2 + (1 - (omega dt)^2 / 4) k x^2 / 2 exactly: the energy swings by (omega dt)^2 / 4 of itself, forever."""
    bulk = PD_BOND["youngs_modulus"] / 1.5
    omega = np.sqrt(2 * 18 * bulk * SPACING / (DENSITY * SPACING**3))
    two = box([0, 0, 0], [2 * SPACING, SPACING, SPACING])
    tree = scene(PD_BOND, two, SPACING, transfer={"type": "particle"}, density=DENSITY, dt=omega_dt / omega)
    tree["simulation"]["allow_unstable_dt"] = True  # the bound of the family is stricter than the true limit omega dt = 2
    sim = perimpm.Simulation(tree, threads=1)
    sim.particles["v"][:, 0] = np.array([-1e-3, 1e-3]) * np.sign(sim.particles["x"][1, 0] - sim.particles["x"][0, 0])
    values = energies(sim, STEPS, 1)
    swing = (values.max() - values.min()) / values.max()
    # starting from the reference length all energy is kinetic, the largest value; the smallest has it all in the bond
    assert swing == pytest.approx(omega_dt**2 / 4, rel=0.01)
    assert abs(trend(values, 1)) < 1e-8 * omega_dt**2  # what sampling a swing of this height leaves in a fit
    halves = np.array_split(values[1:], 2)
    assert halves[0].max() == pytest.approx(halves[1].max(), rel=1e-6)
    assert halves[0].min() == pytest.approx(halves[1].min(), rel=1e-3 * omega_dt**2)


def test_bond_block_has_no_drift() -> None:
    """216 particles, random velocities, strains of a few per mille: bounded by the stiffest mode's swing, no trend."""
    tree = scene(PD_BOND, box([0] * 3, [0.6] * 3), SPACING, transfer={"type": "particle"}, density=DENSITY)
    sim = perimpm.Simulation(tree, threads=1)
    sim.particles["v"][:] = 0.05 * np.random.default_rng(3).standard_normal((216, 3))
    values = energies(sim, STEPS, 10)
    print(f"\nswing {np.ptp(values) / values[0]:.1e}, trend per step {trend(values, 10):.1e}")
    quarters = [part.mean() for part in np.array_split(values[len(values) // 5 :], 4)]
    assert np.ptp(values) / values[0] < 0.25
    assert max(quarters) / min(quarters) - 1 < 1e-3


def standing_wave(transfer: Tree, cells: int = 32, amplitude: float = 0.01) -> tuple[perimpm.Simulation, int]:
    """The slab of A3 in uniaxial strain: slip faces on all six sides, u = A sin(pi X) sin(pi c t), Courant number 0.5.
    Also the number of steps in a period."""
    dx = 1 / cells
    speed = np.sqrt(1.2 * LOCAL["youngs_modulus"] / DENSITY)  # c_p at nu = 1/4
    dt = 0.5 * dx / speed
    side = 2 * dx  # nodes at 0, dx and 2 dx: the middle ones are free
    tree = scene(LOCAL, box([0] * 3, [1, side, side]), dx / 2, transfer=transfer, density=DENSITY, dt=dt)
    tree["grid"]["domain"] = {"min": [0.0] * 3, "max": [1.0, side, side], "faces": "slip"}
    sim = perimpm.Simulation(tree, threads=1)
    x = sim.particles["x"][:, 0]
    sim.particles["v"][:, 0] = amplitude * np.pi * speed * np.sin(np.pi * x)
    if "C" in sim.particles:
        sim.particles["C"][:, 0, 0] = amplitude * np.pi**2 * speed * np.cos(np.pi * x)
    return sim, round(2 / speed / dt)


@pytest.mark.parametrize("transfer", [{"type": "apic"}, {"type": "flip", "blend": 1.0}, {"type": "flip"}, {"type": "pic"}])
def test_the_grid_never_makes_energy(transfer: Tree) -> None:
    """Ten periods of A3's wave. "Never grows": no value above the start by more than the swing of the symplectic step,
    (omega dt)^2 / 4 of a mode with 2 pi / (omega dt) = 128 steps, and falling from period to period."""
    sim, period = standing_wave(transfer)
    values = energies(sim, 10 * period, 1)
    swing = np.pi / 128  # a first-order (kick, drift) step swings by omega dt / 2
    means = [part.mean() / values[0] for part in np.array_split(values[1:], 10)]
    print(f"\n{transfer}: period means {means[0]:.4f} .. {means[-1]:.4f}, largest {values.max() / values[0]:.5f}")
    assert values.max() <= values[0] * (1 + swing)
    assert all(later <= earlier * (1 + 1e-6) for earlier, later in zip(means, means[1:]))


@pytest.mark.slow
def test_hundred_periods() -> None:
    """Reference bands: 0.943 of the energy left with APIC, 0.920 with FLIP."""
    left = {}
    for name, transfer in {"apic": {"type": "apic"}, "flip": {"type": "flip", "blend": 1.0}}.items():
        sim, period = standing_wave(transfer)
        start = energy(sim)
        sim.step(100 * period)
        left[name] = energy(sim) / start
    print("\n", left)
    assert left["apic"] == pytest.approx(0.943, abs=0.03)
    assert left["flip"] == pytest.approx(0.920, abs=0.03)
