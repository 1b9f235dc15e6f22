"""Running and stepping."""

from __future__ import annotations

import json
import os
import re
import signal
import threading
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trees
from trees import LOCAL, scene

import perimpm


def test_free_fall(box: dict[str, Any]) -> None:
    box["simulation"]["precision"] = "double"
    sim = perimpm.Simulation(box)
    sim.step(5)
    assert sim.steps == 5
    mass = 1000.0 * 0.6**3
    assert sim.ledger.momentum[1] == pytest.approx(-mass * 9.81 * sim.time, rel=1e-12)
    assert sim.ledger.momentum[0] == pytest.approx(mass, rel=1e-12)


def test_run_reaches_frame_times_exactly(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    sim.run(frames=2)
    assert sim.time == pytest.approx(1 / 24, rel=1e-12)
    sim.run(frames=3)
    assert sim.time == pytest.approx(2 / 24, rel=1e-12)
    sim.run()
    assert sim.time == pytest.approx(0.1, rel=1e-12)


def test_split_run_equals_whole_run(box: dict[str, Any]) -> None:
    whole, split = perimpm.Simulation(box), perimpm.Simulation(box)
    whole.run(frames=3)
    split.run(frames=2)
    split.run(frames=3)
    assert whole.steps == split.steps
    assert np.array_equal(whole.particles.by_id("x"), split.particles.by_id("x"))


def test_no_frames_is_an_error(box: dict[str, Any]) -> None:
    with pytest.raises(perimpm.InputError, match="frames = 0"):
        perimpm.Simulation(box).run(frames=0)


def test_other_threads_go_on(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    turns = 0
    done = threading.Event()

    def spin() -> None:
        nonlocal turns
        while not done.is_set():
            turns += 1
            time.sleep(0)

    thread = threading.Thread(target=spin)
    thread.start()
    before = turns
    sim.step(100)
    during = turns - before
    done.set()
    thread.join()
    assert during > 20  # one or two if `step` kept the interpreter lock


def test_a_second_thread_is_refused(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    running = threading.Thread(target=sim.step, args=(300,))
    running.start()
    refused = False
    while running.is_alive() and not refused:
        try:
            sim.ledger
        except RuntimeError as error:
            refused = "another thread" in str(error)
    running.join()
    assert refused
    assert sim.steps == 300


def test_ctrl_c_stops_after_a_step_with_whole_files(box: dict[str, Any], tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    sim = perimpm.Simulation(box, ["simulation.end_time=1000.0"])
    threading.Timer(0.7, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        sim.run(output=tmp_path)
    assert json.loads((tmp_path / "run.json").read_text())["status"] == "stopped"
    assert not list(tmp_path.glob("*.part"))
    frames = sorted(tmp_path.glob("frame.*.h5"))
    assert frames
    for path in frames:
        with h5py.File(path) as frame:
            assert np.isfinite(frame["x"][:]).all() and len(frame["x"]) == len(sim.particles["x"])
    steps = sim.steps
    sim.step()
    assert sim.steps == steps + 1


def test_failure_dumps_the_state(box: dict[str, Any], tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    sim = perimpm.Simulation(box)
    sim.particles["v"][7, 0] = np.nan
    with pytest.raises(perimpm.SimulationError):
        sim.run(output=tmp_path)
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["status"] == "failed" and record["error"]
    with h5py.File(tmp_path / "failed.h5") as file:
        assert {"x", "v", "C", "mass"} <= set(file)


def test_pass_times(box: dict[str, Any]) -> None:
    sim = perimpm.Simulation(box)
    sim.step(3)
    calls = {p.name: p.calls for p in sim.pass_times}
    assert calls["gather"] + calls.get("gather, stress and scatter", 0) == 3
    assert all(p.seconds >= 0 for p in sim.pass_times)
    times = sim.pass_times[0]
    assert repr(times) == f"<PassTime {times.name}: {times.calls} calls, {times.seconds:.3g} s>"
    ledger = sim.ledger
    sums = f"kinetic {ledger.kinetic:.4g} J, elastic {ledger.elastic:.4g} J, potential {ledger.potential:.4g} J"
    assert repr(ledger) == f"<Ledger at {ledger.time:.4g} s: {sums}>"


def test_fragments_and_relaxations_show_what_they_hold(bonded: dict[str, Any]) -> None:
    foot = {"type": "plane", "point": [0.0, 0.7, 0.0], "normal": [0.0, 1.0, 0.0]}
    bonded["condition"] = [{"shape": foot, "clamped": True}]
    sim = perimpm.Simulation(bonded)
    (piece,) = sim.fragments
    assert repr(piece) == f"<Fragment 0: 1728 particles, 216 kg, at ({piece.center[0]:.4g}, 0.8, {piece.center[2]:.4g}) m>"
    found = sim.relax(residual=1e-2)
    assert repr(found) == f"<Relaxation: {found.steps} steps, residual {found.residual:.3g}>"


def test_very_many_steps_are_announced(box: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("perimpm.simulation._SELDOM_MEANT", 3)
    with pytest.warns(UserWarning, match=r"e\+01 steps of .* s to the scene's end: .* SI units"):
        perimpm.Simulation(box).run()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        perimpm.Simulation(box).run(frames=2)


def test_an_end_between_two_frames_is_announced(box: dict[str, Any], tmp_path: Path) -> None:
    box["simulation"].update(end_time=0.02, frame_rate=60.0)
    with pytest.warns(UserWarning, match="the last one, 2, shows t = 0.0166667 s") as warned:
        perimpm.Simulation(box).run(output=tmp_path)
    assert len(list(tmp_path.glob("frame.*.h5"))) == 2
    found = re.search("fall on: (.*) and (.*) s;", str(warned[0].message))
    assert found and float(found[1]) == 1 / 60
    box["simulation"]["end_time"] = float(found[2])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        perimpm.Simulation(box).run(output=tmp_path)
        perimpm.Simulation(box).run()  # writes nothing, loses nothing
    assert len(list(tmp_path.glob("frame.*.h5"))) == 3


@pytest.mark.parametrize("wish", [{"residual": -1.0}, {"residual": float("nan")}, {"max_steps": 0}, {"max_steps": 1.5}])
def test_relax_refuses_what_cannot_end(wish: dict[str, float]) -> None:
    sim = perimpm.Simulation(scene(LOCAL, trees.box([0.0] * 3, [0.2] * 3), 0.05))
    with pytest.raises(perimpm.InputError, match="expected a"):
        sim.relax(**wish)
    assert sim.steps == 0
