"""Scenes from dicts and files: one tree, one validator, and places in every message."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import perimpm
from perimpm import _core


def test_dict_and_file_give_the_same_tree(box: dict[str, Any], scene_file: Path) -> None:
    assert _core.Scene(scene_file).to_json() == _core.Scene(box).to_json()


def test_numpy_values_are_plain_values(box: dict[str, Any]) -> None:
    plain = _core.Scene(box).to_json()
    box["simulation"]["gravity"] = np.array([0.0, -9.81, 0.0])
    box["simulation"]["frame_rate"] = np.float64(24.0)
    box["transfer"]["order"] = np.int32(2)
    assert _core.Scene(box).to_json() == plain
    box["simulation"]["allow_unstable_dt"] = np.bool_(True)
    assert json.loads(_core.Scene(box).to_json())["simulation"]["allow_unstable_dt"] is True


def test_wrong_value_names_its_dotted_path(box: dict[str, Any]) -> None:
    box["body"][0]["shape"]["max"] = [0.3, "high", 0.3]
    with pytest.raises(perimpm.InputError, match=r"^body\.0\.shape\.max\.1: "):
        perimpm.Simulation(box)


def test_unknown_key_suggests_the_nearest(box: dict[str, Any]) -> None:
    box["material"]["rubber"]["constitutive"]["youngs_modulos"] = 1.0
    with pytest.raises(perimpm.InputError, match="youngs_modulos(.|\n)*did you mean 'youngs_modulus'"):
        perimpm.Simulation(box)


@pytest.mark.parametrize("value", [None, object(), 1 + 2j, 2**70])
def test_values_that_no_scene_can_hold(box: dict[str, Any], value: object) -> None:
    box["simulation"]["end_time"] = value
    with pytest.raises(perimpm.InputError, match=r"^simulation\.end_time: "):
        perimpm.Simulation(box)


def test_keys_are_texts(box: dict[str, Any]) -> None:
    box["simulation"][3] = 1.0
    with pytest.raises(perimpm.InputError, match="keys of a scene table are texts, not 3"):
        perimpm.Simulation(box)


def test_overrides_change_one_value_or_a_whole_table(box: dict[str, Any]) -> None:
    swap = 'material.rubber.constitutive={ type = "pd_elastic", youngs_modulus = 2e5, horizon = 2.01 }'
    sim = perimpm.Simulation(box, ["simulation.end_time=0.5", swap])
    assert sim.plan.materials[0].law == "pd_elastic"
    assert sim.plan.materials[0].bonds > 0


def test_overrides_are_a_list(box: dict[str, Any]) -> None:
    with pytest.raises(perimpm.InputError, match=r"expected a list of changes, \['grid.spacing=0.05'\]"):
        perimpm.Simulation(box, overrides="grid.spacing=0.05")


@pytest.mark.parametrize("count", [-1, 3.0, "3"])
def test_steps_are_whole_numbers(box: dict[str, Any], count: Any) -> None:
    with pytest.raises(perimpm.InputError, match="expected a whole number of steps, 0 or more"):
        perimpm.Simulation(box).step(count)


def test_input_error_is_a_value_error(box: dict[str, Any]) -> None:
    del box["material"]
    with pytest.raises(ValueError):
        perimpm.Simulation(box)
    assert issubclass(perimpm.SimulationError, RuntimeError)
    assert perimpm.InputError.__module__ == "perimpm"


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(perimpm.InputError, match="nowhere.toml"):
        perimpm.Simulation(tmp_path / "nowhere.toml")
