"""Files of a run: frames, run.xdmf, energy.csv, run.json."""

from __future__ import annotations

import json
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import perimpm

h5py = pytest.importorskip("h5py")


@pytest.fixture
def folder(box: dict[str, Any], tmp_path: Path) -> Path:
    perimpm.Simulation(box).run(output=tmp_path)
    return tmp_path


def test_one_frame_each_interval(folder: Path) -> None:
    assert sorted(f.name for f in folder.glob("frame.*")) == [f"frame.000{n}.h5" for n in (1, 2, 3)]
    for n in (1, 2, 3):
        with h5py.File(folder / f"frame.000{n}.h5") as file:
            assert file.attrs["time"] == pytest.approx((n - 1) / 24, abs=1e-12)
            assert file.attrs["frame"] == n
            assert file.attrs["upAxis"] == "Y" and file.attrs["metersPerUnit"] == 1.0


def test_datasets(folder: Path) -> None:
    with h5py.File(folder / "frame.0003.h5") as file:
        assert file["x"].shape == (1728, 3) and file["x"].attrs["unit"] == "m"
        assert file["v"].attrs["unit"] == "m/s" and file["v"].attrs["source"]
        assert np.array_equal(file["id"], np.arange(1728))
        assert np.array_equal(file["connectivity"], np.arange(1728))
        assert not np.any(file["body"])
        assert file["x"].compression == "gzip" and file["x"].shuffle


def test_frames_are_in_the_order_of_ids(box: dict[str, Any], tmp_path: Path) -> None:
    sim = perimpm.Simulation(box)
    sim.run(output=tmp_path)
    sim.run(frames=4, output=tmp_path)
    with h5py.File(tmp_path / "frame.0004.h5") as file:
        assert np.array_equal(file["x"], sim.particles.by_id("x"))


def test_xdmf_lists_what_exists(folder: Path) -> None:
    grids = ET.parse(folder / "run.xdmf").getroot().findall("./Domain/Grid/Grid")
    assert [float(g.find("Time").get("Value")) for g in grids] == pytest.approx([0, 1 / 24, 2 / 24])  # type: ignore[union-attr, arg-type]
    for item in grids[0].iter("DataItem"):
        name, dataset = str(item.text).split(":/")
        with h5py.File(folder / name) as file:
            shape = tuple(int(n) for n in str(item.get("Dimensions")).split())
            assert file[dataset].shape == shape
            assert file[dataset].dtype.itemsize == int(str(item.get("Precision")))


def test_energy(folder: Path) -> None:
    rows = np.genfromtxt(folder / "energy.csv", delimiter=",", names=True)
    energies = ("kinetic", "elastic", "potential", "total", "dissipated")
    assert rows.dtype.names == ("time", *energies, "px", "py", "pz", "lx", "ly", "lz")
    mass = 1000.0 * 0.6**3
    assert rows["kinetic"][0] == pytest.approx(0.5 * mass, rel=1e-5)
    assert rows["px"] == pytest.approx(mass, rel=1e-5)
    assert rows["py"] == pytest.approx(-mass * 9.81 * rows["time"], rel=1e-4, abs=1e-4)
    assert rows["total"] == pytest.approx(rows["kinetic"] + rows["elastic"] + rows["potential"])


def test_dissipated_is_what_the_total_lost(box: dict[str, Any], tmp_path: Path) -> None:
    """PIC calms a spinning box; a run that is continued counts from its own first row, not from where it went on."""
    box["simulation"] |= {"gravity": [0.0, 0.0, 0.0], "precision": "double"}
    box["transfer"]["type"] = "pic"
    box["body"][0]["initial_angular_velocity"] = [0.0, 5.0, 0.0]
    sim = perimpm.Simulation(box)
    sim.run(frames=2, output=tmp_path)
    sim.run(frames=3, output=tmp_path)
    rows = np.genfromtxt(tmp_path / "energy.csv", delimiter=",", names=True)
    assert len(rows) == 3 and rows["dissipated"][0] == 0.0
    assert np.array_equal(rows["dissipated"], rows["total"][0] - rows["total"])
    spin = 0.5 * 5.0**2 * 1000.0 * 0.6**3 * 0.6**2 / 6  # of a solid cube, I = m a^2 / 6; nothing else can be lost
    assert 0.1 * spin < rows["dissipated"][1] < rows["dissipated"][2] < spin


