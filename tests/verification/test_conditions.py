"""Regions with conditions: prescribed motion, loads, damping, equilibrium. Closed forms are derived where used."""

from __future__ import annotations

import signal
import threading
from typing import Any

import numpy as np
import pytest
from support import Array
from trees import LOCAL, PD_BOND, Tree, box, scene

import perimpm

GRID = [{"type": "apic", "order": 2}, {"type": "apic", "order": 3}, {"type": "flip", "order": 2}, {"type": "pic"}]
DIRECT: Tree = {"type": "particle"}
WITH_LAW = [(LOCAL, t) for t in GRID] + [(PD_BOND, GRID[0]), (PD_BOND, DIRECT)]
IDS = ["apic", "apic-cubic", "flip", "pic", "bonds-apic", "bonds-particle"]
DENSITY, M = 1000.0, 1.2 * LOCAL["youngs_modulus"]  # nu = 1/4: M = E (1 - nu) / ((1 + nu) (1 - 2 nu)) = 1.2 E


def block(law: Tree, transfer: Tree, **more: Any) -> Tree:
    """8 x 8 x 8 particles in 0 <= x < 0.4 m."""
    return scene(law, box([0] * 3, [0.4] * 3), 0.05, transfer=transfer, density=DENSITY, **more)


def whole(drive: str, value: Any, **more: Any) -> list[Tree]:
    return [{drive: value, **more}]


@pytest.mark.parametrize(("law", "transfer"), WITH_LAW, ids=IDS)
@pytest.mark.parametrize(
    ("drive", "value"), [("acceleration", 2.0), ("body_force", 2.0 * DENSITY), ("force", 2.0 * DENSITY * 0.4**3)]
)
def test_loads_on_all_particles_are_an_acceleration(law: Tree, transfer: Tree, drive: str, value: float) -> None:
    """a = 2 m/s^2 along y whichever way it is given; with factors that rise from 0 to 1 in 0.1 s, v = a t^2 / 0.2."""
    for factors, speed in (({}, 2.0 * 0.05), ({"times": [0.0, 0.1], "factors": [0.0, 1.0]}, 0.05**2 / 0.1)):
        tree = block(law, transfer, condition=whole(drive, [0.0, value, 0.0], **factors), dt=2.5e-4)
        sim = perimpm.Simulation(tree)
        sim.step(200)
        # the sum over steps of a(t_n) dt falls short of the integral by half a step
        assert sim.particles["v"][:, 1] == pytest.approx(speed, rel=2.5e-4 / 0.05 + 1e-9)
        assert np.abs(sim.particles["v"][:, [0, 2]]).max() < 1e-9


@pytest.mark.parametrize(("law", "transfer"), WITH_LAW, ids=IDS)
def test_prescribed_particles_move_as_told(law: Tree, transfer: Tree) -> None:
    """One half of a block is driven, free along z: its particles move by the integral of factor times velocity."""
    region = {"shape": box([-1, -1, -1], [0.2, 1, 1]), "times": [0.0, 0.02], "factors": [0.0, 1.0]}
    tree = block(law, transfer, condition=whole("velocity", [0.5, -0.25, "free"], **region), dt=2.5e-4)
    sim = perimpm.Simulation(tree)
    X = sim.particles.by_id("x")
    sim.step(160)  # 0.04 s: the factor's integral is 0.01 + 0.02
    inside = X[:, 0] < 0.2
    moved = sim.particles.by_id("x") - X
    assert np.abs(moved[inside, 0] - 0.5 * 0.03).max() < 1e-12
    assert np.abs(moved[inside, 1] + 0.25 * 0.03).max() < 1e-12
    assert np.abs(moved[~inside, 0] - 0.5 * 0.03).max() > 1e-4  # the rest follows by its own forces


