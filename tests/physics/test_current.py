"""Steady current: profiles, its drag, and drag linearised about it, against closed forms and Monte Carlo."""

import numpy as np
import pytest

import fowtio
from model.environment.current import Current, current_velocity
from model.system.drag import DragMembers, borgman_coefficients, mean_flow_coefficients, steady_drag


def test_profiles():
    """1/7 power law, linear near-surface part, constant part; nothing above still water."""
    current = Current(sub_surface=1.0, near_surface=0.5, near_surface_depth=20.0, near_surface_heading=np.pi / 2, depth_independent=0.2, depth=100.0)
    velocity = current_velocity(current, [0.0, -10.0, -50.0, -100.0, 1.0])
    np.testing.assert_allclose(velocity[:, 0], [1.2, 0.9 ** (1 / 7) + 0.2, 0.5 ** (1 / 7) + 0.2, 0.2, 0.0])
    np.testing.assert_allclose(velocity[:, 1], [0.5, 0.25, 0.0, 0.0, 0.0], atol=1e-15)


def test_without_a_mean_it_is_borgman():
    """16-point Gauss-Hermite of a function with a kink at zero: 0.3 %."""
    covariance = np.array([[2.0, 0.3], [0.3, 1.0]])
    np.testing.assert_allclose(mean_flow_coefficients(covariance, np.zeros(2)), borgman_coefficients(covariance), rtol=5e-3)


def test_with_a_mean_alone_it_is_the_derivative():
    """d(|v| v)/dv at (U, 0) is diag(2 U, U)."""
    found = mean_flow_coefficients(1e-10 * np.eye(2), np.array([3.0, 0.0]))
    np.testing.assert_allclose(found, np.diag([6.0, 3.0]), rtol=1e-4, atol=1e-6)


def test_in_between_against_sampling():
    """A million samples scatter by about 0.3 % of the largest coefficient; three of these."""
    rng = np.random.default_rng(0)
    covariance, mean = np.array([[2.0, 0.3], [0.3, 1.0]]), np.array([1.0, 0.5])
    u = rng.multivariate_normal([0, 0], covariance, 1_000_000)
    v = u + mean
    sampled = (np.linalg.norm(v, axis=1)[:, None] * v).T @ u / len(u) @ np.linalg.inv(covariance)
    np.testing.assert_allclose(mean_flow_coefficients(covariance, mean), sampled, atol=0.03)


def test_drag_of_a_vertical_cylinder_in_a_uniform_current():
    """1/2 rho Cd D L U2 in the flow's direction, at the strip's depth."""
    factor, depth, speed = 0.5 * 1025 * 0.6 * 12.0 * 20.0, -10.0, 1.5
    members = DragMembers(position=[[0, 0, depth]], axis=[[0, 0, 1]], factor=[factor], axial=[0], diameter=[12.0], length=[20.0])
    force = steady_drag(members, np.array([[0.0, speed, 0.3]]))
    np.testing.assert_allclose(force[:3], [0, factor * speed**2, 0], atol=1e-6)
    assert force[3] == pytest.approx(-depth * factor * speed**2)


def test_a_current_moves_the_floater_and_damps_it(trial):
    """Mean surge grows by metres and drag damping with the current, from one line of the deck."""
    study = trial()
    calm = fowtio.solve(fowtio.build(fowtio.load(study)))[0]
    path = study.parent / "input" / "SeaState.dat"
    lines = path.read_text().splitlines()
    for name, value in (("CurrMod", "1"), ("CurrSSV0", "0.8")):
        k = next(i for i, line in enumerate(lines) if line.split()[1:2] == [name])
        lines[k] = f"{value} {name}"
    path.write_text("\n".join(lines) + "\n")
    flowing = fowtio.solve(fowtio.build(fowtio.load(study)))[0]
    assert flowing.response.offset[0] > 1.0 > abs(calm.response.offset[0])
    assert flowing.response.drag_damping[0, 0] > 2 * calm.response.drag_damping[0, 0]
