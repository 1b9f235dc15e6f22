"""The plan of a scene as text."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from . import _core
from .simulation import SceneLike, Simulation
from .tables import table, to_text


def explain(scene: SceneLike | Simulation, overrides: Sequence[str] = ()) -> str:
    """Passes, fields, bytes, libraries, time-step bounds, effective moduli, and what was skipped and why."""
    simulation = scene if isinstance(scene, Simulation) else Simulation(scene, overrides)
    return plan_text(simulation.title, simulation.plan)


def _si(value: float, unit: str) -> str:
    return "-" if isnan(value) else f"{value:.5g} {unit}".rstrip()


def _bytes(count: float) -> str:
    for unit in ("B", "kB", "MB"):
        if count < 1000:
            return f"{count:.3g} {unit}" if unit != "B" else f"{count:.0f} B"
        count /= 1000
    return f"{count:.3g} GB"


def plan_text(title: str, plan: _core.Plan) -> str:
    """`plan` as a page of tables."""
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
            "materials, with the moduli as the law has them",
            ("name", "constitutive", "fracture", "particles", "bonds", "Young's modulus", "Poisson's ratio", "wave speed"),
            materials,
            numbers=("particles", "bonds", "Young's modulus", "Poisson's ratio", "wave speed"),
        ),
        table("passes of one step", ("pass", "when", "models", "reads", "writes"), passes),
        table("memory", ("array", "size", "bytes per particle"), arrays, numbers=("size", "bytes per particle")),
        table(
            f"time step: starts with {plan.dt:.4g} s; bounds",
            ("source", "dt [s]"),
            [(b.source, f"{b.dt:.4g}") for b in plan.bounds],
            numbers=("dt [s]",),
        ),
        table("libraries opened", ("name",), [(name,) for name in plan.libraries]),
        table("skipped", ("what", "why"), [(s.what, s.why) for s in plan.skipped]),
    )
