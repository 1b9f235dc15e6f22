"""Rigid rotation (A7). Shortened against the reference: cubes of 6 or 5 cells an edge instead of 20, 10 turns instead
of 10^4 in the fast variant, which a slow test has; the square's turn at 20 cells and the 20 s of the public gate are
kept."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from support import rotation
from trees import PD_BOND, PD_ELASTIC, Tree, box, scene

import perimpm

YOUNG, POISSON, DENSITY = 1e6, 0.3, 1550.0
EDGE = 1.0  # m


def spinning(
    transfer: Tree,
    cells: int,
    omega: float = 1.0,
    young: float = YOUNG,
    span: tuple[float, float] = (-EDGE / 2, EDGE / 2),
    domain: Tree | None = None,
) -> tuple[perimpm.Simulation, float]:
    """A square that spins about z through its centre, a cube unless `span` gives its z, and its time step
    0.5 dx / (c_p + |v|)."""
    dx = EDGE / cells
    modulus = young * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
    dt = 0.5 * dx / (np.sqrt(modulus / DENSITY) + omega)
    law = {"type": "fixed_corotated", "youngs_modulus": young, "poisson_ratio": POISSON}
    half = EDGE / 2
    shape = box([-half, -half, span[0]], [half, half, span[1]])
    tree = scene(law, shape, dx / 2, transfer=transfer, density=DENSITY, dt=dt)
    tree["body"][0]["initial_angular_velocity"] = [0.0, 0.0, omega]
    if domain:
        tree["grid"]["domain"] = domain
    return perimpm.Simulation(tree, threads=1), dt


def kinetic_losses(sim: perimpm.Simulation, steps: int, records: int = 50) -> Iterator[float]:
    start = sim.ledger.kinetic
    for _ in range(records):
        sim.step(steps // records)
        yield 1 - sim.ledger.kinetic / start


@pytest.mark.parametrize("order", [2, 3])
def test_apic_keeps_one_turn(order: int) -> None:
    """Reference at 20 cells: kinetic energy 0.99991 (quadratic), 0.99990 (cubic), L to 7e-13."""
    sim, dt = spinning({"type": "apic", "order": order}, cells=6)
    before = sim.ledger.angular_momentum[2]
    losses = list(kinetic_losses(sim, round(2 * np.pi / dt)))
    change = sim.ledger.angular_momentum[2] / before - 1
    print(f"\napic {order}: kinetic {1 - losses[-1]:.5f}, L {change:.0e}")
    assert 0 <= losses[-1] <= 1e-3
    assert abs(change) <= 1e-11


@pytest.mark.parametrize("divergence", ["gradient", "mls"])
def test_public_gate_of_twenty_seconds(divergence: str) -> None:
    sim, dt = spinning({"type": "apic", "order": 2, "stress_divergence": divergence}, cells=5)
    losses = list(kinetic_losses(sim, round(20 / dt)))
    print(f"\napic {divergence}: loss {min(losses):.1e} .. {max(losses):.1e}")
    assert min(losses) >= 0
    assert max(losses) <= 1e-3


def test_known_losses_of_the_others() -> None:
    """Over one turn. Reference at 20 cells: FLIP L -2.6 %, FLIP 0.95 -96 %, PIC -100 %. FLIP's loss falls with
    dx^1.8: -43 % at 5 cells, -12 % at 10."""
    kept = {}
    transfers: dict[str, Tree] = {
        "flip 1": {"type": "flip", "blend": 1.0},
        "flip 0.95": {"type": "flip", "blend": 0.95},
        "pic": {"type": "pic"},
    }
    for name, transfer in transfers.items():
        sim, dt = spinning(transfer, cells=5)
        before = sim.ledger
        sim.step(round(2 * np.pi / dt))
        after = sim.ledger
        kept[name] = after.angular_momentum[2] / before.angular_momentum[2], after.kinetic / before.kinetic
    print()
    for name, (spin, kinetic) in kept.items():
        print(f"{name:9}: L {spin:.4f}, kinetic {kinetic:.4f}")
    assert 0.5 < kept["flip 1"][0] < 0.7
    assert kept["flip 0.95"][0] < 0.05
    assert kept["pic"][0] < 0.01


@pytest.mark.parametrize(("order", "kinetic"), [(2, 0.99991), (3, 0.99990)])
def test_square_keeps_one_turn_at_twenty_cells(order: int, kinetic: float) -> None:
    """The reference's square in plane strain: 20 x 20 cells, two cells thick between slip faces. What the kinetic
    energy loses is the elastic energy of the stress-free start, which expands and breathes: it falls with 1 / E."""
    thickness = 2 * EDGE / 20
    faces = {f"{end}_{axis}": "slip" if axis == "z" else "open" for end in ("min", "max") for axis in "xyz"}
    domain = {"min": [-2.0, -2.0, 0.0], "max": [2.0, 2.0, thickness], "faces": faces}
    sim, dt = spinning({"type": "apic", "order": order}, cells=20, span=(0.0, thickness), domain=domain)
    before = sim.ledger
    steps = round(2 * np.pi / dt)
    sim.step(steps)
    after = sim.ledger
    kept, change = after.kinetic / before.kinetic, after.angular_momentum[2] / before.angular_momentum[2] - 1
    print(f"\napic {order}, square: {steps} steps, kinetic {kept:.6f}, L {change:.0e}")
    assert steps == 7658  # as the reference counts
    assert kept == pytest.approx(kinetic, abs=2e-5)
    assert abs(change) <= 1e-11


@pytest.mark.slow
@pytest.mark.parametrize(
    ("transfer", "kinetic", "spin", "within"),
    [({"type": "apic", "order": 2}, 0.99991, 0.0, 4e-12), ({"type": "flip", "blend": 1.0}, 0.953, -0.026, 0.01)],
    ids=["apic", "flip"],
)
def test_one_turn_at_twenty_cells(transfer: Tree, kinetic: float, spin: float, within: float) -> None:
    """The cube at the reference's resolution. FLIP agrees with its numbers (0.951, -2.7 %). APIC keeps 0.99969, less
    than the square's 0.99991, whose faces hold the third direction."""
    sim, dt = spinning(transfer, cells=20)
    before = sim.ledger
    sim.step(round(2 * np.pi / dt))
    after = sim.ledger
    kept, change = after.kinetic / before.kinetic, after.angular_momentum[2] / before.angular_momentum[2] - 1
    print(f"\n{transfer}: kinetic {kept:.5f}, L {change:.1e}")
    if transfer["type"] == "apic":
        assert 0 <= 1 - kept <= 1e-3  # the public gate; it never gains
    else:
        assert kept == pytest.approx(kinetic, abs=0.01)
    assert change == pytest.approx(spin, abs=within)


