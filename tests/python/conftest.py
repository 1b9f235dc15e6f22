"""Scenes small enough to run in a second."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

_BOX: dict[str, Any] = {
    "format": 1,
    "title": "falling box",
    "simulation": {"end_time": 0.1, "frame_rate": 24.0, "gravity": [0.0, -9.81, 0.0]},
    "grid": {"spacing": 0.1, "domain": {"min": [-1.0, 0.0, -1.0], "max": [1.0, 2.0, 1.0], "faces": "separate"}},
    "transfer": {"type": "apic", "order": 2},
    "material": {
        "rubber": {
            "density": 1000.0,
            "constitutive": {"type": "fixed_corotated", "youngs_modulus": 1.0e5, "poisson_ratio": 0.25},
        }
    },
    "body": [
        {
            "material": "rubber",
            "shape": {"type": "box", "min": [-0.3, 0.5, -0.3], "max": [0.3, 1.1, 0.3]},
            "particle_spacing": 0.05,
            "initial_velocity": [1.0, 0.0, 0.0],
        }
    ],
    "output": {"fields": ["x", "v", "id", "body"]},
}


@pytest.fixture
def box() -> dict[str, Any]:
    """12 x 12 x 12 particles of mass 1000 kg/m^3 (0.05 m)^3 in free flight."""
    return copy.deepcopy(_BOX)


@pytest.fixture
def bonded(box: dict[str, Any]) -> dict[str, Any]:
    """The same box with the bond law."""
    box["material"]["rubber"]["constitutive"] = {"type": "pd_elastic", "youngs_modulus": 1.0e5, "horizon": 2.01}
    return box


def toml_value(value: Any) -> str:
    """One value as TOML, tables inline."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    return json.dumps(value)


@pytest.fixture
def scene_file(box: dict[str, Any], tmp_path: Path) -> Path:
    """The box as a TOML file."""
    file = tmp_path / "box.toml"
    file.write_text("".join(f"{key} = {toml_value(value)}\n" for key, value in box.items()))
    return file
