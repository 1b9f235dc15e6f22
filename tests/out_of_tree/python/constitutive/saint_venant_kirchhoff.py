"""Saint Venant-Kirchhoff elasticity: Hooke's law for the Green-Lagrange strain. Holzapfel 2000, Nonlinear Solid Mechanics,
section 6.5. The same law as ../../saint_venant_kirchhoff.cpp."""

import numpy as np

import perimpm


class SaintVenantKirchhoff(perimpm.Law):
    """Saint Venant-Kirchhoff elasticity in Python, for moderate strains"""

    parameters = (
        perimpm.Parameter("youngs_modulus", unit="Pa", above=0.0, doc="Young's modulus at small strain"),
        perimpm.Parameter("poisson_ratio", default=0.25, at_least=0.0, below=0.5, doc="Poisson's ratio at small strain"),
    )

    def __init__(self, parameters, density):
        self.youngs_modulus, self.poisson_ratio = parameters["youngs_modulus"], parameters["poisson_ratio"]
        self.mu = self.youngs_modulus / (2 * (1 + self.poisson_ratio))
        self.lam = 2 * self.mu * self.poisson_ratio / (1 - 2 * self.poisson_ratio)
        self.density = density

    def strain(self, F):
        E = (F.swapaxes(1, 2) @ F - np.eye(3)) / 2  # Green-Lagrange strain
        return E, np.trace(E, axis1=1, axis2=2)

    def stress(self, F):
        E, trace = self.strain(F)
        S = self.lam * trace[:, None, None] * np.eye(3) + 2 * self.mu * E  # second Piola-Kirchhoff stress
        return F @ S @ F.swapaxes(1, 2)

    def wave_speed(self, F):
        E, trace = self.strain(F)
        s = np.linalg.norm(F, 2, axis=(1, 2))  # largest principal stretch
        pull = self.lam * trace + 2 * self.mu * np.linalg.norm(E, axis=(1, 2))  # at least the stress along it
        bound = s**4 * (self.lam + 2 * self.mu) + s**2 * np.maximum(pull, 0.0)
        return np.sqrt(bound.max() / self.density)

    def energy(self, F):
        E, trace = self.strain(F)
        return self.lam / 2 * trace**2 + self.mu * np.square(E).sum(axis=(1, 2))
