"""Scenes and sums that the verification tests share. SI units throughout."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import perimpm

Array = npt.NDArray[np.float64]
Tree = dict[str, Any]

LOCAL: Tree = {"type": "fixed_corotated", "youngs_modulus": 1e5, "poisson_ratio": 0.25}
PD_ELASTIC: Tree = {"type": "pd_elastic", "youngs_modulus": 1e5}
PD_BOND: Tree = {"type": "pd_bond", "youngs_modulus": 1e5}


def box(low: Any, high: Any) -> Tree:
    return {"type": "box", "min": [float(c) for c in low], "max": [float(c) for c in high]}


def scene(
    law: Tree | dict[str, Tree],
    shapes: Tree | list[tuple[str, Tree]],
    spacing: float,
    *,
    dx: float | None = None,
    transfer: Tree | None = None,
    density: float = 1000.0,
    gravity: Any = (0.0, 0.0, 0.0),
    dt: float | str = "auto",
    precision: str = "double",
    **more: Any,
) -> Tree:
    """A scene without gravity, in double. `law`: one law, for the material "m", or laws by material. `shapes`: one
    shape, or (material, shape) of each body. `spacing`: of particles; `dx`: of the grid, twice that by default."""
    laws = {"m": law} if "type" in law else law
    bodies = [("m", shapes)] if isinstance(shapes, dict) else shapes
    transfer = transfer or {"type": "apic"}
    tree: Tree = {
        "format": 1,
        "simulation": {"end_time": 1.0, "gravity": list(gravity), "dt": dt, "precision": precision},
        "transfer": transfer,
        "material": {name: {"density": density, "constitutive": one} for name, one in laws.items()},
        "body": [{"material": name, "shape": shape, "particle_spacing": spacing} for name, shape in bodies],
        "output": {"formats": []},
    }
    if transfer["type"] != "particle":
        tree["grid"] = {"spacing": dx or 2 * spacing}
    return tree | more


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
