"""perimpm: MPM and peridynamics on one road from a scene to a picture.

    import perimpm
    sim = perimpm.Simulation("scenes/falling_box.toml")
    sim.run(frames=24, output="out/box", progress=True)
    print(sim.particles["x"].mean(axis=0))
"""

from ._core import InputError, SimulationError, __version__
from .describe import Description, describe, plugins
from .explain import explain
from .laws import InvalidParameter, Law, Parameter
from .particles import Particles
from .simulation import Simulation
from .surfaces import surfaces

__all__ = [
    "Description",
    "InputError",
    "InvalidParameter",
    "Law",
    "Parameter",
    "Particles",
    "Simulation",
    "SimulationError",
    "__version__",
    "describe",
    "explain",
    "plugins",
    "surfaces",
]
