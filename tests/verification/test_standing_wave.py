"""Standing wave of large amplitude, exact for fixed-corotated without any body force (A3): the order of accuracy.

Free ends are ends where this law's stress vanishes at all times; fixed ends are domain faces."""

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


@pytest.mark.parametrize(
    ("transfer", "small", "large"), [(QUADRATIC, 5.8e-3, 1.6e-2), (CUBIC, 7.1e-3, 8.4e-3)], ids=["quadratic", "cubic"]
)
def test_fixed_ends(transfer: Tree, small: float, large: float) -> None:
    """The reference's own case. A face acts in its plane: nodes behind it are images of those in front."""
    coarse, fine = (worst_error(transfer, cells, 1e-3, fixed_slab) for cells in (16, 32))
    crossing = worst_error(transfer, 32, 0.1, fixed_slab)
    print(f"\ne/A {coarse:.2e} at 16 cells, {fine:.2e} at 32 (reference {small:.1e}); at 31 % {crossing:.2e} ({large:.1e})")
    assert np.log2(coarse / fine) >= 1.9
    assert fine == pytest.approx(small, rel=0.05)
    assert crossing == pytest.approx(large, rel=0.05)


@pytest.mark.parametrize("transfer", [QUADRATIC, CUBIC], ids=["quadratic", "cubic"])
def test_slab_one_cell_thick(transfer: Tree) -> None:
    """Plane strain: two symmetry faces, one cell apart, are as good as a thick slab."""

    def thin(transfer: Tree, cells: int, amplitude: float, courant: float) -> Wave:
        return fixed_slab(transfer, cells, amplitude, courant, thickness=1, face="symmetry")

    thick_error, thin_error = (worst_error(transfer, 16, 0.1, build) for build in (fixed_slab, thin))
    assert thin_error == pytest.approx(thick_error, rel=1e-6)
