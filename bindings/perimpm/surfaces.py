"""Surfaces of bodies and fragments, as meshes for renderers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._core import InputError, surface_around
from .frames import FrameFolder
from .shading import spacing_of

Array = npt.NDArray[Any]


def surfaces(
    folder: str | os.PathLike[str],
    *,
    by: str | None = None,
    frames: tuple[int, int] | None = None,
    every: int = 1,
    output: str | os.PathLike[str] | None = None,
    spacing: float | None = None,
) -> list[Path]:
    """Writes a Wavefront OBJ per frame with one object per piece; crack faces are part of a fragment's surface.

    folder : of a run.
    by : field whose values tell the pieces apart; default: "fragment", else "body", of those that the frames hold.
    frames, every : first and last frame; every n-th of them.
    output : default: `surfaces` in the run's folder.
    spacing : of the particles [m]; default: measured in the first frame.

    Returns the files, frame.0001.obj ... Raises InputError: no such folder or field.
    """
    run = FrameFolder(os.fspath(folder))
    numbers = run.select(frames, every)
    by = by or next((name for name in ("fragment", "body") if run.has(numbers[0], name)), None)
    if by is None:
        raise InputError(f"{run.folder}: frames hold neither 'fragment' nor 'body': add one to output.fields, or name another")
    target = Path(output) if output else run.folder / "surfaces"
    target.mkdir(parents=True, exist_ok=True)
    spacing = spacing or spacing_of(run.read(min(run.files), "x"))
    written = []
    for number in numbers:
        file = target / f"frame.{number:04}.obj"
        unfinished = file.with_suffix(".part")
        unfinished.write_text("".join(_objects(run.read(number, "x"), run.read(number, by), by, spacing)))
        unfinished.replace(file)
        written.append(file)
    return written


def _objects(x: Array, label: Array, name: str, spacing: float) -> Iterator[str]:
    """One object of the file after the other."""
    order = np.argsort(label, kind="stable")
    values, begin = np.unique(label[order], return_index=True)
    first = 1  # OBJ counts from 1, on through all objects
    for value, rows in zip(values, np.split(order, begin[1:]), strict=True):
        corners, triangles = surface_around(x[rows], spacing)
        yield f"o {name}_{value}\n"
        yield "".join(f"v {a:.7g} {b:.7g} {c:.7g}\n" for a, b, c in corners.tolist())
        yield "".join(f"f {a} {b} {c}\n" for a, b, c in (triangles.astype(np.int64) + first).tolist())
        first += len(corners)