@pytest.mark.parametrize(("law", "transfer"), WITH_LAW, ids=IDS)
def test_a_function_of_place_and_time_is_the_same_as_a_scene(law: Tree, transfer: Tree) -> None:
    spec = {"shape": box([-1, -1, -1], [0.2, 1, 1])}
    factor = {"times": [0.0, 1.0], "factors": [0.0, 1.0]}
    load = {"acceleration": [0.0, 0.0, 3.0], "shape": box([0.3, -1, -1], [1, 1, 1])}
    by_scene = perimpm.Simulation(block(law, transfer, condition=[*whole("velocity", [0.0, 0.5, "free"], **spec, **factor), load]))
    by_call = perimpm.Simulation(block(law, transfer))
    shapes = []

    def drive(X: Array, t: float) -> Array:
        shapes.append(X.shape)
        return np.array([0.0 * t, 0.5 * t, np.nan])

    by_call.prescribe(drive, **spec)
    by_call.load(acceleration=lambda X, t: np.tile([0.0, 0.0, 3.0], (len(X), 1)), shape=load["shape"])
    for sim in (by_scene, by_call):
        sim.step(50)
    assert np.abs(by_scene.particles.by_id("x") - by_call.particles.by_id("x")).max() < 1e-14
    assert set(shapes) == {(256, 3)}
    assert len(shapes) == (100 if transfer == DIRECT else 50)


def clamped_bar(cells: int, transfer: Tree, clamp: int) -> float:
    """Period of the first mode of a bar in uniaxial strain of length 1 m, clamped by `clamp` cells of particles behind
    X = 0, over 4 L / c."""
    dx, c = 1 / cells, float(np.sqrt(M / DENSITY))
    side = 2 * dx
    tree = scene(LOCAL, box([-clamp * dx, 0, 0], [1, side, side]), dx / 2, transfer=transfer, density=DENSITY, dt=0.1 * dx / c)
    faces = {f"{end}_{axis}": "open" if axis == "x" else "slip" for end in ("min", "max") for axis in "xyz"}
    tree["grid"]["domain"] = {"min": [-1.0, 0.0, 0.0], "max": [2.0, side, side], "faces": faces}
    tree["condition"] = [{"clamped": True, "shape": {"type": "plane", "point": [0.0, 0, 0], "normal": [1.0, 0, 0]}}]
    sim = perimpm.Simulation(tree, threads=1)
    X = sim.particles["x"][:, 0].copy()
    shape = np.where(X > 0, np.sin(np.pi / 2 * X), 0)
    sim.particles["v"][:, 0] = 1e-3 * c * shape
    if "C" in sim.particles:
        sim.particles["C"][:, 0, 0] = np.where(X > 0, 1e-3 * c * np.pi / 2 * np.cos(np.pi / 2 * X), 0)
    shape = np.sin(np.pi / 2 * sim.particles.by_id("x")[:, 0])
    free = sim.particles.by_id("x")[:, 0] > 0
    start = sim.particles.by_id("x")[:, 0]
    times, modes = [0.0], [0.0]
    while sim.time * c < 4.5:
        sim.step()
        times.append(sim.time)
        modes.append(float(shape[free] @ (sim.particles.by_id("x")[:, 0] - start)[free]))
    cross = [t0 - m0 * (t1 - t0) / (m1 - m0) for t0, t1, m0, m1 in zip(times, times[1:], modes, modes[1:]) if t0 > 0 and m0 * m1 <= 0]
    return cross[1] * c / 4


@pytest.mark.parametrize("transfer", GRID[:3], ids=IDS[:3])
def test_a_clamped_region_acts_near_its_border(transfer: Tree) -> None:
    coarse, fine = (clamped_bar(cells, transfer, 4) for cells in (8, 16))
    print(f"\nperiod / closed form {coarse:.4f} at 8 cells, {fine:.4f} at 16")
    # it acts as a wall 0.25 (quadratic) or 0.34 cells (cubic) behind: the static solution of the splines' chain
    assert fine == pytest.approx(1 + {2: 0.25, 3: 0.34}[transfer["order"]] / 16, abs=5e-3)
    assert fine - 1 < 0.6 * (coarse - 1)


