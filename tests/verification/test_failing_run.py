"""A run that fails ends with code 3 and leaves what explains it (E13)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bad_scenes import good, put
from support import Array
from trees import LOCAL, PD_BOND, Tree, write

import perimpm
from perimpm.cli import main


@pytest.mark.parametrize("law", [LOCAL, PD_BOND], ids=["fixed_corotated", "pd_bond"])
@pytest.mark.parametrize("field", ["v", "x"])
def test_not_a_number_during_a_run(law: Tree, field: str, tmp_path: Path) -> None:
    sim = perimpm.Simulation(put(put(good(), "material.m.constitutive", law), "simulation.end_time", 1.0))
    sim.step(3)
    sim.particles[field][5, 1] = np.nan
    with pytest.raises(perimpm.SimulationError, match="finite|not a number"):
        sim.run(output=tmp_path / "out")
    assert not list((tmp_path / "out").glob("frame.*"))  # the next frame lay behind the fault
    assert (tmp_path / "out" / "failed.h5").exists()
    assert json.loads((tmp_path / "out" / "run.json").read_text())["status"] == "failed"


@pytest.mark.parametrize("field", ["mass", "volume"])
@pytest.mark.parametrize("value", [np.nan, 0.0, -1.0])
def test_weights_that_make_no_sense(field: str, value: float) -> None:
    """Many steps in one call move and scatter particles in one pass, which must not meet what is not finite."""
    for law in (LOCAL, PD_BOND):
        sim = perimpm.Simulation(put(good(), "material.m.constitutive", law))
        sim.step(3)
        sim.particles[field][0] = value
        with pytest.raises(perimpm.SimulationError, match=f"'{field}' of particle .* above 0"):
            sim.step(20)


def test_volumes_of_bond_laws_are_kept() -> None:
    sim = perimpm.Simulation(put(good(), "material.m.constitutive", PD_BOND))
    sim.particles["volume"][0] *= 2
    with pytest.raises(perimpm.SimulationError, match="bonds of material 'm' keep"):
        sim.step()


def test_command_ends_with_3_when_a_run_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A step a hundred times too long, accepted by name."""
    tree = put(put(good(), "simulation.dt", 0.5), "simulation.allow_unstable_dt", True)
    tree = put(put(tree, "body.0.initial_angular_velocity", [0.0, 3.0, 0.0]), "grid.domain", None)
    tree["simulation"] |= {"end_time": 500.0, "frame_rate": 0.02}
    file = write(tree, tmp_path / "scene.toml")
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--threads", "1"]) == 3
    shown = capsys.readouterr().err
    bound = perimpm.Simulation(put(tree, "simulation.dt", "auto")).plan.bounds[0].dt
    assert "simulation failed" in shown
    assert f"dt is above the stable step: 0.5 s, where {bound:g} s was stable, in step 1;" in shown
    assert (tmp_path / "out" / "failed.h5").exists()
    assert "where" in record(tmp_path / "out")["error"]


def record(folder: Path) -> Tree:
    tree: Tree = json.loads((folder / "run.json").read_text())
    return tree


@pytest.mark.parametrize("law", [LOCAL, PD_BOND], ids=["fixed_corotated", "pd_bond"])
def test_a_condition_that_raises(law: Tree, tmp_path: Path) -> None:
    """The exception comes back as it is; frames before it stay, and the files say what happened."""
    sim = perimpm.Simulation(put(put(good(), "material.m.constitutive", law), "simulation.end_time", 1.0))

    def wind(X: Array, t: float) -> list[float]:
        if t > 0.03:
            raise LookupError("no wind today")
        return [0.0, 0.0, 0.0]

    sim.load(acceleration=wind)
    with pytest.raises(LookupError, match="no wind today"):
        sim.run(output=tmp_path)
    assert record(tmp_path)["status"] == "failed" and "no wind today" in (tmp_path / "run.json").read_text()
    assert {file.name for file in tmp_path.glob("*.h5")} == {"frame.0001.h5", "frame.0002.h5", "failed.h5"}


def test_ctrl_c_inside_a_condition_waits_for_the_end_of_the_step(tmp_path: Path) -> None:
    sim = perimpm.Simulation(put(good(), "simulation.end_time", 1.0))
    times = []

    def wind(X: Array, t: float) -> list[float]:
        times.append(t)
        if len(times) == 20:
            raise KeyboardInterrupt
        return [0.0, 0.0, 0.0]

    sim.load(acceleration=wind)
    with pytest.raises(KeyboardInterrupt):
        sim.run(output=tmp_path)
    assert times[19] == times[20]  # asked again, so that the step is whole
    assert record(tmp_path)["status"] == "stopped" and not (tmp_path / "failed.h5").exists()
    assert 20 <= sim.steps < 100
