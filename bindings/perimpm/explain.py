"""The plan of a scene as text."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf, isnan

from . import _core
from .simulation import SceneLike, Simulation
from .tables import table, to_text


def explain(scene: SceneLike | Simulation, overrides: Sequence[str] = ()) -> str:
    """Passes, fields, bytes, libraries, time-step bounds, effective moduli, and what was skipped and why."""
    simulation = scene if isinstance(scene, Simulation) else Simulation(scene, overrides)
    return plan_text(simulation.title, simulation.plan, simulation.measure_stiffness())


def _si(value: float, unit: str) -> str:
    return "-" if isnan(value) else f"{value:.5g} {unit}".rstrip()


def _bytes(count: float) -> str:
    for unit in ("B", "kB", "MB"):
        if count < 1000:
            return f"{count:.3g} {unit}" if unit != "B" else f"{count:.0f} B"
        count /= 1000
    return f"{count:.3g} GB"


def _off(value: float, asked: float) -> str:
    """`value` against `asked` in per cent."""
    if isnan(value / asked):
        return "-"
    return "unstable" if isinf(value) else f"{round(100 * (value / asked - 1), 2) + 0.0:+.2f} %"


def _span(of: _core.FamilyStiffness, asked: float) -> str:
    return "-" if isnan(of.softest) else f"{_off(of.softest, asked)} to {_off(of.stiffest, asked)}"


def _stiffness_rows(measured: Sequence[_core.MeasuredStiffness]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for s in measured:
        asked = s.youngs_modulus
        count = f"{s.bulk_particles} of {s.bulk_particles + s.surface_particles}"
        at = " at ({:.4g}, {:.4g}, {:.4g}) m".format(*s.worst_position) if s.surface_particles else ""
        rows.append(
            (
                s.material,
                ("strand", "sheet", "solid")[s.dimension - 1],
                count,
                _off(s.bulk.youngs_modulus, asked),
                _si(s.bulk.poisson_ratio, "") if s.dimension > 1 else "-",
                _span(s.bulk, asked),
                _si(s.wave_speed, "m/s"),
                _span(s.worst, asked) + at,
                "-" if isnan(s.bulk.softest) and isnan(s.worst.softest) else str(s.unstable_particles),
            )
        )
    return rows


def plan_text(title: str, plan: _core.Plan, measured: Sequence[_core.MeasuredStiffness]) -> str:
    """`plan` and the measured stiffness as a page of tables."""
    per_particle = 1.0 / max(plan.particles, 1)
    total = sum(array.bytes for array in plan.arrays)
    arrays = [(a.name, _bytes(a.bytes), f"{a.bytes * per_particle:.1f}") for a in plan.arrays]
    arrays.append(("all", _bytes(total), f"{total * per_particle:.1f}"))
    materials = [
        (
            m.name,
            m.law,
            m.criterion or "-",
            str(m.particles),
            str(m.bonds),
            _si(m.youngs_modulus, "Pa"),
            _si(m.poisson_ratio, ""),
            _si(m.wave_speed, "m/s"),
        )
        for m in plan.materials
    ]
    passes = [(p.name, p.when, p.models, " ".join(p.reads), " ".join(p.writes)) for p in plan.passes]
    return to_text(
        f"{title or 'untitled scene'}: {plan.particles} particles",
        "",
        table(
            "materials, with the moduli asked for and the largest wave speed now",
            ("name", "constitutive", "fracture", "particles", "bonds", "Young's modulus", "Poisson's ratio", "wave speed"),
            materials,
            numbers=("particles", "bonds", "Young's modulus", "Poisson's ratio", "wave speed"),
        ),
        table(
            "stiffness that the particles have at small strain: Young's modulus against the one asked for",
            (
                "material",
                "bodies",
                "bulk particles",
                "in the bulk",
                "Poisson's ratio",
                "by direction",
                "wave speed",
                "worst surface particle, by direction",
                "unstable",
            ),
            _stiffness_rows(measured),
            numbers=("in the bulk", "Poisson's ratio", "wave speed", "unstable"),
        ),
        table("passes of one step", ("pass", "when", "models", "reads", "writes"), passes),
        table("memory", ("array", "size", "bytes per particle"), arrays, numbers=("size", "bytes per particle")),
        table(
            f"time step: starts with {plan.dt:.4g} s, {plan.steps:.3g} steps to the end; bounds",
            ("source", "dt [s]"),
            [(b.source, f"{b.dt:.4g}") for b in plan.bounds],
            numbers=("dt [s]",),
        ),
        table("libraries opened", ("name",), [(name,) for name in plan.libraries]),
        table("skipped", ("what", "why"), [(s.what, s.why) for s in plan.skipped]),
    )
