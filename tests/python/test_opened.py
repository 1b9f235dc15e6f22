"""What a scene does not need is not there: read from the process itself, each scene in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

PROBE = r"""
import json, sys
import perimpm
sim = perimpm.Simulation(json.load(open(sys.argv[1])))
sim.step(2)
mapped = {line.split()[-1] for line in open("/proc/self/maps") if ".so" in line}
fields = set(sim.particles) | set(sim.particles.of("rubber"))
print(json.dumps({"maps": sorted(mapped), "fields": sorted(fields), "arrays": [a.name for a in sim.plan.arrays],
                  "bonds": sim.plan.materials[0].bonds}))
"""


def probe(scene: dict[str, Any], folder: Path) -> dict[str, Any]:
    file = folder / "scene.json"
    file.write_text(json.dumps(scene))
    done = subprocess.run([sys.executable, "-c", PROBE, str(file)], capture_output=True, text=True, check=True)
    result: dict[str, Any] = json.loads(done.stdout)
    result["mapped"] = " ".join(Path(path).name for path in result["maps"])
    return result


def test_local_law_builds_no_bonds(box: dict[str, Any], tmp_path: Path) -> None:
    seen = probe(box, tmp_path)
    assert "fixed_corotated.so" in seen["mapped"] and "apic.so" in seen["mapped"]
    for name in ("pd_elastic", "pd_bond", "critical_stretch", "flip.so"):
        assert name not in seen["mapped"]
    assert "F" in seen["fields"]
    assert seen["bonds"] == 0
    assert not [name for name in seen["arrays"] if "bond" in name]


def test_bond_law_evolves_no_deformation_gradient(bonded: dict[str, Any], tmp_path: Path) -> None:
    seen = probe(bonded, tmp_path)
    assert "pd_elastic.so" in seen["mapped"]
    assert "fixed_corotated" not in seen["mapped"]  # the law that holds the SVD
    assert "F" not in seen["fields"]
    assert not [name for name in seen["arrays"] if name.endswith(".F")]
    assert seen["bonds"] > 0


def test_meshes_and_files_are_opened_on_demand(box: dict[str, Any], tmp_path: Path) -> None:
    seen = probe(box, tmp_path)
    for name in ("libassimp", "libopenvdb", "libhdf5", "perimpm_mesh", "perimpm_hdf5"):
        assert name not in seen["mapped"]
