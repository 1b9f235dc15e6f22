"""What is installed, and what it accepts."""

from __future__ import annotations

import pytest

import perimpm


def test_families() -> None:
    families = perimpm.plugins()
    assert {"apic", "flip", "particle", "pic"} <= set(families["transfer"])
    assert {"fixed_corotated", "pd_bond", "pd_elastic"} <= set(families["constitutive"])
    assert "critical_stretch" in families["fracture"]


@pytest.mark.parametrize("name", [name for names in perimpm.plugins().values() for name in names])
def test_every_model_describes_itself(name: str) -> None:
    model = perimpm.describe(name)
    assert model.name == name and model.summary
    assert name in perimpm.plugins()[model.family]
    keys = [key for _, _, params in model.sections for key in params]
    assert all(key.doc and key.unit for key in keys)
    assert all(key.key in str(model) for key in keys)


def test_a_parameter() -> None:
    params = {p.key: p for p in perimpm.describe("fixed_corotated").sections[0][2]}
    assert params["youngs_modulus"].unit == "Pa"
    assert params["youngs_modulus"].range == "> 0"
    assert params["youngs_modulus"].required
    assert params["poisson_ratio"].range == "(-1, 0.5)"


def test_scene_tables() -> None:
    page = str(perimpm.describe("scene"))
    for key in ("end_time", "frame_rate", "spacing", "density", "initial_velocity", "friction"):
        assert key in page


def test_unknown_model_suggests_the_nearest() -> None:
    with pytest.raises(perimpm.InputError, match="did you mean 'fixed_corotated'"):
        perimpm.describe("fixed_corotatd")