@pytest.mark.parametrize(("law", "transfer"), WITH_LAW, ids=IDS)
def test_damping_slows_free_motion(law: Tree, transfer: Tree) -> None:
    """dv/dt = -damping v: v = v0 exp(-damping t), exactly in each step."""
    tree = block(law, transfer)
    tree["simulation"]["damping"] = 7.0
    tree["body"][0]["initial_velocity"] = [1.0, -2.0, 3.0]
    sim = perimpm.Simulation(tree)
    sim.step(100)
    expected = np.exp(-7.0 * sim.time) * np.array([1.0, -2.0, 3.0])
    assert np.abs(sim.particles["v"] - expected).max() < 1e-9


def column(law: Tree, transfer: Tree, load: float, cells: int = 16) -> Tree:
    """Laterally confined column of height 1 m on a fixed base, under gravity with rho g L / M = load (A11)."""
    dx = 1 / cells
    side = 2 * dx
    tree = scene(law, box([0] * 3, [side, 1, side]), dx / 2, transfer=transfer, density=DENSITY)
    tree["simulation"]["gravity"] = [0.0, -load * M / DENSITY, 0.0]
    faces = {f"{end}_{axis}": "symmetry" for end in ("min", "max") for axis in "xyz"} | {"max_y": "open"}
    tree["grid"]["domain"] = {"min": [0.0] * 3, "max": [side, 2.0, side], "faces": faces}
    return tree


@pytest.mark.parametrize("load", [1e-3, 0.3])
def test_column_under_its_own_weight(load: float) -> None:
    """Fixed-corotated: P = M (F - 1), so u = -(rho g / M)(L X - X^2 / 2) at any load below 1 (A11)."""
    errors = []
    for cells in (8, 16):
        sim = perimpm.Simulation(column(LOCAL, GRID[0], load, cells))
        Y = sim.particles.by_id("x")[:, 1]
        found = sim.relax(residual=1e-5)
        u = sim.particles.by_id("x")[:, 1] - Y
        errors.append(float(np.sqrt(np.mean((u + load * (Y - Y**2 / 2)) ** 2))) / (load / 2))
        assert found.residual <= 1e-5
        assert sim.time == 0
        assert not sim.particles["v"].any()
    print(f"\nerror over the tip's displacement {errors[0]:.2e} at 8 cells, {errors[1]:.2e} at 16; {found.steps} steps")
    # strains of 30 % move particles across cells, which costs the splines their order
    assert errors[1] < (6e-4 if load < 0.1 else 3e-3)
    assert np.log2(errors[0] / errors[1]) > (1.9 if load < 0.1 else 0.7)


def test_relaxed_bonds_hang() -> None:
    """Without a grid: at rest the clamps carry the weight, so that every free particle's force balances gravity."""
    tree = block(PD_BOND, DIRECT, gravity=[0.0, -1.0, 0.0])
    tree["condition"] = [{"clamped": True, "shape": box([-1, 0.3, -1], [1, 1, 1])}]
    sim = perimpm.Simulation(tree)
    free = sim.particles["x"][:, 1] < 0.3
    sim.relax(residual=1e-8)
    net = sim.particles["force"][free] + sim.particles["mass"][free, None] * [0.0, -1.0, 0.0]
    assert np.abs(net).max() < 1e-5 * sim.particles["mass"][0]


def test_no_equilibrium_is_an_error() -> None:
    tree = block(LOCAL, GRID[0], gravity=[0.0, -1.0, 0.0])
    with pytest.raises(perimpm.SimulationError, match="no equilibrium within 50 steps"):
        perimpm.Simulation(tree).relax(max_steps=50)


def test_ctrl_c_ends_a_search() -> None:
    sim = perimpm.Simulation(block(LOCAL, GRID[0], gravity=[0.0, -1.0, 0.0]))
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        sim.relax(residual=1e-30, max_steps=10**9)
    timer.join()
    assert sim.time == 0


def test_same_bits_for_one_and_two_threads() -> None:
    tree = block(LOCAL, GRID[0], precision="float")
    tree["condition"] = [
        {"velocity": [0.3, "free", 0.0], "shape": box([-1, -1, -1], [0.12, 1, 1])},
        {"force": [0.0, 50.0, 0.0], "shape": box([0.3, -1, -1], [1, 1, 1])},
    ]
    states = []
    for threads in (1, 2):
        sim = perimpm.Simulation(tree, threads=threads)
        sim.step(300)
        states.append(sim.particles.by_id("x"))
    assert np.array_equal(*states)


