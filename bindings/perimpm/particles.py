"""Particle fields as NumPy arrays."""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core


class ViewWatch:
    """Knows whether somebody wrote through a view what a step relies on, and only then tells the simulation."""

    WATCHED = ("x", "v", "mass", "volume", "F")

    def __init__(self) -> None:
        self._views: dict[tuple[str, str], list[weakref.ref[npt.NDArray[Any]]]] = {}  #: by field and material
        self._prints: dict[tuple[str, str], int] = {}  #: of watched fields, as the simulation left them

    def add(self, simulation: _core.Simulation, name: str, material: str, view: npt.NDArray[Any]) -> None:
        if name in self.WATCHED:
            self._prints.setdefault((name, material), _core.fingerprint(simulation, name, material))
            self._views.setdefault((name, material), []).append(weakref.ref(view))

    @contextmanager
    def around_steps(self, simulation: _core.Simulation) -> Iterator[None]:
        """Before: compares the fields whose views were given out. After: forgets the views that are gone."""
        for name in {key[0] for key, old in self._prints.items() if _core.fingerprint(simulation, *key) != old}:
            simulation.written(name)
        try:
            yield
        finally:
            alive = {key: [view for view in views if view() is not None] for key, views in self._views.items()}
            self._views = {key: views for key, views in alive.items() if views}
            self._prints = {key: _core.fingerprint(simulation, *key) for key in self._views}


class UnknownField(KeyError):
    """A field that the simulation does not have."""

    def __str__(self) -> str:  # a KeyError shows the representation, with line ends spelt out
        return str(self.args[0])


class Particles(Mapping[str, npt.NDArray[Any]]):
    """Fields of all particles, or of one material, by name.

    ``particles["x"]`` is a view without copying: shape (n, 3) for vectors, (n, 3, 3) for tensors, (n,) for the rest,
    in SI units. Writing into it changes the simulation (numbers of particles and of broken bonds can only be read); reading does not, to the last bit. A view shows the present particles until `generation`
    changes; then ask for it again, since the slots have been re-sorted. ``by_id`` gives copies in a fixed order.
    """

    def __init__(self, simulation: _core.Simulation, watch: ViewWatch, material: str = "") -> None:
        self._simulation = simulation
        self._watch = watch
        self._material = material

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """View of one field. Raises KeyError, with the closest name, for an unknown one."""
        try:
            view = _core.view(self._simulation, name, self._material)
        except _core.InputError as error:
            raise UnknownField(str(error)) from None
        self._watch.add(self._simulation, name, self._material, view)
        return view

    def __setitem__(self, name: str, values: npt.ArrayLike) -> None:
        """Writes into the view of a field; `values` broadcast to its shape."""
        self[name][...] = values

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
        if name not in self:
            return self[name]  # raises, with the closest name
        values, ids = (_core.view(self._simulation, field, self._material) for field in (name, "id"))
        return np.asarray(values[np.argsort(ids, kind="stable")])

    @property
    def generation(self) -> int:
        """Number of re-sorts so far."""
        return self._simulation.generation

    def __repr__(self) -> str:
        return f"<Particles: {', '.join(self)}>"
