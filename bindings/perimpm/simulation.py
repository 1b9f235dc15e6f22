"""The simulation as Python sees it."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral
from pathlib import Path
from typing import Any, Union

import numpy.typing as npt

from . import _core
from .particles import Particles, ViewWatch

SceneLike = Union[str, "os.PathLike[str]", Mapping[str, Any]]
_SELDOM_MEANT = 5e6  # steps of a run
_SHARE_OF_FRAME = 1e-5  # too little to be missed
Field = Union[Sequence[Any], npt.NDArray[Any], Callable[[npt.NDArray[Any], float], Any]]


def _recorded_scene(file: Path) -> dict[str, Any]:
    """The scene in the run.json of a run; its meshes have absolute paths."""
    try:
        record = json.loads(file.read_text())
    except ValueError as error:
        raise _core.InputError(f"{file}: error: this is no JSON: {error}") from None
    if not isinstance(record, dict) or not isinstance(record.get("scene"), dict):
        raise _core.InputError(f"{file}: error: this is no record of a run: it has no 'scene'\n  expected a TOML file or run.json")
    scene: dict[str, Any] = record["scene"]
    return scene


class Simulation:
    """A scene in motion.

    Parameters
    ----------
    scene : a TOML file, or the same tree as a dict (NumPy scalars and arrays are welcome), or the run.json of a run,
        whose scene runs again.
    overrides : changes such as ``"simulation.dt=1e-4"``; the value is TOML.
    threads : worker threads, 0 for every core; the result does not depend on it.
    folder : where relative file names of the scene start; by default the scene file's folder.

    Raises
    ------
    InputError : something in the scene is wrong; the message says where and what to do.

    Warns (UserWarning) about what is allowed but seldom meant, such as a body that starts inside a collider.
    """

    def __init__(
        self, scene: SceneLike, overrides: Sequence[str] = (), threads: int = 0, folder: str | os.PathLike[str] = ""
    ) -> None:
        if not isinstance(scene, Mapping) and (file := Path(scene)).suffix == ".json" and file.is_file():
            scene = _recorded_scene(file)
        if isinstance(overrides, str):
            raise _core.InputError(f"overrides = {overrides!r}: expected a list of changes, [{overrides!r}]")
        checked = _core.Scene(scene, list(overrides), os.fspath(folder))
        self._core = _core.Simulation(checked, threads)
        self._watch = ViewWatch()
        for text in self._core.plan.warnings:
            warnings.warn(text, stacklevel=2)
        self.title: str = checked.title
        self._end_time, self._frame_rate, self._last_frame = checked.end_time, checked.frame_rate, checked.last_frame

    def run(
        self, frames: int | None = None, output: str | os.PathLike[str] | None = None, progress: bool = False
    ) -> None:
        """Runs to frame number `frames` (frame 1 is t = 0) or to the scene's end time.

        Writes frames, run.xdmf, energy.csv and run.json into the folder `output`, or nothing when it is None. Other
        Python threads go on meanwhile. Ctrl-C stops after the current step with every file whole.

        Raises
        ------
        SimulationError : the simulation failed; the state is in `output`/failed.h5.
        """
        from .progress import reporter

        if frames is not None and frames < 1:
            raise _core.InputError(f"frames = {frames}: expected 1 or more (frame 1 is t = 0)")
        plan = self._core.plan
        if frames is None and plan.steps > _SELDOM_MEANT:
            text = f"{plan.steps:.0e} steps of {plan.dt:.1e} s to the scene's end: are all values in SI units (m, kg/m^3, Pa, s)?"
            warnings.warn(text, stacklevel=2)
        if frames is None and output is not None:
            self._warn_of_lost_end()
        folder = "" if output is None else os.fspath(output)
        with self._watch.around_steps(self._core), reporter(progress) as report:
            self._core.run(folder, frames or 0, report)

    def _warn_of_lost_end(self) -> None:
        last, following = (self._last_frame - 1) / self._frame_rate, self._last_frame / self._frame_rate
        if (self._end_time - last) * self._frame_rate > _SHARE_OF_FRAME:
            text = (
                f"end_time = {self._end_time:g} s is between two frames: the last one, {self._last_frame}, shows "
                f"t = {last:.6g} s, and what comes after it is not written\n"
                f"  frames fall on: {last!r} and {following!r} s; or choose a frame_rate with one at the end"
            )
            warnings.warn(text, stacklevel=3)

    def step(self, n: int = 1) -> float:
        """Advances `n` steps; returns the length of the last one [s]."""
        if not isinstance(n, Integral) or n < 0:
            raise _core.InputError(f"step({n!r}): expected a whole number of steps, 0 or more")
        with self._watch.around_steps(self._core):
            return self._core.step(int(n))

    def prescribe(self, velocity: Field, **region: Any) -> None:
        """Prescribes the velocity of the particles of a region, before the first step.

        velocity : three components [m/s], each a number or "free"; or a function f(X, t) of the particles' positions
            X, shape (n, 3), as they are at this call, that returns velocities of shape (n, 3) or (3,). NaN leaves a component
            free. It is called once per step with all particles of the region.
        region : keys of [[condition]]: shape, body, material, name; times and factors.
        """
        self._add("velocity", velocity, region)

    def load(
        self, *, acceleration: Field | None = None, body_force: Field | None = None, **region: Any
    ) -> None:
        """Adds a load on a region, before the first step: `acceleration` [m/s^2] or `body_force` [N/m^3].

        Either is a vector or a function b(X, t) as in `prescribe`; `region` as there.
        """
        if (acceleration is None) == (body_force is None):
            raise _core.InputError("load: expected either acceleration [m/s^2] or body_force [N/m^3]")
        if acceleration is not None:
            self._add("acceleration", acceleration, region)
        else:
            self._add("body_force", body_force, region)

    def _add(self, key: str, value: Any, region: dict[str, Any]) -> None:
        if callable(value):
            self._core.add_condition(region, key, value)
        else:
            self._core.add_condition({key: value, **region})

    def relax(self, residual: float = 1e-6, max_steps: int = 100_000) -> _core.Relaxation:
        """Searches the equilibrium for the loads of the present time, which does not advance meanwhile.

        Kinetic damping: all motion is stopped whenever its energy passes a maximum. `residual`: root mean square of the
        particles' unbalanced accelerations over the largest met on the way, or over gravity. Prescribed particles stand
        still. Returns the steps taken and the residual reached.

        Raises
        ------
        InputError : a residual that is not above 0, no whole number of steps.
        SimulationError : `max_steps` did not suffice.
        """
        if not isinstance(max_steps, Integral) or max_steps < 1:
            raise _core.InputError(f"relax(max_steps={max_steps!r}): expected a whole number of steps, 1 or more")
        with self._watch.around_steps(self._core):
            return self._core.relax(residual, int(max_steps))

    def measure_stiffness(self) -> list[_core.MeasuredStiffness]:
        """Small-strain stiffness that the particles of each material have as the scene starts, beside what was asked for.

        From the energies of all particles under small affine strains; bulk and surface apart. NaN for laws without energy.
        """
        return self._core.measure_stiffness()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._core.time

    @property
    def steps(self) -> int:
        """Steps done."""
        return self._core.steps

    @property
    def particles(self) -> Particles:
        """Fields of all particles; ``particles.of("rubber")`` for those of one material."""
        return Particles(self._core, self._watch)

    @property
    def plan(self) -> _core.Plan:
        """What the scene was compiled to."""
        return self._core.plan

    @property
    def ledger(self) -> _core.Ledger:
        """Energies and momenta now, in SI units."""
        return self._core.ledger

    @property
    def fragments(self) -> list[_core.Fragment]:
        """The pieces that the scene consists of now, ascending by id; a body that cannot break is one piece."""
        return self._core.fragments

    @property
    def pass_times(self) -> list[_core.PassTime]:
        """Wall time of every pass since the start."""
        return self._core.pass_times

    def __repr__(self) -> str:
        return f"<Simulation '{self.title}': {self._core.particle_count} particles, t = {self.time:g} s>"
