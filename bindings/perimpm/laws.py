"""Constitutive laws written in Python: a file with a class derived from `Law`, found like any other plugin."""

from __future__ import annotations

import importlib.util
import inspect
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._core import InputError

Array = npt.NDArray[Any]


class InvalidParameter(ValueError):
    """A law's constructor refuses the value of the parameter `key`; the user sees where the scene gives it. The message
    goes on from the key: "must be below 'other'"."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class Parameter:
    """A number that scenes give the law. Without a default it must be given. `above` and `below` exclude the bound itself,
    `at_least` and `at_most` include it."""

    key: str
    unit: str = "1"
    default: float | None = None
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    doc: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.key, str) or not self.key.isidentifier():
            raise InputError(f"parameter {self.key!r}: the key must be a name")
        for name in ("unit", "doc"):
            if not isinstance(getattr(self, name), str):
                raise InputError(f"parameter '{self.key}': '{name}' must be a text, got {getattr(self, name)!r}")
        for name in ("default", "above", "at_least", "below", "at_most"):
            value = getattr(self, name)
            if value is not None and (isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value)):
                raise InputError(f"parameter '{self.key}': '{name}' must be a number, got {value!r}")
        for one, other in (("above", "at_least"), ("below", "at_most")):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise InputError(f"parameter '{self.key}': give '{one}' or '{other}', not both")
        if self.default is not None and not self._allows(self.default):
            raise InputError(f"parameter '{self.key}': the default {self.default:g} lies outside of the range")

    def _allows(self, value: float) -> bool:
        return not (
            (self.above is not None and value <= self.above)
            or (self.at_least is not None and value < self.at_least)
            or (self.below is not None and value >= self.below)
            or (self.at_most is not None and value > self.at_most)
        )


class Law:
    """Base of a local law: stress from the deformation gradient. The first line of the class's docstring is its summary.

    One object serves all particles of a material. Its methods are called for blocks of particles from several threads, and
    calls may overlap: the object keeps nothing but what its constructor put there. What a method raises ends the run.
    """

    parameters: Sequence[Parameter] = ()
    youngs_modulus: float = math.nan  #: at small strain [Pa]; what `perimpm explain` compares with
    poisson_ratio: float = math.nan  #: the same [1]

    def __init__(self, parameters: Mapping[str, float], density: float) -> None:
        """parameters: values by key, checked against their declarations; density: of the material [kg/m^3].
        Raises InvalidParameter for what ranges cannot say."""

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
    law = _law_of(path)
    summary = (law.__doc__ or "").strip().partition("\n")[0]
    if not summary:
        raise InputError(f"{path}: the class '{law.__name__}' needs a docstring, whose first line says what it is")
    for method in ("stress", "wave_speed"):
        if getattr(law, method) is getattr(Law, method):
            raise InputError(f"{path}: the class '{law.__name__}' lacks the method '{method}(self, F)'")
    for parameter in law.parameters:
        if not isinstance(parameter, Parameter):
            raise InputError(f"{path}: '{law.__name__}.parameters' holds perimpm.Parameter objects, got {parameter!r}")
    keys = [parameter.key for parameter in law.parameters]
    if twice := sorted({key for key in keys if keys.count(key) > 1}):
        raise InputError(f"{path}: '{law.__name__}.parameters' declares '{twice[0]}' twice")
    return law, summary, list(law.parameters)


def _law_of(path: str) -> type[Law]:
    """The only class derived from Law in a file. It may import what lies beside the file."""
    name = f"perimpm.laws.{Path(path).stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    if (folder := str(Path(path).parent)) not in sys.path:
        sys.path.append(folder)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise _refusal(path, error) from error
    laws = [c for c in vars(module).values() if inspect.isclass(c) and issubclass(c, Law) and c.__module__ == name]
    if len(laws) != 1:
        found = ", ".join(law.__name__ for law in laws) or "none"
        raise InputError(f"{path}: a law's file holds one class derived from perimpm.Law, found: {found}")
    return laws[0]


def _refusal(path: str, error: Exception) -> InputError:
    """`error` with the innermost line of the file at `path` that it came through."""
    lines = [error.lineno] if isinstance(error, SyntaxError) and error.filename == path else []
    trace = error.__traceback__
    while trace:
        if trace.tb_frame.f_code.co_filename == path:
            lines.append(trace.tb_lineno)
        trace = trace.tb_next
    where = f"line {lines[-1]}: " if lines else ""
    return InputError(f"{path}: {where}{type(error).__name__}: {error}")


def make_law(law: type[Law], values: Mapping[str, float], density: float) -> Law:
    """An object of the law, tried out on two strained particles. Raises InputError, InvalidParameter."""
    path = inspect.getfile(law)
    F = np.array([np.eye(3), [[1.1, 0.04, 0.0], [0.02, 0.95, 0.03], [0.0, -0.05, 1.02]]])
    try:
        made = law(values, density)
        evaluate(made, F), wave_speed(made, F)  # shapes, and a speed
        tau, density_of_energy = np.asarray(made.stress(F)), np.asarray(made.energy(F))
        float(made.youngs_modulus), float(made.poisson_ratio)
    except (InputError, InvalidParameter):
        raise
    except Exception as error:
        raise _refusal(path, error) from error
    if np.abs(tau - tau.swapaxes(1, 2)).max() > 1e-9 * np.abs(tau).max():
        raise InputError(
            f"{path}: {law.__name__}.stress returned a tensor that is not symmetric: expected the Kirchhoff stress, which is"
            " P F^T for the first Piola-Kirchhoff stress P"
        )
    if density_of_energy.shape != (2,):
        raise InputError(f"{path}: {law.__name__}.energy returned shape {density_of_energy.shape} for two particles: expected (2,)")
    return made


def evaluate(law: Law, F: Array) -> Array:
    """xx, xy, xz, yy, yz, zz of the stress, one row each."""
    tau = np.asarray(law.stress(F))
    if tau.shape != F.shape or tau.dtype.kind not in "fiu":
        raise InputError(
            f"{inspect.getfile(type(law))}: {type(law).__name__}.stress returned {tau.dtype} numbers of shape {tau.shape}:"
            f" expected real ones of shape {F.shape}"
        )
    rows, columns = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)
    return np.ascontiguousarray(tau[:, rows, columns].T, dtype=F.dtype)


def wave_speed(law: Law, F: Array) -> float:
    """The law's bound, which must be a speed."""
    speed = float(law.wave_speed(F))
    if not speed > 0 or math.isinf(speed):
        name = f"{inspect.getfile(type(law))}: {type(law).__name__}"
        raise InputError(f"{name}.wave_speed returned {speed:g}: expected a number above 0, in m/s")
    return speed


def energy(law: Law, F: Array, volume: Array) -> float:
    """Of the particles with these F and volumes [J]."""
    return float(np.asarray(law.energy(F), dtype=np.float64) @ volume.astype(np.float64))