def test_held_across_a_mirror() -> None:
    """A region that meets a symmetry face moves as told, and the rest as in the whole body."""
    results = []
    for low, face in ((0.0, "symmetry"), (-0.4, "open")):
        tree = scene(LOCAL, box([low, 0, 0], [0.4, 0.4, 0.4]), 0.05, transfer=GRID[0], dt=2e-4)
        faces = {f"{end}_{axis}": "open" for end in ("min", "max") for axis in "xyz"} | {"min_x": face}
        tree["grid"]["domain"] = {"min": [min(low, 0.0), -1.0, -1.0], "max": [1.0] * 3, "faces": faces}
        tree["condition"] = [{"velocity": [0.0, 1.0, "free"], "shape": box([-1, -1, -1], [1, 0.15, 1])}]
        sim = perimpm.Simulation(tree)
        X = sim.particles.by_id("x")
        sim.step(100)
        order = np.lexsort(X[X[:, 0] > 0].T)
        results.append(sim.particles.by_id("x")[X[:, 0] > 0][order])
    assert np.abs(results[0] - results[1]).max() < 1e-12


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ({}, "condition 0 does nothing: expected one of velocity"),
        ({"velocity": [0.0, 0.0]}, "must hold 3 components, got 2"),
        ({"velocity": [0.0, "fre", 0.0]}, 'must hold numbers \\[m/s\\] or "free", got "fre"'),
        ({"velocity": ["free"] * 3}, "leaves every component free"),
        ({"velocity": [0.0] * 3, "force": [0.0] * 3}, "excludes 'velocity'"),
        ({"clamped": False}, "must be true"),
        ({"clamped": True, "body": "bodi 0"}, "names 'bodi 0'"),
        ({"clamped": True, "material": "n"}, "names 'n'"),
        ({"clamped": True, "times": [0.0, 1.0]}, "as many numbers as its partner"),
        ({"clamped": True, "times": [1.0, 1.0], "factors": [0.0, 1.0]}, "must rise"),
        ({"clamped": True, "shape": box([5] * 3, [6] * 3)}, "has no particles"),
        ({"clamped": True, "shap": 1}, "did you mean 'shape'"),
    ],
)
def test_bad_conditions(condition: Tree, message: str) -> None:
    with pytest.raises(perimpm.InputError, match=message):
        perimpm.Simulation(block(LOCAL, GRID[0], condition=[condition]))


def test_bad_functions() -> None:
    sim = perimpm.Simulation(block(LOCAL, GRID[0]))
    sim.prescribe(lambda X, t: np.zeros((3, 7)))
    with pytest.raises(perimpm.InputError, match=r"expected numbers of shape \(512, 3\)"):
        sim.step()
    sim = perimpm.Simulation(block(LOCAL, GRID[0]))
    sim.load(body_force=lambda X, t: [np.nan, 0, 0])
    with pytest.raises(perimpm.SimulationError, match="returned nan for particle 0"):
        sim.step()
    sim = perimpm.Simulation(block(LOCAL, GRID[0]))
    sim.load(body_force=lambda X, t: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        sim.step()
    sim = perimpm.Simulation(block(LOCAL, GRID[0]))
    sim.step()
    with pytest.raises(perimpm.InputError, match="before the first step"):
        sim.prescribe([0.0, 0.0, 0.0])


def test_plan_says_what_conditions_cost() -> None:
    without = perimpm.Simulation(block(LOCAL, GRID[0])).plan
    assert "conditions" in [s.what for s in without.skipped]
    assert "conditions" not in [a.name for a in without.arrays] + [p.name for p in without.passes]
    sim = perimpm.Simulation(block(LOCAL, GRID[0]))
    sim.prescribe([0.0, 0.0, 0.0], shape=box([-1] * 3, [0.1, 1, 1]))
    assert "conditions" in [a.name for a in sim.plan.arrays]
    assert [p.writes for p in sim.plan.passes if p.name == "conditions"] == [["v", "x", "grid"]]
