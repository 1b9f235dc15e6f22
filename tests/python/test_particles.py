"""Particle fields as views."""

from __future__ import annotations

import gc
from typing import Any

import numpy as np
import pytest

import perimpm
from perimpm import _core


def test_shapes_and_types(box: dict[str, Any]) -> None:
    p = perimpm.Simulation(box).particles
    assert p["x"].shape == (1728, 3) and p["x"].dtype == np.float32
    assert p["C"].shape == (1728, 3, 3)
    assert p["mass"].shape == (1728,)
    assert p["id"].dtype == np.uint32
    box["simulation"]["precision"] = "double"
    assert perimpm.Simulation(box).particles["v"].dtype == np.float64


def test_values_and_component_order(box: dict[str, Any]) -> None:
    box["simulation"]["precision"] = "double"
    p = perimpm.Simulation(box).particles
    assert np.allclose(p["x"].min(axis=0), [-0.275, 0.525, -0.275])  # half a spacing inside the box
    assert np.allclose(p["x"].max(axis=0), [0.275, 1.075, 0.275])
    assert np.allclose(p["v"], [1.0, 0.0, 0.0])
    assert np.allclose(p["mass"], 1000.0 * 0.05**3)
    assert np.array_equal(p.of("rubber")["F"], np.broadcast_to(np.eye(3), (1728, 3, 3)))
    assert p.unit("v") == "m/s"


