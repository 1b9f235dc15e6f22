"""`perimpm bench throughput`: the workloads are those of the peers, and the report holds what it promises."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import perimpm
from perimpm.cli import main
from perimpm.workloads import mpm_block, pd_cube


def test_block_lies_where_the_peers_have_it() -> None:
    work = mpm_block(5, "fixed_corotated", "apic", 2, "double")
    sim = perimpm.Simulation(work.scene)
    x = sim.particles["x"] * 128
    assert len(x) == 8 * 5**3
    assert np.allclose(x.min(axis=0), [62.25, 4.25, 62.25])  # lower corner cell (64 - 2, 4, 64 - 2)
    assert np.allclose(x.max(axis=0), [66.75, 8.75, 66.75])
    assert np.allclose(sim.particles["mass"], 1000.0 / 256**3)


def test_cube_lies_on_whole_spacings() -> None:
    work = pd_cube(8, "pd_bond", "particle", "double")
    sim = perimpm.Simulation(work.scene)
    work.start(sim)
    x, v = sim.particles["x"], sim.particles["v"]
    assert np.allclose(x / 1e-3, np.rint(x / 1e-3), atol=1e-9)
    assert np.allclose(v[:, 0], -5 + 10 * x[:, 0] / 8e-3)
    n, steps = np.arange(8), np.arange(-3, 4)
    offsets = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3)
    squared = (offsets**2).sum(axis=1)
    inside = offsets[(squared > 0) & (squared <= 3.015**2)]
    assert len(inside) == 122
    assert sim.plan.materials[0].bonds == int(np.prod(len(n) - np.abs(inside), axis=1).sum())


@pytest.mark.parametrize("workload", ["mpm-block", "pd-cube"])
def test_report(workload: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "speed.json"
    words = ["bench", "throughput", "--workload", workload, "--side", "6", "--steps", "2", "--reps", "3"]
    assert main([*words, "--threads", "1", "--json", str(file)]) == 0
    report = json.loads(file.read_text())
    ours = report["results"][0]
    assert len(ours["seconds_per_step"]) == 3
    assert ours["ns_per_particle_step"] == pytest.approx(1e9 * np.median(ours["seconds_per_step"]) / ours["particles"])
    assert (ours["ns_per_bond"] is not None) == (workload == "pd-cube")
    assert "time per pass" in capsys.readouterr().out


def test_missing_peer_is_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["bench", "throughput", "--side", "4", "--steps", "1", "--reps", "1", "--peers"]) == 0
    assert "peer missing: taichi" in capsys.readouterr().out
