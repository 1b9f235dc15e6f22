"""Standing wave of large amplitude, exact for fixed-corotated without any body force (A3): the order of accuracy.

With free ends, where this law's stress vanishes at all times, instead of fixed ones. Fixed ends show what domain
faces do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support import Wave, fixed_slab, free_slab
from trees import Tree

COURANT = 0.1
QUADRATIC: Tree = {"type": "apic", "order": 2}
CUBIC: Tree = {"type": "apic", "order": 3}
Build = Callable[[Tree, int, float, float], Wave]


def worst_error(transfer: Tree, cells: int, amplitude: float, build: Build = free_slab) -> float:
    """Largest root mean square error of the positions in one period, over the amplitude."""
    wave = build(transfer, cells, amplitude, COURANT)
    start = wave.sim.particles.by_id("x")[:, 0]
    worst = 0.0
    for step in range(wave.steps):
        wave.sim.step()
        if step % 4:
            continue
        exact = amplitude * wave.shape * np.sin(np.pi * wave.speed * wave.sim.time)
        error = wave.sim.particles.by_id("x")[:, 0] - start - exact
        worst = max(worst, float(np.sqrt(np.mean(error**2))))
    return worst / amplitude


@pytest.mark.parametrize(("transfer", "reference"), [(QUADRATIC, 5.8e-3), (CUBIC, 7.1e-3)], ids=["quadratic", "cubic"])
def test_second_order_at_small_amplitude(transfer: Tree, reference: float) -> None:
    coarse, fine = (worst_error(transfer, cells, 1e-3) for cells in (16, 32))
    print(f"\ne/A {coarse:.2e} at 16 cells, {fine:.2e} at 32 (reference {reference:.1e})")
    assert np.log2(coarse / fine) >= 1.9
    assert fine == pytest.approx(reference, rel=0.05)


@pytest.mark.parametrize(("transfer", "gate"), [(QUADRATIC, 2e-2), (CUBIC, 1e-2)], ids=["quadratic", "cubic"])
def test_particles_that_cross_cells(transfer: Tree, gate: float) -> None:
    """Strains of +-31 %."""
    error = worst_error(transfer, 32, 0.1)
    print(f"\ne/A {error:.2e}")
    assert error <= gate


@pytest.mark.xfail(strict=True, reason="a face acts behind its plane, by a quarter to a third of a cell: first order")
def test_fixed_ends() -> None:
    coarse, fine = (worst_error(QUADRATIC, cells, 1e-3, fixed_slab) for cells in (16, 32))
    print(f"\ne/A {coarse:.2e} at 16 cells, {fine:.2e} at 32 (reference 2.3e-2, 5.8e-3)")
    assert np.log2(coarse / fine) >= 1.9