QUADRATIC: Tree = {"type": "apic", "order": 2}
SMOOTH: Tree = {"type": "apic", "order": 3, "stress_divergence": "mls"}


def fast_spin(
    turns_between: list[int], transfer: Tree = QUADRATIC, cells: int = 5, young: float = 1e9
) -> tuple[list[float], list[float]]:
    """After each of the given numbers of further turns at 100 rad/s: |det F - 1| at its worst particle, and how much
    farther out the farthest particle is than at the start. The centrifugal strain rho omega^2 a^2 / (3 E) is
    1.3e6 Pa / E."""
    omega = 100.0
    sim, dt = spinning(transfer, cells, omega=omega, young=young)
    turn = 2 * np.pi / omega / dt
    worst, spread = [], []

    def farthest() -> float:
        return float(np.max(np.hypot(*sim.particles["x"][:, :2].T)))

    start = farthest()
    for turns in turns_between:
        sim.step(round(turns * turn))
        worst.append(float(np.max(np.abs(np.linalg.det(sim.particles["F"]) - 1))))
        spread.append(farthest() / start - 1)
    print("\n|det F - 1|: " + ", ".join(f"{value:.2e}" for value in worst))
    print("farther out by " + ", ".join(f"{value:.2%}" for value in spread))
    assert max(worst) <= 3 * DENSITY * omega**2 * (EDGE / 2) ** 2 / (3 * young)
    return worst, spread


def test_fast_rotation_does_not_wear_the_deformation_gradient() -> None:
    """Ten turns leave det F where the first two put it."""
    worst, _ = fast_spin([2, 8])
    assert worst[1] <= 1.5 * worst[0]


@pytest.mark.slow
def test_ten_thousand_fast_turns_do_not_wear_the_deformation_gradient() -> None:
    """At a centrifugal strain of 1.3e-4. The corners have crept outward by 14 % in the end (at a strain of 1.3e-5, ten
    times as many particle-steps, by 0.6 % after 3000 turns), det F is where ten turns have put it."""
    worst, spread = fast_spin([10, 990, 9000], SMOOTH, cells=3, young=1e10)
    assert worst[2] <= 1.5 * worst[0]
    assert spread[1] <= 0.015
    assert spread[2] <= 0.2


@pytest.mark.slow
def test_hundreds_of_fast_turns_wear_positions() -> None:
    """Corners creep outward by 2.5 % in 100 turns, and strains grow with them (|det F - 1| 2.0e-3, 2.8e-3, 3.7e-3); after
    more turns the cube comes apart. Angular momentum is exact all the while and kinetic energy falls as the cube widens.
    The creep shrinks with the step (1.6 % at half, 0.95 % at a quarter of it), with `mls` (0.7 %), with a cubic kernel
    (0.5 %; both 0.36 %) and with the centrifugal strain (at a tenth of it 0.8 %, at a hundredth 0.16 % and |det F - 1| 5e-5); the rate of rotation alone
    does not matter: 10 rad/s at a hundredth of the stiffness gives the same numbers."""
    _, spread = fast_spin([2, 98, 200])
    assert spread[1] <= 0.04
    assert spread[2] <= 0.15


@pytest.mark.parametrize(
    "law",
    [
        PD_BOND,
        PD_ELASTIC,
        {**PD_ELASTIC, "bending_ratio": 0.0},
        {**PD_ELASTIC, "horizon": 3.015, "influence": "constant"},
        {**PD_ELASTIC, "surface": "none"},
        {**PD_ELASTIC, "formulation": "paper"},
        {**PD_ELASTIC, "formulation": "paper", "surface": "none"},
        {"type": "pd_lps", "youngs_modulus": 1e5, "poisson_ratio": 0.25},
    ],
    ids=lambda law: " ".join(str(value) for value in law.values()),
)
def test_rigid_rotation_makes_no_force(law: Tree) -> None:
    """max |f| / (K h^2) <= 1e-12 for any rotation, on surface particles too."""
    spacing = 0.1
    tree = scene(law, box([0] * 3, [0.6] * 3), spacing, transfer={"type": "particle"}, dt=1e-12)
    random = np.random.default_rng(4)
    bulk = law["youngs_modulus"] / 1.5  # nu = 1/4
    for angle in (0.3, 1.7, np.pi):
        sim = perimpm.Simulation(tree, threads=1)
        x = sim.particles["x"]
        x[:] = (x - 0.3) @ rotation(random.standard_normal(3), angle).T
        sim.step(1)
        force = sim.particles["force"]
        assert np.max(np.abs(force)) <= 1e-12 * bulk * spacing**2
