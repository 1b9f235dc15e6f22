"""Laws written in Python: found, checked and run like compiled ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from trees import LOCAL, Tree, box, scene

import perimpm
from perimpm.cli import main

EXAMPLE = Path(__file__).parent.parent / "out_of_tree/python"
SVK: Tree = {"type": "saint_venant_kirchhoff", "youngs_modulus": 1e5}
LAMBDA, MU = 4e4, 4e4  # Pa, of E = 1e5 Pa and nu = 0.25
BODY = box([0.0] * 3, [0.5] * 3)


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(EXAMPLE))


def test_is_found_like_any_plugin(example: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert "saint_venant_kirchhoff" in perimpm.plugins()["constitutive"]
    assert main(["plugins"]) == 0
    assert "Saint Venant-Kirchhoff elasticity in Python" in capsys.readouterr().out
    assert main(["describe", "saint_venant_kirchhoff"]) == 0
    page = capsys.readouterr().out
    assert all(text in page for text in ("youngs_modulus", "> 0", "Pa", "required", "[0, 0.5)", "0.25"))


@pytest.mark.parametrize("precision", ["float", "double"])
def test_closed_forms(example: None, precision: str) -> None:
    """F = 1.2: E = 0.22, W = (lambda/2 9 + mu 3) E^2; the wave speed at rest."""
    sim = perimpm.Simulation(scene(SVK, BODY, 0.05, precision=precision))
    volume, digits = 0.125, 1e-12 if precision == "double" else 1e-5
    assert sim.plan.materials[0].wave_speed == pytest.approx(np.sqrt((LAMBDA + 2 * MU) / 1000), rel=digits)
    sim.particles["F"][:] = 1.2 * np.eye(3)
    assert sim.ledger.elastic == pytest.approx(volume * (4.5 * LAMBDA + 3 * MU) * 0.22**2, rel=digits)


def test_small_strains_as_every_elastic_law(example: None) -> None:
    """A block released from a strain of 1e-6 moves as that of fixed_corotated, to the second order of the strain."""
    paths = []
    for law in (SVK, LOCAL):
        sim = perimpm.Simulation(scene(law, BODY, 0.05, dt=1e-3))
        sim.particles["x"][:] *= 1 + 1e-6
        sim.particles["F"][:] = (1 + 1e-6) * np.eye(3)
        start = sim.particles.by_id("x").copy()
        sim.step(40)
        paths.append(sim.particles.by_id("x") - start)
    assert np.abs(paths[0] - paths[1]).max() <= 1e-5 * np.abs(paths[1]).max()


NEO_HOOKEAN = """
import numpy as np
import perimpm

class NeoHookean(perimpm.Law):
    \"\"\"compressible Neo-Hookean elasticity\"\"\"
    parameters = [perimpm.Parameter("lam"), perimpm.Parameter("mu")]
    def __init__(self, parameters, density):
        self.lam, self.mu = parameters["lam"], parameters["mu"]
    def stress(self, F):
        pressure = self.lam * np.log(np.linalg.det(F)) - self.mu
        return self.mu * F @ F.swapaxes(1, 2) + pressure[:, None, None] * np.eye(3)
    def wave_speed(self, F):
        return 1.0
"""


def test_moves_as_the_compiled_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block with strains of a tenth, fifty steps."""
    (tmp_path / "python_neo_hookean.py").write_text(NEO_HOOKEAN)
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(tmp_path))
    paths = []
    for law in ({"type": "python_neo_hookean", "lam": LAMBDA, "mu": MU}, {"type": "neo_hookean", "youngs_modulus": 1e5}):
        sim = perimpm.Simulation(scene(law, BODY, 0.05, dt=1e-3))
        sim.particles["F"][:] += 0.1 * np.random.default_rng(1).standard_normal(sim.particles["F"].shape)
        start = sim.particles.by_id("x").copy()
        sim.step(50)
        paths.append(sim.particles.by_id("x") - start)
    assert np.abs(paths[0] - paths[1]).max() <= 1e-11 * np.abs(paths[1]).max()


