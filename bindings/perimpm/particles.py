"""Particle fields as NumPy arrays."""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core


class PositionWatch:
    """Knows whether somebody may have written positions through a view."""

    def __init__(self) -> None:
        self._views: list[weakref.ref[npt.NDArray[Any]]] = []

    def add(self, view: npt.NDArray[Any]) -> None:
        self._views.append(weakref.ref(view))

    def tell(self, simulation: _core.Simulation) -> None:
        """Before a step: marks the sort as stale when a view was given out and forgets the views that are gone."""
        if self._views:
            simulation.positions_changed()
            self._views = [view for view in self._views if view() is not None]


class Particles(Mapping[str, npt.NDArray[Any]]):
    """Fields of all particles, or of one material, by name.

    ``particles["x"]`` is a view without copying: shape (n, 3) for vectors, (n, 3, 3) for tensors, (n,) for the rest,
    in SI units. Writing into it changes the simulation. A view shows the present particles until `generation`
    changes; then ask for it again, since the slots have been re-sorted. ``by_id`` gives copies in a fixed order.
    """

    def __init__(self, simulation: _core.Simulation, watch: PositionWatch, material: str = "") -> None:
        self._simulation = simulation
        self._watch = watch
        self._material = material

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """View of one field. Raises KeyError, with the closest name, for an unknown one."""
        try:
            view = _core.view(self._simulation, name, self._material)
        except _core.InputError as error:
            raise KeyError(str(error)) from None
        if name == "x":
            self._watch.add(view)
        return view

    def __iter__(self) -> Iterator[str]:
        return iter(_core.fields(self._simulation, self._material))

    def __len__(self) -> int:
        return len(_core.fields(self._simulation, self._material))

    def unit(self, name: str) -> str:
        """SI unit of a field, "1" for pure numbers."""
        return _core.field_unit(self._simulation, name, self._material)

    def of(self, material: str) -> Particles:
        """The fields of one material's particles, its history fields among them."""
        _core.fields(self._simulation, material)  # an unknown material is an error here, not at the first use
        return Particles(self._simulation, self._watch, material)

    def by_id(self, name: str) -> npt.NDArray[Any]:
        """Copy of a field in the order of particle ids, which no re-sort changes."""
        return self[name][np.argsort(self["id"], kind="stable")]

    @property
    def generation(self) -> int:
        """Number of re-sorts so far."""
        return self._simulation.generation

    def __repr__(self) -> str:
        return f"<Particles: {', '.join(self)}>"
