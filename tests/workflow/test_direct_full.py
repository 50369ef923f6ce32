"""The direct route on the embedded full-system linearisation (turbine, floater, moorings, infinite-frequency added mass), to which
HydroDyn's states of radiation and excitation are added as HydroDyn adds them: state spaces fitted to the same coefficients."""

from dataclasses import replace

import numpy as np
import pytest

import fowtio
from fowtio.read.openfast_lin import read_openfast_lin
from model.conventions import PLATFORM_DOFS
from model.reduce.excitation import fit_excitation
from model.reduce.radiation import fit_radiation
from model.response.direct import direct_transfer, wave_input
from model.response.loads import channel_response
from model.system.hydro import excitation_at

WAVE = "HD Extended input: wave elevation at platform ref point, m"


@pytest.fixture(scope="module")
def still(oc4):
    """The embedded study without drag, which a linearisation does not have, in white noise with the turbine parked."""
    options = replace(oc4.case.options, drag_model="none")
    return replace(oc4, case=replace(oc4.case, options=options))


@pytest.fixture(scope="module")
def full(oc4, oc4_folder):
    """Return the linearisation with radiation and excitation states, and the delay [s] of its wave input."""
    base = read_openfast_lin(oc4_folder / "linearisation" / "parked" / "main.1.lin")
    hydro = oc4.hydro
    radiation = fit_radiation(hydro, orders=(20,))
    omega = hydro.omega[hydro.omega < 2.5]
    force = excitation_at(hydro, omega, 0.0)
    peak = np.abs(force).max(axis=0)
    weight = np.where(peak > 1e3, 1 / peak, 0.0) * np.ones((len(omega), 1))
    waves = fit_excitation(omega, force, weight, np.ones(len(omega), dtype=bool), orders=(44,), shifts=(16.0,))
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
    ), waves.shift  # fmt: skip


def test_direct_route_is_the_assembled_model(still, full):
    record, shift = full
    state = next(s for s in still.states if s.wind_speed == 0 and s.sea.kind == "white_noise")
    item = fowtio.solve(still, [state])[0]
    channels = channel_response(item.point.outputs, item.response)
    omega = item.response.excitation.omega
    away = np.abs(np.log(omega[:, None] / item.point.modes.frequency_infinite)).min(axis=1) > 0.08
    band = (omega > 0.06) & (omega < 1.2) & away
    for name, unit, tolerance in (
        # the fits are within 1 % of a force's peak; within 8 % of a resonance, which nothing but radiation damps here, their errors and
        # the finite rotation step of the linearisation's own stiffness (0.5 % of C55) count many times over and are left out
        ("PtfmSurge", 1.0, 0.01), ("PtfmHeave", 1.0, 0.01), ("PtfmPitch", np.pi / 180, 0.02), ("TTDspFA", 1.0, 0.01),
    ):  # fmt: skip
        row = next(k for k, n in enumerate(record.output_names) if n.split()[1].rstrip(",") == name)
        direct = direct_transfer(record, omega, wave_input(record), [row])[:, 0] * unit * np.exp(1j * omega * shift)
        own = channels.to_wave[0][:, channels.index(name)]
        weight = np.gradient(omega) * band
        error = np.sqrt((np.abs(direct - own) ** 2 * weight).sum() / (np.abs(own) ** 2 * weight).sum())
        assert error < tolerance, (name, error)
