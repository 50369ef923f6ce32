"""Multi-blade coordinates against closed forms: blades on a rigid hub, rotating first-order states, inputs and outputs."""

import numpy as np
import pytest

from model.system.linearisation import Linearisation
from model.system.mbc import azimuth_average, blade_groups, blade_matrices, coordinate_labels, to_fixed_frame


def rotor(azimuth: float, blades: int, rate: float, frequency: float = 6.0, damping: float = 0.02) -> Linearisation:
    """Uncoupled blades, each an oscillator in the rotating frame, driven by its own force and measured at its own tip."""
    n = blades
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-(frequency**2) * np.eye(n), -2 * damping * frequency * np.eye(n)]])
    names = [f"ED 1st flapwise bending-mode DOF of blade {b}, m" for b in range(1, n + 1)]
    dofs = tuple(f"blade{b}_flap1" for b in range(1, n + 1))
    return Linearisation(
        A=a, B=np.vstack([np.zeros((n, n)), np.eye(n)]), C=np.hstack([np.eye(n), np.zeros((n, n))]), D=np.zeros((n, n)),
        state_names=tuple(names + ["d " + x for x in names]), input_names=tuple(f"ED Blade {b} X force, node 1, N" for b in range(1, n + 1)),
        output_names=tuple(f"ED TipDxc{b}, (m)" for b in range(1, n + 1)), state_point=np.zeros(2 * n), input_point=(0.0,) * n,
        output_point=(0.0,) * n, state_rotating=np.ones(2 * n), input_rotating=np.ones(n), output_rotating=np.ones(n),
        state_order=np.full(2 * n, 2), state_dof=dofs * 2, state_rate=[0] * n + [1] * n, azimuth=azimuth, rotor_speed=rate,
    )  # fmt: skip


@pytest.mark.parametrize("blades", [3, 4, 5, 6])
def test_whirl_comes_in_pairs_at_plus_and_minus_rotor_speed(blades):
    """A blade mode at w0 appears in the fixed frame as w0 (collective) and |w0 +- k Omega|; exact for uncoupled blades."""
    rate, w0 = 1.3, 6.0
    fixed = to_fixed_frame(rotor(0.7, blades, rate, w0, 0.0), blades)
    found = np.sort(np.linalg.eigvals(fixed.A).imag)
    found = found[found > 0]
    orders = range(1, (blades - 1) // 2 + 1)
    expected = [w0, *(w0 + s * k * rate for k in orders for s in (-1, 1)), *([w0] if blades % 2 == 0 else [])]
    np.testing.assert_allclose(found, np.sort(expected), rtol=1e-9)  # rounding of an eigenvalue solver


@pytest.mark.parametrize("blades", [3, 4, 5])
def test_an_isotropic_rotor_has_one_fixed_frame_model_at_every_azimuth(blades):
    records = [to_fixed_frame(rotor(psi, blades, 1.3), blades) for psi in (0.0, 0.4, 2.9)]
    for name in ("A", "B", "C", "D"):
        for other in records[1:]:
            np.testing.assert_allclose(getattr(other, name), getattr(records[0], name), atol=1e-12)  # rounding


def test_time_history_is_the_same_in_both_frames():
    """Integrate blades in their own frame under a steady fixed-frame force; the transformed model must give the same motion."""
    from scipy.integrate import solve_ivp

    rate, blades = 0.9, 3
    force = np.array([0.3, 1.0, -0.4])  # collective, cosine, sine

    def rotating(t, x):
        record = rotor(rate * t, blades, rate)
        return record.A @ x + record.B @ (blade_matrices(rate * t, blades)[0] @ force)

    fixed = to_fixed_frame(rotor(0.0, blades, rate), blades)
    end, options = 7.0, {"rtol": 1e-10, "atol": 1e-12}
    x = solve_ivp(rotating, (0, end), np.zeros(6), **options).y[:, -1]
    z = solve_ivp(lambda t, s: fixed.A @ s + fixed.B @ force, (0, end), np.zeros(6), **options).y[:, -1]
    one = blade_matrices(rate * end, blades)[0]
    np.testing.assert_allclose(x[:3], one @ z[:3], atol=1e-8)  # integration tolerance times 100


def test_rotor_acceleration_term():
    """With Omega' the transformed stiffness gains T1^-1 Omega' T2; for 3 blades that couples cosine and sine by Omega'."""
    still = to_fixed_frame(rotor(0.2, 3, 0.5), 3).A
    speeding = to_fixed_frame(rotor(0.2, 3, 0.5), 3, rotor_acceleration=0.1).A
    change = speeding - still
    expected = np.zeros_like(change)
    expected[4, 2], expected[5, 1] = -0.1, 0.1  # -T1^-1 T2 Omega'
    np.testing.assert_allclose(change, expected, atol=1e-12)


def test_first_order_rotating_states():
    """A lag of time constant tau on each blade has fixed-frame poles -1/tau and -1/tau +- i Omega."""
    n, tau, rate = 3, 2.0, 1.1
    names = tuple(f"AD lag of blade {b}" for b in (1, 2, 3))
    record = Linearisation(
        A=-np.eye(n) / tau, B=np.zeros((n, 0)), C=np.zeros((0, n)), D=np.zeros((0, 0)), state_names=names, input_names=(), output_names=(),
        state_point=np.zeros(n), input_point=(), output_point=(), state_rotating=np.ones(n), input_rotating=np.zeros(0),
        output_rotating=np.zeros(0), state_order=np.ones(n), state_dof=("",) * n, state_rate=np.zeros(n), azimuth=1.0, rotor_speed=rate,
    )  # fmt: skip
    poles = np.linalg.eigvals(to_fixed_frame(record, 3).A)
    np.testing.assert_allclose(sorted(poles.imag), [-rate, 0, rate], atol=1e-12)
    np.testing.assert_allclose(poles.real, -1 / tau, atol=1e-12)


def test_names_of_coordinates():
    assert coordinate_labels(3) == ("collective", "cosine", "sine")
    assert coordinate_labels(4) == ("collective", "cosine", "sine", "differential")
    fixed = to_fixed_frame(rotor(0.0, 3, 1.0), 3)
    assert fixed.state_dof[:3] == ("flap1_collective", "flap1_cosine", "flap1_sine")


def test_incomplete_groups_are_refused():
    with pytest.raises(ValueError, match="needs 1 to 3"):
        blade_groups(["blade1_flap1", "blade2_flap1"], np.ones(2), 3)
    with pytest.raises(ValueError, match="three blades or more"):
        blade_matrices(0.0, 2)


def test_files_of_different_runs_are_not_averaged():
    with pytest.raises(ValueError, match="files of one run only"):
        azimuth_average([rotor(0.0, 3, 1.0), rotor(0.0, 4, 1.0)], 3)
