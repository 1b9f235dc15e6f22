"""The command: verbs, exit codes, messages."""

from __future__ import annotations

from pathlib import Path

import pytest

from perimpm.cli import main


@pytest.fixture
def scene(scene_file: Path) -> str:
    return str(scene_file)


def test_run(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", scene, "-o", str(tmp_path / "out"), "--frames", "2", "--threads", "1"]) == 0
    shown = capsys.readouterr()
    assert (tmp_path / "out" / "frame.0002.h5").exists()
    assert "ns per particle-step" in shown.out and str(tmp_path / "out") in shown.out
    assert "frame 2/2" in shown.err and "substeps/s" in shown.err and "ETA" in shown.err


def test_fewer_than_no_threads(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", scene, "-o", str(tmp_path / "out"), "--threads", "-3"]) == 2
    assert "threads: -3: expected 1 or more worker threads, or 0 for every core" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_run_puts_frames_under_out_by_default(scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", scene, "--frames", "1"]) == 0
    assert (tmp_path / "out" / "box" / "frame.0001.h5").exists()


def test_explain_after_a_swap(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    law = '{ type = "pd_elastic", youngs_modulus = 1e5, horizon = 2.01 }'
    assert main(["explain", scene, "--set", f"material.rubber.constitutive={law}"]) == 0
    shown = capsys.readouterr().out
    assert "constitutive/pd_elastic" in shown and "bonds" in shown and "fixed_corotated" not in shown
    assert main(["explain", scene]) == 0
    shown = capsys.readouterr().out
    for word in ("passes of one step", "bytes per particle", "libraries opened", "bounds", "wave speed", "skipped"):
        assert word in shown


def test_explain_tells_how_far_off_the_families_are(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", scene]) == 0
    exact = capsys.readouterr().out.partition("stiffness that the particles have")[2].partition("passes of one step")[0]
    assert "1728 of 1728" in exact and "+0.00 % to +0.00 %" in exact
    law = '{ type = "pd_elastic", youngs_modulus = 1e5, horizon = 2.01 }'
    assert main(["explain", scene, "--set", f"material.rubber.constitutive={law}"]) == 0
    shown = capsys.readouterr().out.partition("stiffness that the particles have")[2].partition("passes of one step")[0]
    assert "64 of 1728" in shown  # 4 of 12 along each edge are two horizons deep
    assert "+0.00 %" in shown and "0.25" in shown and "at (" in shown


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("simulation.end_tim=1", "end_time"),
        ('simulation.end_time="long"', "simulation.end_time"),
        ("simulation.end_time=-1", "end_time"),
        ('transfer.type="apci"', "apic"),
        ('material.rubber.constitutive={ type = "fixed_corotatd" }', "fixed_corotated"),
        ('body.0.shape={ type = "mesh", file = "nowhere.obj" }', "nowhere.obj"),
        ("body.0.shape.max=[9.0, 9.0, 9.0]", "domain"),
        ("body.0.initial_velocity=[nan, 0.0, 0.0]", "initial_velocity"),
        ("simulation.dt=1.0", "allow_unstable_dt"),
        ("simulation.end_time=1 2", "1 2"),
    ],
)
def test_bad_input_exits_with_2_and_writes_nothing(
    scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], change: str, words: str
) -> None:
    assert main(["run", scene, "-o", str(tmp_path / "out"), "--set", change]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_missing_scene_exits_with_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(tmp_path / "nowhere.toml")]) == 2
    assert "nowhere.toml" in capsys.readouterr().err


def test_failed_simulation_exits_with_3(scene: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    unstable = ["--set", "simulation.dt=0.04", "--set", "simulation.allow_unstable_dt=true"]
    hard = ["--set", "material.rubber.constitutive.youngs_modulus=1e9", "--set", "simulation.end_time=20.0"]
    fast = ["--set", "body.0.initial_velocity=[5.0, 3.0, 2.0]"]
    assert main(["run", scene, "-o", str(tmp_path), *unstable, *hard, *fast]) == 3
    assert "simulation failed" in capsys.readouterr().err
    assert (tmp_path / "failed.h5").exists()


def test_plugins_and_describe(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plugins"]) == 0
    listed = capsys.readouterr().out
    assert "critical_stretch" in listed
    assert "affine particle-in-cell" in listed
    assert main(["describe", "pd_elastic"]) == 0
    assert "horizon" in capsys.readouterr().out
    assert main(["describe", "scene"]) == 0
    assert "frame_rate" in capsys.readouterr().out
    assert main(["describe", "pd_elastik"]) == 2
    assert "pd_elastic" in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["fly"], ["run"], ["render", "x", "--size", "big"], ["run", "x", "--frames", "0"]])
def test_usage_errors_exit_with_2(words: list[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
