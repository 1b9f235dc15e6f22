"""Axial vibration of a clamped-free bar (METHOD section 6): 1.0 x 0.4 x 0.4 m, h = 0.05 m, dx = 2 h, nu = 1/4, first
mode.

Closed form of the slender bar: T = 4 L / sqrt(E / rho); lateral inertia (Rayleigh, Love) adds
nu^2 k^2 r^2 / 2 = 0.2 % with k = pi / 2 L and r^2 = 2 (0.4 m)^2 / 12. The clamp is a sticky domain face in the bar's
end plane, a mirror that reverses all motion; it also holds the end's lateral motion, so the bar is a little stiffer: -0.3 %
at 10 cells. (A sticky box over a clamped part acts about a third of a cell behind its plane: +2.7 % at 10 cells, +1.0 % at
20.) The bar of length 2 L without any clamp has the same first mode by symmetry: it shows what the law itself does.

The treatment of surfaces decides how near a bond law comes (weights.hpp): full-lattice weights leave it soft, weights
divided by the family's sum make small lattices stiff along their axes (E along [100] over its average over directions is
1.22 for horizon 2.01 and linear influence, 1.14 for 2.01 constant, 1.09 for 3.015 linear, 0.94 for 3.015 constant) and
stiffen the outer layer; moment-exact weights, the default, do neither. `jitter` places every particle at random in its
cell; a row is then the mean over three clouds. All bars of a scene take the same steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from support import Array
from trees import Tree, box, scene

import perimpm

LENGTH, WIDTH, SPACING = 1.0, 0.4, 0.05  # m
YOUNG, DENSITY = 1e6, 1000.0
SPEED = np.sqrt(YOUNG / DENSITY)
PERIOD = 4 * LENGTH / SPEED  # s
AMPLITUDE = 1e-3 * SPEED  # m/s: strains of 1e-3
WAVE_NUMBER = np.pi / (2 * LENGTH)

FIXED_COROTATED: Tree = {"type": "fixed_corotated", "youngs_modulus": YOUNG, "poisson_ratio": 0.25}
PD_ELASTIC: Tree = {"type": "pd_elastic", "youngs_modulus": YOUNG}
FAMILY: Tree = PD_ELASTIC | {"bending_ratio": 0.1, "surface": "family"}


@dataclass
class Vibration:
    """Of one bar: its period over the closed form and the amplitudes left after each half period."""

    period: float
    peaks: list[float]


def scene_of_bars(laws: list[Tree], clamped: bool, spacing: float, jitter: float, seed: int) -> Tree:
    """Bars side by side, far apart, from x = 0 (or from -L, without a clamp) to x = L."""
    start = 0.0 if clamped else -LENGTH
    names = [f"bar {k}" for k in range(len(laws))]
    shapes = [(name, box([start, 2 * k, 0], [LENGTH, 2 * k + WIDTH, WIDTH])) for k, name in enumerate(names)]
    tree = scene(dict(zip(names, laws)), shapes, spacing, density=DENSITY)
    for body in tree["body"]:
        body |= {"jitter": jitter, "seed": seed}
    if clamped:
        faces = {"min_x": "sticky"}
        tree["grid"]["domain"] = {"min": [0.0, -1.0, -1.0], "max": [2.0, 2.0 * len(laws), 2.0], "faces": faces}
    return tree


def vibration(times: Array, signal: Array) -> Vibration:
    """From the zeros of the modal velocity and its extremes after the start."""
    zero = np.flatnonzero(signal[1:] * signal[:-1] < 0)
    crossing = times[zero] - signal[zero] * (times[zero + 1] - times[zero]) / (signal[zero + 1] - signal[zero])
    pieces = np.split(np.abs(signal), zero + 1)
    return Vibration(float(2 * np.mean(np.diff(crossing)) / PERIOD), [float(piece.max()) for piece in pieces[1:-1]])


def vibrate(
    laws: dict[str, Tree],
    *,
    clamped: bool = True,
    half_periods: int = 4,
    spacing: float = SPACING,
    jitter: float = 0.0,
    seed: int = 1,
) -> dict[str, Vibration]:
    sim = perimpm.Simulation(scene_of_bars(list(laws.values()), clamped, spacing, jitter, seed), threads=1)
    x = sim.particles["x"]
    sim.particles["v"][:, 0] = AMPLITUDE * np.sin(WAVE_NUMBER * x[:, 0])
    sim.particles["C"][:, 0, 0] = AMPLITUDE * WAVE_NUMBER * np.cos(WAVE_NUMBER * x[:, 0])
    start = sim.particles.by_id("x")
    mode = np.sin(WAVE_NUMBER * start[:, 0])
    bars = [np.abs(start[:, 1] - 2 * k - WIDTH / 2) < WIDTH for k in range(len(laws))]

    def amplitudes() -> list[float]:
        v = sim.particles.by_id("v")[:, 0]
        return [float(v[bar] @ mode[bar] / (mode[bar] @ mode[bar])) / AMPLITUDE for bar in bars]

    times, signals = [sim.time], [amplitudes()]
    while sim.time < (half_periods / 2 + 0.5) * PERIOD:
        sim.step()
        times.append(sim.time)
        signals.append(amplitudes())
    columns = np.array(signals).T
    return {name: vibration(np.array(times), columns[k]) for k, name in enumerate(laws)}


def mean_of(clouds: list[Vibration]) -> Vibration:
    peaks = np.mean([cloud.peaks for cloud in clouds], axis=0)
    return Vibration(float(np.mean([cloud.period for cloud in clouds])), [float(peak) for peak in peaks])


def irregular(laws: dict[str, Tree], jitter: float, spacing: float, seeds: int) -> dict[str, Vibration]:
    clouds = [vibrate(laws, spacing=spacing, jitter=jitter, seed=1 + k) for k in range(seeds if jitter else 1)]
    return {name: mean_of([cloud[name] for cloud in clouds]) for name in laws}


def report(name: str, seen: Vibration) -> None:
    print(f"{name:44} {seen.period:.3f}  " + " ".join(f"{peak:.3f}" for peak in seen.peaks))


def test_two_laws_in_one_scene() -> None:
    """Moment-exact weights (the default) and family weights; those need a long horizon of constant influence to come this
    near: see `test_table_of_families`."""
    long_family = FAMILY | {"horizon": 3.015, "influence": "constant"}
    seen = vibrate({"local": FIXED_COROTATED, "bonds": PD_ELASTIC, "family": long_family}, half_periods=6)
    print("\nclamped, law, period / closed form, amplitude after each half period")
    for name, one in seen.items():
        report(name, one)
    assert seen["local"].period == pytest.approx(1, abs=0.05)
    for name in ("bonds", "family"):
        assert seen[name].period == pytest.approx(1, abs=0.05)
        assert seen[name].period == pytest.approx(seen["local"].period, rel=0.05)
    for one in seen.values():
        assert 0.8 < one.peaks[3] < one.peaks[2] < one.peaks[1] < one.peaks[0] <= 1


def test_without_a_clamp_the_local_law_is_exact() -> None:
    seen = vibrate({"local": FIXED_COROTATED}, clamped=False)["local"]
    print()
    report("free, 2 L, fixed_corotated", seen)
    assert seen.period == pytest.approx(1.002, abs=0.01)
    assert min(seen.peaks) > 0.98


# As near to the closed form as the local law.
CORRESPONDENCE: Tree = {"type": "pd_correspondence", "law": FIXED_COROTATED}
DEFAULTS: dict[str, Tree] = {
    "pd_elastic": PD_ELASTIC,
    "pd_lps": {"type": "pd_lps", "youngs_modulus": YOUNG},
    "pd_correspondence": CORRESPONDENCE,
    "pd_correspondence grid": CORRESPONDENCE | {"divergence": "grid"},
}
OTHERS: dict[str, Tree] = {"pd_bond": {"type": "pd_bond", "youngs_modulus": YOUNG}}


def check_against_local(jitter: float, spacing: float, seeds: int) -> None:
    seen = irregular({"fixed_corotated": FIXED_COROTATED} | DEFAULTS | OTHERS, jitter, spacing, seeds)
    print(f"\nclamped, h = {spacing} m, jitter {jitter} h")
    for name, one in seen.items():
        report(name, one)
    local = seen["fixed_corotated"]
    for name in DEFAULTS:
        assert abs(seen[name].period - 1) <= max(1.25 * abs(local.period - 1), 0.01), name
        assert 1 - seen[name].peaks[3] <= 1.5 * (1 - local.peaks[3]), name
    for name in OTHERS:  # no influence function: half way to 0.5 h a little more loss, as measured
        assert abs(seen[name].period - 1) <= 0.015, name
        assert 1 - seen[name].peaks[3] <= (1.6 if jitter == 0.25 else 1.5) * (1 - local.peaks[3]), name


@pytest.mark.parametrize("jitter", [0.0, 0.25, 0.5])
def test_defaults_reach_the_local_law(jitter: float) -> None:
    check_against_local(jitter, SPACING, seeds=3)


@pytest.mark.slow
@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_defaults_reach_the_local_law_at_half_the_spacing(jitter: float) -> None:
    check_against_local(jitter, SPACING / 2, seeds=1)


@pytest.mark.slow
@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_table_of_surfaces(jitter: float) -> None:
    """What surface treatment, horizon and influence do to period and amplitude."""
    laws = {
        f"{law.removeprefix('pd_')} {horizon} {influence} {surface}": {
            "type": law,
            "youngs_modulus": YOUNG,
            "horizon": horizon,
            "influence": influence,
            "surface": surface,
        }
        for law in ("pd_elastic", "pd_lps")
        for surface in ("none", "family", "moment", "ghost")
        for horizon, influence in ((2.01, "constant"), (2.2, "linear"), (2.5, "linear"), (3.015, "constant"))
    }
    seen = irregular({"fixed_corotated": FIXED_COROTATED} | laws, jitter, SPACING, seeds=1)
    print(f"\nclamped, jitter {jitter} h: law, horizon, influence, surface; period / closed form, amplitudes")
    for name, one in seen.items():
        report(name, one)
    for law in ("elastic", "lps"):  # whatever the horizon, moment-exact weights bring the period nearest
        for family in ("2.01 constant", "2.2 linear", "2.5 linear"):
            error = {surface: abs(seen[f"{law} {family} {surface}"].period - 1) for surface in ("none", "family", "moment")}
            assert error["moment"] < 0.02 and error["moment"] <= min(error.values())


@pytest.mark.slow
def test_table_of_families() -> None:
    """What horizon, influence and bending ratio do to period and amplitude with weights divided by the family's sum,
    clamped and free."""
    laws = {
        f"{horizon} {influence} {ratio:g}": FAMILY
        | {"horizon": horizon, "influence": influence, "bending_ratio": ratio}
        for horizon in (2.01, 3.015)
        for influence in ("linear", "constant")
        for ratio in (0.0, 1.0)
    }
    table = {}
    for clamped in (True, False):
        table[clamped] = vibrate({"fixed_corotated": FIXED_COROTATED, **laws}, clamped=clamped)
        print(f"\n{'clamped' if clamped else 'free'}: horizon influence mu/lambda, period / closed form, amplitudes")
        for name, seen in table[clamped].items():
            report(name, seen)
    best = min(laws, key=lambda name: abs(table[True][name].period - 1))
    assert best.startswith("3.015 constant")
    # the free bar of linear weights is as much too fast as its lattice is stiff along its axes, and more by its surface
    assert table[False]["2.01 linear 0"].period < 1.2199**-0.5
    assert table[False]["3.015 linear 0"].period < 1.0926**-0.5
