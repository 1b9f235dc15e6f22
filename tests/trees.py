"""Scenes as dicts that all Python tests share. SI units throughout."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

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


def falling_box() -> Tree:
    """12 x 12 x 12 particles of mass 1000 kg/m^3 (0.05 m)^3 in free flight at 1 m/s along x; three frames."""
    shape = box([-0.3, 0.5, -0.3], [0.3, 1.1, 0.3])
    more: Tree = {"transfer": {"type": "apic", "order": 2}, "precision": "float"}
    tree = scene({"rubber": dict(LOCAL)}, [("rubber", shape)], 0.05, gravity=(0.0, -9.81, 0.0), **more)
    tree["simulation"] |= {"end_time": 0.1, "frame_rate": 24.0}
    tree["grid"]["domain"] = {"min": [-1.0, 0.0, -1.0], "max": [1.0, 2.0, 1.0], "faces": "separate"}
    tree["body"][0]["initial_velocity"] = [1.0, 0.0, 0.0]
    return tree | {"title": "falling box", "output": {"fields": ["x", "v", "id", "body"]}}


def toml(value: Any) -> str:
    """One value as TOML, tables inline."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


def write(tree: Tree, file: Path) -> Path:
    """A scene as a file."""
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in tree.items()))
    return file
