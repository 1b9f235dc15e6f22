"""Constitutive laws written in Python: a file with a class derived from `Law`, found like any other plugin."""

from __future__ import annotations

import importlib.util
import inspect
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._core import InputError

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Parameter:
    """A number that scenes give the law. Without a default it must be given; `above` and `below` exclude the bound
    itself, `at_least` and `at_most` include it."""

    key: str
    unit: str = "1"
    default: float | None = None
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    doc: str = ""

    def __post_init__(self) -> None:
        for low, high in (("above", "at_least"), ("below", "at_most")):
            if getattr(self, low) is not None and getattr(self, high) is not None:
                raise InputError(f"parameter '{self.key}': give '{low}' or '{high}', not both")


class Law:
    """Base of a local law: stress from the deformation gradient. The first line of the class's docstring is its summary.

    One object serves all particles of a material. Its methods are called for blocks of particles, from several threads,
    one call at a time; they must not keep anything that depends on the block. What they raise ends the run.
    """

    parameters: tuple[Parameter, ...] | list[Parameter] = ()
    youngs_modulus: float = math.nan  #: Pa, at small strain; what `perimpm explain` shows
    poisson_ratio: float = math.nan  #: 1, the same

    def __init__(self, parameters: Mapping[str, float], density: float) -> None:
        """parameters: values by key, checked against their declarations; density: of the material [kg/m^3]."""

    def stress(self, F: Array) -> Array:
        """Kirchhoff stress tau = J sigma [Pa], symmetric, shape (n, 3, 3), for deformation gradients F (n, 3, 3) [1],
        which must not be written to."""
        raise NotImplementedError

    def wave_speed(self, F: Array) -> float:
        """Upper bound of the speed of waves in the particles with F (n, 3, 3) [m/s]; the time step comes from it."""
        raise NotImplementedError

    def energy(self, F: Array) -> Array:
        """Energy density of the reference volume [J/m^3], shape (n,), for F (n, 3, 3). NaN: the law has none."""
        return np.full(len(F), np.nan)


def open_law(path: str) -> tuple[type[Law], str, list[Parameter]]:
    """The law that a file holds, its summary and its parameters. Raises InputError that says what the file lacks."""
    name = f"perimpm.laws.{Path(path).stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise InputError(f"{path}: {_where(error, path)}{type(error).__name__}: {error}") from error
    laws = [c for c in vars(module).values() if inspect.isclass(c) and issubclass(c, Law) and c.__module__ == name]
    if len(laws) != 1:
        found = ", ".join(law.__name__ for law in laws) or "none"
        raise InputError(f"{path}: a law's file holds one class derived from perimpm.Law, found: {found}")
    law = laws[0]
    summary = (law.__doc__ or "").strip().partition("\n")[0]
    if not summary:
        raise InputError(f"{path}: the class '{law.__name__}' needs a docstring, whose first line says what it is")
    for method in ("stress", "wave_speed"):
        if getattr(law, method) is getattr(Law, method):
            raise InputError(f"{path}: the class '{law.__name__}' lacks the method '{method}(self, F)'")
    for parameter in law.parameters:
        if not isinstance(parameter, Parameter):
            raise InputError(f"{path}: '{law.__name__}.parameters' holds perimpm.Parameter objects, got {parameter!r}")
    return law, summary, list(law.parameters)


def _where(error: BaseException, path: str) -> str:
    """The innermost line of the file at `path` that an exception came through."""
    lines = []
    if isinstance(error, SyntaxError) and error.filename == path:
        lines.append(error.lineno)
    trace = error.__traceback__
    while trace:
        if trace.tb_frame.f_code.co_filename == path:
            lines.append(trace.tb_lineno)
        trace = trace.tb_next
    return f"line {lines[-1]}: " if lines else ""


def make_law(law: type[Law], values: Mapping[str, float], density: float) -> Law:
    """An object of the law. What its constructor raises becomes an InputError."""
    try:
        return law(values, density)
    except Exception as error:
        path = inspect.getfile(law)
        raise InputError(f"{path}: {_where(error, path)}{type(error).__name__}: {error}") from error


def evaluate(law: Law, F: Array) -> Array:
    """xx, xy, xz, yy, yz, zz of the stress, one row each."""
    tau = np.asarray(law.stress(F))
    if tau.shape != F.shape or tau.dtype.kind not in "fiu":
        raise InputError(
            f"{type(law).__name__}.stress returned {tau.dtype} numbers of shape {tau.shape}: expected real ones of shape {F.shape}"
        )
    skew = np.abs(tau - tau.swapaxes(1, 2)).max(initial=0.0)
    if skew > 1e3 * np.finfo(F.dtype).eps * np.abs(tau).max(initial=0.0):
        raise InputError(
            f"{type(law).__name__}.stress returned a tensor that is not symmetric: expected the Kirchhoff stress,"
            " which is P F^T for the first Piola-Kirchhoff stress P"
        )
    rows, columns = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)
    return np.ascontiguousarray(tau[:, rows, columns].T, dtype=F.dtype)


def wave_speed(law: Law, F: Array) -> float:
    speed = float(law.wave_speed(F))
    if not speed > 0 or math.isinf(speed):
        raise InputError(f"{type(law).__name__}.wave_speed returned {speed:g}: expected a number above 0, in m/s")
    return speed


def energy(law: Law, F: Array, volume: Array) -> float:
    """Of the particles with these F and volumes [J]."""
    density = np.asarray(law.energy(F), dtype=np.float64)
    if density.shape != volume.shape:
        raise InputError(f"{type(law).__name__}.energy returned shape {density.shape}: expected {volume.shape}")
    return float(density @ volume.astype(np.float64))
