"""How motion moves the mean: moorings that stiffen with offset hold a moving floater back more than one at rest."""

from __future__ import annotations

import numpy as np

from model.conventions import PLATFORM_DOFS
from model.response.assemble import Equilibrium, System, to_platform
from model.response.solve import Response, trapezoid_weights
from model.system.mooring import mooring_state


def motion_covariance(response: Response) -> np.ndarray:
    """Return the covariance (q, q) of the degrees of freedom in the sea and wind of a response."""
    drive, weights = response.excitation, trapezoid_weights(response.excitation.omega)
    columns = [x * np.sqrt(s * weights)[:, None] for x, s in zip(response.to_wave, drive.wave_spectrum, strict=True)]
    columns.append(response.to_wind * np.sqrt(drive.wind_spectrum * weights)[:, None])
    columns += [g * np.sqrt(drive.gradient_spectrum * weights)[:, None] for g in response.to_gradients]
    x = np.concatenate(columns)
    return (x.T @ x.conj() + np.tensordot(weights, response.incoherent, axes=1)).real


def mooring_shift(system: System, mean: Equilibrium, covariance) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean force (q) [N, N m] that the moorings add because the floater moves about its mean, to second order, and what
    their fairlead tensions (k) [N] gain on average.

    covariance (q, q) of the degrees of freedom. The mean of a function over a Gaussian motion is that at rest plus
    half the second derivative along every principal direction times its variance, taken as a difference one
    standard deviation to both sides. Zero without moorings, of which there are then none.
    """
    out = np.zeros(len(system.dofs))
    if mean.mooring is None:
        return out, np.zeros(0)
    here, rest = system.platform, mean.mooring
    variance, directions = np.linalg.eigh(np.asarray(covariance)[np.ix_(here, here)])
    force, tension = np.zeros(6), np.zeros(len(rest.fairlead_tension))
    for value, direction in zip(variance, directions.T, strict=True):
        if value <= 1e-12 * variance[-1]:
            continue
        step = np.zeros(len(system.dofs))
        step[here] = np.sqrt(value) * direction
        sides = [mooring_state(system.mooring, to_platform(system, mean.offset + s * step)) for s in (-1, 1)]
        force += (sides[0].force + sides[1].force - 2 * rest.force) / 2
        tension += (sides[0].fairlead_tension + sides[1].fairlead_tension - 2 * rest.fairlead_tension) / 2
    out[here] = force[[PLATFORM_DOFS.index(d) for d in system.dofs if d in PLATFORM_DOFS]]
    return out, tension
