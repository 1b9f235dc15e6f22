"""Reading the frames of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._core import InputError

Array = npt.NDArray[Any]


def remove_pictures(folder: Path) -> int:
    """Before a run into `folder`: removes what `render` made there of an earlier run; returns how many frames that run
    left, which the new one replaces."""
    pictures = folder / "pictures"
    for pattern in ("frame.[0-9]*.png", "poster.png", "animation.*"):
        for file in pictures.glob(pattern):
            file.unlink()
    if pictures.is_dir() and not any(pictures.iterdir()):
        pictures.rmdir()
    return len(list(folder.glob("frame.[0-9]*.h5")))


class FrameFolder:
    """The frames in the folder of a run, by number; rows are in the order of particle ids."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        found = {int(f.name.split(".")[1]): f for f in self.folder.glob("frame.*.h5") if f.name.split(".")[1].isdigit()}
        if not found:
            raise InputError(f"{self.folder}: no frames (frame.0001.h5 ...) here; name the output folder of a run")
        self.files = dict(sorted(found.items()))
        record = self.folder / "run.json"
        self.record: dict[str, Any] = json.loads(record.read_text()) if record.exists() else {}

    def select(self, frames: tuple[int, int] | None, every: int) -> list[int]:
        """Frame numbers to show."""
        numbers = [n for n in self.files if frames is None or frames[0] <= n <= frames[1]][::every]
        if not numbers:
            raise InputError(f"{self.folder}: none of the frames asked for; there are {min(self.files)} to {max(self.files)}")
        return numbers

    def read(self, number: int, field: str) -> Array:
        """One field of one frame."""
        import h5py

        with h5py.File(self.files[number]) as file:
            if field not in file or field == "connectivity":
                names = ", ".join(sorted(name for name in file if name != "connectivity"))
                raise InputError(f"{self.files[number]}: no field '{field}'; there are {names}.{self._remedy(field)}")
            return np.asarray(file[field])

    def _remedy(self, field: str) -> str:
        """What to do about a field that frames lack: only fields of this scene can be added."""
        possible = self.record.get("available_fields", [])
        if field in possible:
            return " Add it to output.fields in the scene and run again"
        missing = ", ".join(name for name in possible if not self.has(min(self.files), name))
        return f" This scene also has {missing}, which output.fields can add" if missing else ""

    def time(self, number: int) -> float:
        """Simulated time of a frame [s]."""
        import h5py

        with h5py.File(self.files[number]) as file:
            return float(file.attrs["time"])

    def unit(self, number: int, field: str) -> str:
        """SI unit of a field, "" for pure numbers."""
        import h5py

        with h5py.File(self.files[number]) as file:
            unit = str(file[field].attrs.get("unit", "1"))
        return "" if unit == "1" else unit

    def has(self, number: int, field: str) -> bool:
        """Whether the frame holds this field."""
        import h5py

        with h5py.File(self.files[number]) as file:
            return field in file

    @property
    def frame_rate(self) -> float:
        """Frames per second of the run."""
        return float(self.record.get("frame_rate", 24.0))

    def ground(self) -> float | None:
        """Height of the floor: a horizontal plane collider, else the bottom of the domain; None without either."""
        scene = self.record.get("scene", {})
        for collider in scene.get("collider", []):
            shape = collider.get("shape", {})
            normal = np.asarray(shape.get("normal", [0, 0, 0]), float)
            if shape.get("type") == "plane" and normal[1] > 0.999 * np.linalg.norm(normal):
                return float(shape["point"][1])
        domain = scene.get("grid", {}).get("domain")
        return None if domain is None else float(domain["min"][1])
