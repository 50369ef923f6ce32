"""The direct route on the embedded full-system linearisation (turbine, floater, moorings, infinite-frequency added mass), to which
HydroDyn's states of radiation and excitation are added as HydroDyn adds them: state spaces fitted to the same coefficients."""

from dataclasses import replace

import numpy as np
import pytest

import fowtio
from fowtio.fmu.build import linearise
from fowtio.read.openfast_lin import read_openfast_lin
from model.conventions import PLATFORM_DOFS
from model.response.direct import direct_transfer, wave_input
from model.response.loads import channel_response

WAVE = "HD Extended input: wave elevation at platform ref point, m"


@pytest.fixture(scope="module")
def still(oc4):
    """The embedded study without drag, which a linearisation does not have, in white noise with the turbine parked."""
    options = replace(oc4.case.options, drag_model="none")
    return replace(oc4, case=replace(oc4.case, options=options))


@pytest.fixture(scope="module")
def full(still, oc4_folder):
    """Return the linearisation with radiation and excitation states, the delay [s] of its wave input, and the fits' error."""
    base = read_openfast_lin(oc4_folder / "linearisation" / "parked" / "main.1.lin")
    fits = linearise(still, "white_noise")
    radiation, waves = fits.radiation, fits.excitation
    names = [f"ED Platform {axis} {kind}, node 1" for kind in ("force", "moment") for axis in "XYZ"]
    push = base.B[:, [next(k for k, n in enumerate(base.input_names) if n.startswith(name)) for name in names]]
    speed = np.zeros((6, len(base.A)))
    for k, dof in enumerate(PLATFORM_DOFS):
        speed[k, next(j for j, (d, r) in enumerate(zip(base.state_dof, base.state_rate, strict=True)) if d == dof and r)] = 1
    r, e, n = len(radiation.a), len(waves.a), len(base.A)
    a = np.block([
        [base.A, -push @ radiation.c, push @ waves.c], [radiation.b @ speed, radiation.a, np.zeros((r, e))], [np.zeros((e, n + r)), waves.a],
    ])  # fmt: skip
    grown = np.zeros(r + e)
    return replace(
        base, A=a, B=np.concatenate([np.zeros(n + r), waves.b])[:, None], C=np.hstack([base.C, np.zeros((len(base.C), r + e))]),
        D=np.zeros((len(base.C), 1)), input_names=(WAVE,), input_point=(0.0,), input_rotating=[0],
        state_names=(*base.state_names, *[f"HD Rdtn{k}" for k in range(r)], *[f"HD Exctn{k}" for k in range(e)]),
        state_point=np.append(base.state_point, grown), state_rotating=np.append(base.state_rotating, grown),
        state_order=np.append(base.state_order, grown + 1), state_dof=(*base.state_dof, *[""] * (r + e)),
        state_rate=[*base.state_rate, *[0] * (r + e)],
    ), waves.shift, waves.worst  # fmt: skip


def test_direct_route_is_the_assembled_model(still, full):
    record, shift, worst = full
    state = next(s for s in still.states if s.wind_speed == 0 and s.sea.kind == "white_noise")
    item = fowtio.solve(still, [state])[0]
    channels = channel_response(item.point.outputs, item.response)
    omega = item.response.excitation.omega
    away = np.abs(np.log(omega[:, None] / item.point.modes.frequency_infinite)).min(axis=1) > 0.08
    band = (omega > 0.06) & (omega < 1.2) & away
    assert worst < 0.02
    # the fits say their own error, the largest of any response; the finite rotation step of the linearisation's own stiffness adds 0.5 %
    # (of C55); within 8 % of a resonance, which nothing but radiation damps here, both count many times over and are left out
    for name, unit in (("PtfmSurge", 1.0), ("PtfmHeave", 1.0), ("PtfmPitch", np.pi / 180), ("TTDspFA", 1.0)):
        row = next(k for k, n in enumerate(record.output_names) if n.split()[1].rstrip(",") == name)
        direct = direct_transfer(record, omega, wave_input(record), [row])[:, 0] * unit * np.exp(1j * omega * shift)
        own = channels.to_wave[0][:, channels.index(name)]
        weight = np.gradient(omega) * band
        error = np.sqrt((np.abs(direct - own) ** 2 * weight).sum() / (np.abs(own) ** 2 * weight).sum())
        assert error < worst + 0.005, (name, error)