def test_same_bits_for_any_number_of_threads(example: None) -> None:
    states = []
    for threads in (1, 2):
        sim = perimpm.Simulation(scene(SVK, BODY, 0.02), threads=threads)  # many blocks
        sim.particles["v"][:] = np.random.default_rng(1).standard_normal(sim.particles["v"].shape)
        sim.step(20)
        states.append((sim.particles.by_id("x").copy(), sim.ledger.elastic))
    assert np.array_equal(states[0][0], states[1][0])
    assert states[0][1] == states[1][1]


def test_law_of_pd_correspondence(example: None) -> None:
    sim = perimpm.Simulation(scene({"type": "pd_correspondence", "law": SVK}, BODY, 0.1))
    sim.particles["v"][:] = sim.particles["x"] - 0.25
    before = sim.ledger.kinetic
    sim.step(5)
    assert 0 < sim.ledger.elastic < before


def test_scene_errors_are_those_of_any_law(example: None) -> None:
    with pytest.raises(perimpm.InputError, match="must be above 0 Pa, got -1"):
        perimpm.Simulation(scene(SVK | {"youngs_modulus": -1.0}, BODY, 0.1))
    with pytest.raises(perimpm.InputError, match=r"did you mean 'poisson_ratio'"):
        perimpm.Simulation(scene(SVK | {"poison_ratio": 0.1}, BODY, 0.1))


GOOD = """
import numpy as np
import perimpm

class Rubber(perimpm.Law):
    \"\"\"rubber\"\"\"
    parameters = [perimpm.Parameter("mu", unit="Pa", default=1e4)]
    def __init__(self, parameters, density):
        self.mu = parameters["mu"]
    def stress(self, F):
        return self.mu * (F @ F.swapaxes(1, 2) - np.eye(3))
    def wave_speed(self, F):
        return 10.0
"""
WRONG = {
    "syntax": ("return 10.0", "return 10.0)", ["line 13", "SyntaxError"]),
    "import": ("import numpy as np", "import numpyy as np", ["line 2", "numpyy"]),
    "no class": ("class Rubber(perimpm.Law)", "class Rubber", ["one class derived from perimpm.Law", "none"]),
    "two classes": ("class Rubber", "class Other(perimpm.Law):\n    pass\n\nclass Rubber", ["Other, Rubber"]),
    "no summary": ('    """rubber"""\n', "", ["Rubber", "docstring"]),
    "no stress": ("def stress", "def strain", ["lacks the method 'stress(self, F)'"]),
    "no parameter": ('perimpm.Parameter("mu", unit="Pa", default=1e4)', '"mu"', ["perimpm.Parameter objects", "'mu'"]),
    "twice": ("parameters = [", 'parameters = [perimpm.Parameter("mu"), ', ["'mu' twice"]),
    "two bounds": ('unit="Pa"', "above=0, at_least=0", ["line 7", "'mu'", "'above' or 'at_least'"]),
    "no name": ('"mu", unit', '"shear modulus", unit', ["line 7", "'shear modulus'", "must be a name"]),
    "no number": ("default=1e4", 'default="1e4"', ["line 7", "'default' must be a number", "'1e4'"]),
    "no text": ('unit="Pa"', "unit=1", ["line 7", "'unit' must be a text"]),
    "default": ("default=1e4", "default=1e4, below=1", ["line 7", "10000", "outside of the range"]),
    "constructor": ('parameters["mu"]', 'parameters["nu"]', ["line 9", "KeyError", "nu"]),
    "modulus": ("self.mu = ", "self.youngs_modulus = 'stiff'; self.mu = ", ["ValueError", "stiff"]),
    "shape": ("np.eye(3))", "np.eye(3))[:, 0]", ["Rubber.stress", "(2, 3)", "(2, 3, 3)"]),
    "first Piola-Kirchhoff": ("F @ F.swapaxes(1, 2)", "F", ["Rubber.stress", "not symmetric", "P F^T"]),
    "speed": ("return 10.0", "return 0.0", ["Rubber.wave_speed", "above 0"]),
    "energy": ("    def wave_speed", "    def energy(self, F):\n        return 0.0\n    def wave_speed", ["Rubber.energy", "(2,)"]),
}


