"""Inertia and buoyancy of members outside the potential flow: closed forms, Archimedes, long waves, differences of the force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.conventions import point_motion, rotation
from model.environment.airy import wavenumber
from model.system.hydro import excitation_at, of_members, with_members
from model.system.morison import (
    InertiaElements,
    added_mass_of,
    buoyancy,
    joint_end,
    strips,
    wave_force_on,
)

RHO, G, DEPTH = 1025.0, 9.81, 100.0
WATER = {"density": RHO, "gravity": G, "depth": DEPTH}


def body(start, end, diameter, *, ca=1.0, cp=1.0, axial=0.0, end_pressure=1.0, ends=(True, True)) -> InertiaElements:
    """One closed member: diameter one number or (2); axial the added mass of its ends."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    d = np.broadcast_to(np.asarray(diameter, float), 2)
    k = (end - start) / np.linalg.norm(end - start)
    pair = np.ones(2)
    parts = [
        strips(start, end, d, added=ca * pair, pressure=cp * pair, axial_added=axial * pair, axial_pressure=end_pressure * pair, density=RHO)
    ]
    for place, out, size, there in ((start, -k, d[0], ends[0]), (end, k, d[1], ends[1])):
        if there and place[2] <= 0:
            found = joint_end(out * np.pi * size**2 / 4, out * np.pi * size**3 / 12, added=axial, pressure=end_pressure, density=RHO)
            parts.append((place[None], *(x[None] for x in found)))
    position, added, inertia, area = (np.concatenate(c) for c in zip(*parts, strict=True))
    volume, centre, stiffness = buoyancy(start, end, d, density=RHO, gravity=G)
    return InertiaElements(
        position=position, added_mass=added, inertia=inertia, pressure_area=area, names=("1",), volume=volume, centre=centre,
        stiffness=stiffness,
    )  # fmt: skip


def test_added_mass_of_a_vertical_cylinder():
    # strip theory: m = rho Ca pi R^2 per length over the draught T, half a sphere below
    radius, draught, ca, axial = 4.0, 30.0, 0.97, 0.6
    a = added_mass_of(body((0, 0, -draught), (0, 0, 10), 2 * radius, ca=ca, axial=axial))
    m = RHO * ca * np.pi * radius**2
    expected = np.diag([m * draught, m * draught, axial * RHO * 2 / 3 * np.pi * radius**3, m * draught**3 / 3, m * draught**3 / 3, 0])
    expected[0, 4] = expected[4, 0] = -m * draught**2 / 2
    expected[1, 3] = expected[3, 1] = m * draught**2 / 2
    np.testing.assert_allclose(a, expected, rtol=1e-12, atol=1e-6 * m)  # two Gauss points integrate z^2 exactly


def test_wave_force_on_a_vertical_cylinder():
    # integral of cosh k(z+h) over the draught; dynamic pressure and acceleration at the bottom
    radius, draught, ca, axial = 4.0, 30.0, 0.97, 0.6
    omega = np.array([0.05, 0.2, 0.5, 1.0, 1.5])
    k = wavenumber(omega, DEPTH, G)
    area = np.pi * radius**2
    sway = 1j * omega**2 * RHO * (1 + ca) * area / k * (1 - np.sinh(k * (DEPTH - draught)) / np.sinh(k * DEPTH))
    vertical = -(omega**2) * np.sinh(k * (DEPTH - draught)) / np.sinh(k * DEPTH)
    heave = RHO * G * area * np.cosh(k * (DEPTH - draught)) / np.cosh(k * DEPTH) + axial * RHO * 2 / 3 * np.pi * radius**3 * vertical
    elements = body((0, 0, -draught), (0, 0, 10), 2 * radius, ca=ca, axial=axial)
    for angle in (0.0, 0.7, np.pi):
        x = wave_force_on(elements, omega, angle, **WATER)
        # 4 m panels, two Gauss points: error (k 4 m)^4 / 4320 of the top panel, 2e-4 at 1.5 rad/s
        np.testing.assert_allclose(x[:, 0], sway * np.cos(angle), rtol=3e-4, atol=1e-3)
        np.testing.assert_allclose(x[:, 1], sway * np.sin(angle), rtol=3e-4, atol=1e-3)
        np.testing.assert_allclose(x[:, 2], heave, rtol=1e-12)
        np.testing.assert_allclose(x[:, 5], 0, atol=1e-3)


