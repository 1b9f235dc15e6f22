"""Files of a run: frames, run.xdmf, energy.csv, run.json."""

from __future__ import annotations

import json
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
    assert rows.dtype.names == ("time", "kinetic", "elastic", "potential", "total", "px", "py", "pz", "lx", "ly", "lz")
    mass = 1000.0 * 0.6**3
    assert rows["kinetic"][0] == pytest.approx(0.5 * mass, rel=1e-5)
    assert rows["px"] == pytest.approx(mass, rel=1e-5)
    assert rows["py"] == pytest.approx(-mass * 9.81 * rows["time"], rel=1e-4, abs=1e-4)
    assert rows["total"] == pytest.approx(rows["kinetic"] + rows["elastic"] + rows["potential"])


def test_run_json(folder: Path) -> None:
    record = json.loads((folder / "run.json").read_text())
    assert record["status"] == "done" and record["frames"] == 3
    assert record["perimpm"] == perimpm.__version__
    assert record["particles"] == 1728 and record["precision"] == "float"
    assert record["scene"]["material"]["rubber"]["density"] == 1000.0
    times = {p["name"]: p for p in record["passes"]}["gather"]
    assert times["ns_per_particle_step"] == pytest.approx(1e9 * times["seconds"] / (1728 * record["steps"]))


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