def place(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch, law: str) -> Tree:
    """The law in a file of that name, directly in a folder of PERIMPM_PLUGIN_PATH."""
    (folder / f"{law}.py").write_text(text)
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(folder))
    return scene({"type": law}, BODY, 0.1)


def test_without_energy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the ledger nothing but the elastic energy is unknown. A file outside of a family's folder is not listed."""
    sim = perimpm.Simulation(place(GOOD, tmp_path, monkeypatch, "rubber"))
    sim.step()
    assert np.isnan(sim.ledger.elastic)
    assert sim.ledger.kinetic == 0
    assert "rubber" not in perimpm.plugins()["constitutive"]


@pytest.mark.parametrize("name", WRONG)
def test_what_a_file_lacks(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Said before anything runs, with the file that is at fault."""
    good, bad, words = WRONG[name]
    assert good in GOOD
    law = f"rubber_{list(WRONG).index(name)}"  # laws stay open: every name once
    with pytest.raises(perimpm.InputError) as error:
        perimpm.Simulation(place(GOOD.replace(good, bad), tmp_path, monkeypatch, law))
    for word in (f"{law}.py", *words):
        assert word in str(error.value)


def test_refused_parameters_have_a_place_in_the_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refusal = 'raise perimpm.InvalidParameter("mu", "must be even")\n        self.mu'
    tree = place(GOOD.replace("self.mu", refusal, 1), tmp_path, monkeypatch, "even")
    with pytest.raises(perimpm.InputError, match=r"material\.m\.constitutive.*'mu'.*must be even"):
        perimpm.Simulation(tree)


def test_laws_import_what_lies_beside_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "constitutive").mkdir()
    (tmp_path / "constitutive/_speeds.py").write_text("SPEED = 10.0\n")
    text = GOOD.replace("import perimpm\n", "import perimpm\nfrom _speeds import SPEED\n")
    text = text.replace("return 10.0", "return SPEED")
    (tmp_path / "constitutive/imports.py").write_text(text)
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(tmp_path))
    assert perimpm.Simulation(scene({"type": "imports"}, BODY, 0.1)).plan.materials[0].wave_speed == 10.0
    assert "_speeds" not in perimpm.plugins()["constitutive"]


def test_what_a_method_raises_ends_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames stay whole, and what particles have is of one time."""
    limit = "        assert F.max() < 1.12, 'torn'\n        return self.mu *"
    tree = place(GOOD.replace("        return self.mu *", limit), tmp_path, monkeypatch, "torn")
    tree["simulation"]["dt"] = 1e-3
    del tree["output"]  # with frames
    sim = perimpm.Simulation(tree)
    sim.particles["v"][:] = 6 * sim.particles["x"]
    start, before = sim.particles["x"].copy(), sim.particles["v"].copy()
    with pytest.raises(AssertionError, match="torn"):
        sim.run(output=tmp_path / "out")
    assert sim.steps > 5
    assert (tmp_path / "out/frame.0001.h5").exists()
    assert "torn" in (tmp_path / "out/run.json").read_text()
    moved = sim.particles["x"] - start  # the block grows by an eighth and slows down meanwhile
    assert np.abs(moved).max() > 0.05
    assert 0 < np.abs(sim.particles["v"]).max() < 0.99 * np.abs(before).max()


def test_F_cannot_be_written_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = GOOD.replace("        return self.mu *", "        if len(F) > 2:\n            F[:] = 0\n        return self.mu *")
    sim = perimpm.Simulation(place(text, tmp_path, monkeypatch, "writes"))
    with pytest.raises(ValueError, match="read-only"):
        sim.step()


def test_two_files_of_one_name_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "constitutive").mkdir()
    (tmp_path / "constitutive/pd_bond.py").write_text(GOOD)
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(tmp_path))
    with pytest.raises(perimpm.InputError, match="two files claim"):
        perimpm.plugins()