def test_moment_on_a_vertical_cylinder_in_deep_water():
    # m omega^2 i * integral of z e^{kz} from -T to 0
    radius, draught = 3.0, 25.0
    omega = np.array([0.4, 0.8, 1.2])
    k = omega**2 / G
    e = np.exp(-k * draught)
    arm = -(1 - e) / k**2 + draught * e / k
    elements = body((0, 0, -draught), (0, 0, 5), 2 * radius, ca=1.0)
    x = wave_force_on(elements, omega, 0.0, density=RHO, gravity=G, depth=np.inf)
    np.testing.assert_allclose(x[:, 4], 2j * RHO * np.pi * radius**2 * omega**2 * arm, rtol=3e-4)  # panels, as above


def test_horizontal_pontoon():
    # along x at depth z: nothing along its axis with open ends, sinc(k L/2) of the crosswise force in waves along it
    length, z, d, ca = 40.0, -15.0, 3.0, 1.0
    elements = body((-length / 2, 0, z), (length / 2, 0, z), d, ca=ca, ends=(False, False))
    m = RHO * np.pi * d**2 / 4
    a = added_mass_of(elements)
    np.testing.assert_allclose(np.diag(a), m * ca * np.array([0, length, length, length * z**2, length**3 / 12, length**3 / 12]), rtol=1e-12, atol=1e-6)
    omega = np.array([0.3, 0.7, 1.1])
    k = wavenumber(omega, DEPTH, G)
    vertical = -(omega**2) * np.sinh(k * (DEPTH + z)) / np.sinh(k * DEPTH)
    x = wave_force_on(elements, omega, np.array([0.0, np.pi / 2]), **WATER)
    whole = m * (1 + ca) * length * vertical
    np.testing.assert_allclose(x[0, :, 2], whole * np.sinc(k * length / 2 / np.pi), rtol=1e-4)  # panels of 4 m, k 4 m < 0.5
    np.testing.assert_allclose(x[1, :, 2], whole, rtol=1e-12)
    np.testing.assert_allclose(x[0, :, :2], 0, atol=1e-3)


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(*[st.floats(-20, 20)] * 2, st.floats(-60, -20)), st.tuples(*[st.floats(-10, 10)] * 3).filter(lambda v: np.linalg.norm(v) > 3),
    st.floats(1, 5), st.floats(1, 5), st.floats(-3, 3),
)
def test_submerged_member_feels_archimedes_in_long_waves(centre, half, d0, d1, heading):
    # Froude-Krylov alone: the force of the undisturbed pressure is rho V times the water's acceleration when waves are long
    centre, half = np.array(centre), np.array(half)
    elements = body(centre - half, centre + half, (d0, d1), ca=0.0)
    omega = np.array([0.05])
    x = wave_force_on(elements, omega, heading, density=RHO, gravity=G, depth=np.inf)[0]
    middle = elements.centre
    k = omega[0] ** 2 / G
    acceleration = omega[0] ** 2 * np.exp(k * middle[2]) * np.array([1j * np.cos(heading), 1j * np.sin(heading), -1.0])
    acceleration *= np.exp(-1j * k * (middle[0] * np.cos(heading) + middle[1] * np.sin(heading)))
    expected = RHO * elements.volume * acceleration
    # k times the member's length is 5e-3; a cone's sides are integrated by two points a panel
    np.testing.assert_allclose(x[:3], expected, atol=2e-3 * np.abs(expected).max())
    np.testing.assert_allclose(x[3:], np.cross(middle, expected), atol=4e-3 * np.abs(expected).max() * (10 + np.linalg.norm(middle)))


def test_long_waves_lift_as_hydrostatics_do():
    # at zero frequency a crest everywhere is a heave of the water by 1 m: the force is the stiffness in heave
    columns = [body((x, y, -20), (x, y, 10), (9, 6)) for x, y in ((-20, 0), (10, 15), (10, -18))]
    for elements in columns:
        x = wave_force_on(elements, np.array([1e-3]), 0.4, **WATER)[0]
        np.testing.assert_allclose(x[:5].real, elements.stiffness[:5, 2], rtol=1e-3, atol=1e3)