def test_tensors_are_row_major(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    sim.particles["v"][:, 0] = sim.particles["x"][:, 1]  # dv_x / dy = 1/s
    sim.particles["C"][:] = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    dt = sim.step()
    F = sim.particles["F"]
    assert np.allclose(F[:, 0, 1], dt, rtol=1e-3)
    assert np.allclose(F[:, 1, 0], 0.0, atol=1e-3 * dt)


def test_writing_changes_the_simulation(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    sim.particles["v"][:, 2] = 3.0
    assert sim.ledger.momentum[2] == pytest.approx(3.0 * 1000.0 * 0.6**3, rel=1e-5)


@pytest.mark.parametrize("transfer", ["apic", "particle"])
def test_looking_changes_no_bit_and_costs_no_pass(
    transfer: str, box: dict[str, Any], bonded: dict[str, Any], request: pytest.FixtureRequest
) -> None:
    tree = box
    if transfer == "particle":
        tree = bonded | {"transfer": {"type": "particle"}}
        del tree["grid"]
        tree["output"] = {"fields": ["x"]}
    else:
        tree["material"]["rubber"]["constitutive"] = {"type": "fixed_corotated", "youngs_modulus": 1e5}
    tree["simulation"]["gravity"] = [0.0, 0.0, 0.0]
    tree["body"][0]["initial_angular_velocity"] = [3.0, 2.0, 1.0]
    alone, watched = perimpm.Simulation(tree, threads=1), perimpm.Simulation(tree, threads=1)
    kept = watched.particles["x"]
    for _ in range(60):
        alone.step()
        watched.particles["v"].sum() + watched.particles["x"].sum() + kept.sum()
        watched.step()
    assert alone.time == watched.time
    for name in ("x", "v"):
        assert alone.particles.by_id(name).tobytes() == watched.particles.by_id(name).tobytes()
    calls = [{p.name: p.calls for p in sim.pass_times} for sim in (alone, watched)]
    assert calls[0] == calls[1]


def test_written_velocities_set_the_next_step(box: dict[str, Any]) -> None:
    """dt = safety * courant dx / (c + |v|): ten times the wave speed leaves an eleventh of the step."""
    box["body"][0]["initial_velocity"] = [0.0, 0.0, 0.0]
    sim = perimpm.Simulation(box)
    rest = sim.step()
    v = sim.particles["v"]
    v[:, 0] = 10 * sim.plan.materials[0].wave_speed
    assert sim.step() == pytest.approx(rest / 11, rel=1e-2)  # gravity had one step to add speed


@pytest.mark.parametrize("name", ["x", "v"])
def test_a_written_nan_names_its_particle(name: str, box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    row = int(np.flatnonzero(sim.particles["id"] == 77)[0])
    sim.particles[name][row, 2] = np.nan
    with pytest.raises(perimpm.SimulationError, match=f"'{name}' of particle 77 is not finite: component z"):
        sim.step()


def test_moved_particles_are_sorted_anew(box: dict[str, Any]) -> None:
    box["simulation"]["gravity"] = [0.0, 0.0, 0.0]
    sim = perimpm.Simulation(box)
    x = sim.particles["x"]
    x[:, 2] += 0.5
    before = sim.particles.by_id("x")
    sim.step()
    moved = sim.particles.by_id("x") - before
    assert np.allclose(moved[:, 0], sim.time, rtol=1e-3)  # 1 m/s
    assert np.allclose(moved[:, 2], 0.0, atol=1e-6)


def test_a_view_keeps_the_simulation_alive(box: dict[str, Any]) -> None:
    x = perimpm.Simulation(box).particles["x"]
    gc.collect()
    assert not x.flags.owndata
    assert np.isfinite(x).all()


def test_by_id_survives_re_sorting(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    start, generation = sim.particles.by_id("x"), sim.particles.generation
    while sim.particles.generation == generation:
        sim.step()
    assert np.array_equal(sim.particles.by_id("id"), np.arange(1728))
    drop = np.array([1.0 * sim.time, -0.5 * 9.81 * sim.time**2, 0.0])
    assert np.allclose(sim.particles.by_id("x") - start, drop, atol=0.02)


def test_mapping(box: dict[str, Any]) -> None:
    p = perimpm.Simulation(box).particles
    assert {"x", "v", "mass", "volume", "id"} <= set(p)
    assert "x" in p and "y" not in p
    assert len(p) == len(list(p))


def test_assignment_writes_into_the_view(box: dict[str, Any]) -> None:
    p = perimpm.Simulation(box).particles
    v = p["v"]
    p["v"] = [1.0, 2.0, 3.0]
    assert np.array_equal(v, np.tile(np.float32([1, 2, 3]), (len(v), 1)))
    with pytest.raises(ValueError, match="broadcast"):
        p["v"] = np.zeros((2, 3))


def test_unknown_names(box: dict[str, Any]) -> None:
    p = perimpm.Simulation(box).particles
    with pytest.raises(KeyError, match="\\n  did you mean 'mass'"):  # a line of its own
        p["mas"]
    with pytest.raises(perimpm.InputError, match="rubber"):
        p.of("ruber")


def test_fingerprint_sees_every_number_of_a_packed_field(box: dict[str, Any]) -> None:
    """Entries of `record` stand side by side, not components."""
    box["material"]["rubber"]["constitutive"] = {"type": "pd_elastic", "youngs_modulus": 1e5, "horizon": 2.01}
    sim = perimpm.Simulation(box)
    sim.step()
    field = sim.particles["record"]
    seen = {_core.fingerprint(sim._core, "record")}
    for at in ((0, 0, 0), (0, 2, 2), (len(field) - 1, 0, 0), (len(field) - 1, 2, 2), (len(field) // 2, 1, 0)):
        field[at] += 1.0
        seen.add(_core.fingerprint(sim._core, "record"))
    assert len(seen) == 6


def test_numbers_that_others_count_on_can_only_be_read(bonded: dict[str, Any]) -> None:
    bonded["material"]["rubber"]["fracture"] = {"type": "critical_stretch", "critical_stretch": 0.5}
    particles = perimpm.Simulation(bonded).particles.of("rubber")
    for name in ("id", "broken_bonds", "damage"):
        with pytest.raises(ValueError, match="read-only"):
            particles[name][0] = 1


@pytest.mark.parametrize("field", ["F", "mass"])
def test_what_is_written_chooses_the_next_step(field: str, box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    before = sim.step()
    values = sim.particles.of("rubber")[field]
    if field == "F":
        values[:, 0, 0] = 4  # stiffer along x
    else:
        values[:] *= 0.01  # sound ten times as fast
    assert sim.step() < (0.8 if field == "F" else 0.2) * before
