"""Scenes small enough to run in a second."""

from __future__ import annotations

from pathlib import Path

import pytest
import trees


@pytest.fixture
def box() -> trees.Tree:
    """12 x 12 x 12 particles of mass 1000 kg/m^3 (0.05 m)^3 in free flight."""
    return trees.falling_box()


@pytest.fixture
def bonded(box: trees.Tree) -> trees.Tree:
    """The same box with the bond law."""
    box["material"]["rubber"]["constitutive"] = {**trees.PD_ELASTIC, "horizon": 2.01}
    return box


@pytest.fixture
def scene_file(box: trees.Tree, tmp_path: Path) -> Path:
    """The box as a TOML file."""
    return trees.write(box, tmp_path / "box.toml")