def test_free_flight_dissipates_what_the_steps_do(folder: Path) -> None:
    """The work of gravity is accounted for. What is left is the integrator's: with v before x a step falls by g dt^2 / 2
    more than the parabola, m g^2 dt^2 / 2 of energy."""
    rows = np.genfromtxt(folder / "energy.csv", delimiter=",", names=True)
    steps = []
    for n in (1, 2, 3):
        with h5py.File(folder / f"frame.000{n}.h5") as file:
            steps.append(int(file.attrs["step"]))
    per_frame = 0.5 * 1000.0 * 0.6**3 * 9.81**2 * (1 / 24) ** 2 / np.diff(steps)
    assert np.diff(rows["dissipated"]) == pytest.approx(per_frame, rel=1e-2)


def test_sources(bonded: dict[str, Any], tmp_path: Path) -> None:
    material = bonded["material"]["rubber"]
    material["fracture"] = {"type": "critical_stretch", "critical_stretch": 0.5}
    wanted = {"x": "core", "v": "core", "id": "core", "mass": "core", "volume": "core", "body": "core", "C": "apic"}
    wanted |= {"force": "pd_elastic", "mean_deformation": "pd_elastic", "broken_bonds": "critical_stretch"}
    bonded["output"]["fields"] = list(wanted)
    perimpm.Simulation(bonded).run(frames=1, output=tmp_path)
    with h5py.File(tmp_path / "frame.0001.h5") as file:
        assert {name: file[name].attrs["source"] for name in wanted} == wanted


def test_run_json(folder: Path) -> None:
    record = json.loads((folder / "run.json").read_text())
    assert record["status"] == "done" and record["frames"] == 3
    assert record["perimpm"] == perimpm.__version__
    assert record["particles"] == 1728 and record["precision"] == "float"
    assert record["scene"]["material"]["rubber"]["density"] == 1000.0
    times = {p["name"]: p for p in record["passes"]}["gather"]
    assert times["ns_per_particle_step"] == pytest.approx(1e9 * times["seconds"] / (1728 * record["steps"]))


def test_the_same_run_leaves_the_same_frames(box: dict[str, Any], tmp_path: Path) -> None:
    for folder in ("one", "two"):
        perimpm.Simulation(box).run(frames=2, output=tmp_path / folder)
        time.sleep(1.1)  # times in files are whole seconds
    for frame in ("frame.0001.h5", "frame.0002.h5"):
        assert (tmp_path / "one" / frame).read_bytes() == (tmp_path / "two" / frame).read_bytes()


def test_a_shorter_run_leaves_no_older_frames(box: dict[str, Any], folder: Path) -> None:
    (folder / "notes.h5").touch()
    perimpm.Simulation(box).run(frames=2, output=folder)
    assert sorted(f.name for f in folder.glob("frame.*")) == ["frame.0001.h5", "frame.0002.h5"]
    assert (folder / "run.xdmf").read_text().count("<Time") == 2
    assert (folder / "notes.h5").exists()


def test_a_continued_run_keeps_its_frames(box: dict[str, Any], tmp_path: Path) -> None:
    sim = perimpm.Simulation(box)
    sim.run(frames=2, output=tmp_path)
    sim.run(frames=4, output=tmp_path)
    assert (tmp_path / "run.xdmf").read_text().count("<Time") == 4
    assert len((tmp_path / "energy.csv").read_text().splitlines()) == 5


def test_a_folder_that_cannot_be_made(box: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(perimpm.InputError, match="cannot use the output folder"):
        perimpm.Simulation(box).run(output=tmp_path / "file" / "out")


def test_nothing_is_written_without_a_folder(box: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    perimpm.Simulation(box).run(frames=2)
    assert not list(tmp_path.iterdir())
