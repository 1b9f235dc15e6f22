"""Waves and sums that the verification tests share. SI units throughout."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from trees import LOCAL, Tree, box, scene

import perimpm

Array = npt.NDArray[np.float64]
def momentum_scale(sim: perimpm.Simulation) -> float:
    """sum m |v| [kg m/s]."""
    return float(np.sum(sim.particles["mass"] * np.linalg.norm(sim.particles["v"], axis=1)))


def energy(sim: perimpm.Simulation) -> float:
    """Kinetic, elastic and potential [J]."""
    ledger = sim.ledger
    return ledger.kinetic + ledger.elastic + ledger.potential


def drift(now: Any, start: Any, scale: float) -> float:
    return float(np.linalg.norm(np.subtract(now, start)) / scale)


def spin(omega: Any, offsets: Array) -> Array:
    """Velocities of a rigid rotation."""
    return np.cross(np.broadcast_to(np.asarray(omega, float), offsets.shape), offsets)


def cross_matrix(omega: Any) -> Array:
    """W with W r = omega x r."""
    x, y, z = omega
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float)


def rotation(axis: Any, angle: float) -> Array:
    """Rodrigues' formula."""
    unit = np.asarray(axis, float) / np.linalg.norm(axis)
    W = cross_matrix(unit)
    return np.asarray(np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W)


@dataclass
class Wave:
    """The first mode of a slab 0 <= X <= 1 in uniaxial strain: u = A shape(pi X) sin(pi c t), exact for
    fixed-corotated, whose P = M (F - 1), at any amplitude below 1 / pi (A3)."""

    sim: perimpm.Simulation
    amplitude: float  # m
    speed: float  # c = sqrt(M / rho) [m/s]
    steps: int  # in a period 2 / c
    shape: Array  # of the particles in the order of ids


def _slab(
    transfer: Tree, cells: int, amplitude: float, courant: float, fixed: bool, thickness: int = 2, face: str = "slip"
) -> Wave:
    dx, density = 1 / cells, 1000.0
    speed = float(np.sqrt(1.2 * LOCAL["youngs_modulus"] / density))  # nu = 1/4: M = 1.2 E
    dt = courant * dx / speed
    side = thickness * dx
    tree = scene(LOCAL, box([0] * 3, [1, side, side]), dx / 2, transfer=transfer, density=density, dt=dt)
    reach = 0.0 if fixed else 1.0
    faces = {f"{end}_{axis}": face for end in ("min", "max") for axis in "yz"}
    faces |= {f"{end}_x": face if fixed else "open" for end in ("min", "max")}
    tree["grid"]["domain"] = {"min": [-reach, 0.0, 0.0], "max": [1 + reach, side, side], "faces": faces}
    sim = perimpm.Simulation(tree, threads=1)
    shape, slope = (np.sin, np.cos) if fixed else (np.cos, lambda x: -np.sin(x))
    X = np.pi * sim.particles["x"][:, 0].copy()
    peak = amplitude * np.pi * speed * np.cos(np.pi * speed * dt / 2)  # velocities live half a step before positions
    sim.particles["v"][:, 0] = peak * shape(X)
    if "C" in sim.particles:
        sim.particles["C"][:, 0, 0] = peak * np.pi * slope(X)
    return Wave(sim, amplitude, speed, round(2 / speed / dt), shape(np.pi * sim.particles.by_id("x")[:, 0]))


def free_slab(transfer: Tree, cells: int, amplitude: float, courant: float) -> Wave:
    """Free ends, shape = cos: the stress vanishes there at all times."""
    return _slab(transfer, cells, amplitude, courant, fixed=False)


def fixed_slab(
    transfer: Tree, cells: int, amplitude: float, courant: float, thickness: int = 2, face: str = "slip"
) -> Wave:
    """Slip faces at both ends and sides, shape = sin. thickness: in cells."""
    return _slab(transfer, cells, amplitude, courant, fixed=True, thickness=thickness, face=face)