@pytest.mark.parametrize(
    ("start", "end", "diameter", "tolerance"),
    [
        ((3, -2, -20), (3, -2, 8), (6, 6), 1e-6),  # upright
        ((5, 1, -20), (13, -6, 12), (6, 6), 1e-6),  # leaning through still water
        ((13, -6, 12), (5, 1, -20), (6, 6), 1e-6),  # the same, the other way round
        ((-4, 2, -18), (9, 5, -6), (3, 5), 1e-6),  # a cone under water
        ((2, 2, -20), (2, 2, 10), (10, 4), 2e-2),  # an upright cone through still water: its taper at the water line is left out
    ],
)
def test_buoyancy_stiffness_is_the_difference_of_the_force(start, end, diameter, tolerance):
    def force(q):
        turn = rotation(q[3:])
        a, b = (q[:3] + turn @ np.asarray(p, float) for p in (start, end))
        volume, centre, _ = buoyancy(a, b, diameter, density=RHO, gravity=G)
        lift = np.array([0, 0, RHO * G * volume])
        return np.concatenate([lift, np.cross(centre - q[:3], lift)])

    stiffness = buoyancy(start, end, diameter, density=RHO, gravity=G)[2]
    step = 1e-4
    numeric = np.stack([(force(-step * e) - force(step * e)) / (2 * step) for e in np.eye(6)], axis=1)
    assert np.abs(stiffness - numeric).max() < tolerance * np.abs(numeric).max()


def test_volume_and_centre_of_a_leaning_cylinder():
    # by counting 160^3 cells of equal volume that lie below still water
    start, end, d = np.array([5.0, 1.0, -20.0]), np.array([13.0, -6.0, 12.0]), 6.0
    volume, centre, _ = buoyancy(start, end, (d, d), density=RHO, gravity=G)
    k = (end - start) / np.linalg.norm(end - start)
    u = np.cross(k, [0, 0, 1.0]) / np.linalg.norm(np.cross(k, [0, 0, 1.0]))
    v = np.cross(k, u)
    n = 160
    s = (np.arange(n) + 0.5) / n * np.linalg.norm(end - start)
    r = np.sqrt((np.arange(n) + 0.5) / n) * d / 2
    phi = (np.arange(n) + 0.5) / n * 2 * np.pi
    offset = (r[:, None, None] * (np.cos(phi)[:, None] * u + np.sin(phi)[:, None] * v)).reshape(-1, 3)
    cell = np.linalg.norm(end - start) * np.pi * d**2 / 4 / n**3
    total, moment = 0.0, np.zeros(3)
    for place in s:
        wet = (offset + start + place * k)[(offset + start + place * k)[:, 2] < 0]
        total, moment = total + cell * len(wet), moment + cell * wet.sum(axis=0)
    assert volume == pytest.approx(total, rel=1e-3)  # cells of 0.2 m along a member of 21 m under water
    np.testing.assert_allclose(centre, moment / total, atol=5e-3)  # half a cell weighed by the cut's share, metres


def test_members_are_added_once_and_exactly():
    potential = of_members(body((0, 0, -20), (0, 0, 5), 8.0), **WATER)
    with pytest.raises(ValueError, match="once"):
        with_members(potential, body((5, 0, -20), (5, 0, 5), 2.0))
    elements = body((10, 3, -25), (10, 3, 5), 2.0)
    bare = of_members(elements, **WATER)
    omega = np.array([0.013, 0.4321, 5.0])  # below, between and above the listed frequencies
    np.testing.assert_array_equal(
        excitation_at(bare, omega, np.array([0.2])), wave_force_on(elements, omega, np.array([0.2]), **WATER)
    )
    hydrostatic = excitation_at(bare, omega, np.array([0.2]), low_frequency="hydrostatic")
    np.testing.assert_array_equal(hydrostatic, excitation_at(bare, omega, np.array([0.2])))  # its limit is in it already


def test_turning_the_member_with_the_waves_turns_the_force():
    elements = body((12, 3, -25), (4, 9, 5), 3.0, axial=0.7)
    turn = rotation([0, 0, 0.8])
    turned = body(turn @ (12, 3, -25), turn @ (4, 9, 5), 3.0, axial=0.7)
    omega = np.array([0.3, 0.9])
    a, b = wave_force_on(elements, omega, 0.1, **WATER), wave_force_on(turned, omega, 0.9, **WATER)
    big = np.kron(np.eye(2), turn)
    np.testing.assert_allclose(b, a @ big.T, rtol=1e-9, atol=1e-6 * np.abs(a).max())
    np.testing.assert_allclose(added_mass_of(turned), big @ added_mass_of(elements) @ big.T, atol=1e-9 * added_mass_of(elements).max())


def test_added_mass_is_its_elements_kinetic_energy():
    elements = body((12, 3, -25), (4, 9, 5), (3.0, 2.0), axial=0.7)
    q = np.array([0.3, -0.2, 0.5, 0.01, 0.02, -0.03])
    speed = point_motion(elements.position) @ q
    energy = np.einsum("sa,sab,sb->", speed, elements.added_mass, speed) / 2
    assert q @ added_mass_of(elements) @ q / 2 == pytest.approx(energy, rel=1e-12)
