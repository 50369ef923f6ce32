"""Rational approximation of frequency responses with common stable poles: vector fitting.

F(s) = sum_k R_k / (s - p_k), complex poles in conjugate pairs, so that the impulse response is real.
References: Gustavsen and Semlyen, IEEE Trans. Power Delivery 14(3), 1999; Gustavsen, ibid. 21(3), 2006 (relaxation);
Deschrijver et al., IEEE Microwave and Wireless Components Letters 18(6), 2008 (one small problem per response).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from model.conventions import freeze

LEAST_DAMPING = 0.01  # of the poles: what rings longer fits noise


@dataclass(frozen=True, eq=False, kw_only=True)
class RationalFit:
    """Common poles (k) [rad/s], one of each conjugate pair, real coefficients (b, c) of their real basis for c responses, and what the
    responses tend to at high frequency: constant (c), real.
    """

    poles: np.ndarray
    coefficients: np.ndarray
    constant: np.ndarray

    def __post_init__(self):
        freeze(self, poles=("k",), coefficients=("b", "c"), constant=("c",))

    @property
    def order(self) -> int:
        """Number of states that one response takes."""
        return len(self.coefficients)

    def __call__(self, omega) -> np.ndarray:
        """Return the responses (n, c) at omega (n) [rad/s]."""
        return partial_fractions(1j * np.asarray(omega, dtype=float), self.poles) @ self.coefficients + self.constant


def partial_fractions(s, poles) -> np.ndarray:
    """Return the real basis (n, b) at s (n) [rad/s]: 1/(s-p) of a real pole; 1/(s-p) + 1/(s-p*) and i/(s-p) - i/(s-p*) of a pair."""
    columns = []
    for p in poles:
        if p.imag == 0:
            columns.append(1 / (s - p.real))
        else:
            one, other = 1 / (s - p), 1 / (s - p.conjugate())
            columns += [one + other, 1j * (one - other)]
    return np.stack(columns, axis=-1)


def realisation(poles) -> tuple[np.ndarray, np.ndarray]:
    """Return A (b, b), block diagonal, and b (b) with (s - A)^-1 b the real basis of `partial_fractions`."""
    poles = np.asarray(poles, dtype=complex)
    size = np.where(poles.imag == 0, 1, 2)
    at = np.cumsum(size) - size
    a, drive, pairs = np.zeros((size.sum(), size.sum())), np.zeros(size.sum()), size == 2
    a[at, at], drive[at] = poles.real, size
    first, second, pair = at[pairs], at[pairs] + 1, poles[pairs]
    a[second, second], a[first, second], a[second, first] = pair.real, pair.imag, -pair.imag
    return a, drive


def frequency_response(a, b, c, omega) -> np.ndarray:
    """Return c (i omega - a)^-1 b (n, p, m) at omega (n) [rad/s] of a state space whose a is block diagonal, as `realisation` makes it:
    with blocks of single poles or pairs its eigenvectors are as good as orthogonal, equal blocks or not.
    """
    poles, vectors = np.linalg.eig(a)
    shares = (c @ vectors).T[:, :, None] * np.linalg.solve(vectors, b + 0j)[:, None, :]
    return np.tensordot(1 / (1j * np.asarray(omega)[:, None] - poles), shares, axes=1)


def starting_poles(order: int, low: float, high: float, real: int) -> np.ndarray:
    """Return poles to start from: `real` slow real ones and weakly damped pairs from low to high [rad/s]."""
    real += (order - real) % 2
    pairs = np.geomspace(low, high, (order - real) // 2)
    return np.concatenate([-np.geomspace(low / 5, 2 * low, real) + 0j, (-0.05 + 1j) * pairs])


def admissible(poles: np.ndarray, kind: str) -> np.ndarray:
    """Return the space (b, f) of coefficients allowed: "proper" all, "fast" those whose responses fall as s^-2 to a constant."""
    count = sum(1 if p.imag == 0 else 2 for p in poles)
    if kind == "proper":
        return np.eye(count)
    return null_space(realisation(poles)[1][None])


def columns(s, poles, space, kind: str) -> np.ndarray:
    """Return the basis (n, f) of the responses of a kind at s (n) [rad/s]: with "fast", the constant comes last."""
    basis = partial_fractions(s, poles) @ space
    return basis if kind == "proper" else np.concatenate([basis, np.ones((len(basis), 1))], axis=1)


def rational(poles, space, free, kind: str) -> RationalFit:
    """Return the fit with coefficients `free` (f, c) of `columns`."""
    if kind == "proper":
        return RationalFit(poles=poles, coefficients=space @ free, constant=np.zeros(free.shape[1]))
    return RationalFit(poles=poles, coefficients=space @ free[:-1], constant=free[-1])


def fit_coefficients(omega, values, weight, poles, kind: str) -> RationalFit:
    """Return the fit of least squares with given poles for values (n, c) complex.

    weight (2, n, c): of real and imaginary parts.
    """
    space = admissible(poles, kind)
    basis = columns(1j * omega, poles, space, kind)
    out = []
    for k in range(values.shape[1]):
        left, right = _split(basis, weight[:, :, k]), _split(values[:, k : k + 1], weight[:, :, k])
        size = np.linalg.norm(left, axis=0)
        out.append(np.linalg.lstsq(left / size, right[:, 0], rcond=None)[0] / size)
    return rational(poles, space, np.stack(out, axis=1), kind)


def relocate(omega, values, weight, poles, kind: str) -> np.ndarray:
    """Return better poles: the zeros of the common denominator that relaxed vector fitting finds, mirrored into stability."""
    basis, space = partial_fractions(1j * omega, poles), admissible(poles, kind)
    wide = np.concatenate([basis, np.ones((len(omega), 1))], axis=1)
    numerator = columns(1j * omega, poles, space, kind)
    rows, energy = [], 0.0
    for k in range(values.shape[1]):
        left = _split(numerator, weight[:, :, k])
        right = _split(-values[:, k : k + 1] * wide, weight[:, :, k])
        energy += np.sum(_split(values[:, k : k + 1], weight[:, :, k]) ** 2)
        triangle = np.linalg.qr(np.concatenate([left / np.linalg.norm(left, axis=0), right], axis=1), mode="r")
        rows.append(triangle[left.shape[1] :, left.shape[1] :])
    relaxed = np.sqrt(energy) / len(omega) * wide.real.sum(axis=0)
    matrix = np.concatenate([*rows, relaxed[None]])
    size = np.linalg.norm(matrix, axis=0)
    target = np.zeros(len(matrix))
    target[-1] = np.sqrt(energy)
    solution = np.linalg.lstsq(matrix / size, target, rcond=None)[0] / size
    a, b = realisation(poles)
    constant = solution[-1] if abs(solution[-1]) > 1e-8 else 1e-8
    return stable(np.linalg.eigvals(a - np.outer(b, solution[:-1]) / constant))


def pole_at(omega: float, decays, poles) -> complex:
    """Return a pole at a frequency [rad/s] with that of the decays (k) [rad/s] that is furthest from the poles there are, relative to itself."""
    choice = -np.asarray(decays) + 1j * omega
    return choice[np.argmax(np.abs(np.asarray(poles)[:, None] - choice).min(axis=0) / -choice.real)]


def orthogonal(basis) -> tuple[np.ndarray, np.ndarray]:
    """Return an orthogonal basis (n, f), real and imaginary parts apart, of a basis (n, b), and the matrix (b, f) back to its coefficients."""
    size = np.linalg.norm(basis, axis=0)
    u, s, vt = np.linalg.svd(np.concatenate([basis.real, basis.imag]) / size, full_matrices=False)
    kept = s > 1e-12 * s[0]
    return u[: len(basis), kept] + 1j * u[len(basis) :, kept], vt[kept].T / s[kept] / size[:, None]


def stable(values) -> np.ndarray:
    """Return poles, one of each pair, mirrored to the left and with at least LEAST_DAMPING of their modulus as decay."""
    values = np.asarray(values, dtype=complex)
    decay = np.maximum(np.abs(values.real), LEAST_DAMPING * np.abs(values))
    real = np.abs(values.imag) < 1e-9 * np.abs(values)
    return np.concatenate([-decay[real] + 0j, (-decay + 1j * values.imag)[~real & (values.imag > 0)]])


def fit(
    omega, values, weight, poles, *, kind: str = "proper", rounds: int = 6, iterations: int = 6, part=None
) -> tuple[RationalFit, float]:
    """Return the fit with the smallest largest error, and that error (weighted).

    Parameters
    ----------
    omega : (n) [rad/s]
    values : (n, c) complex responses
    weight : (2, n, c) of real and imaginary parts for the least squares
    poles : to start from (`starting_poles`)
    kind : "proper", or "fast" for responses that fall as s^-2 to a constant
    rounds : of reweighting, each with `iterations` of pole relocation; points with large errors gain weight, so
        that the largest error falls
    part : (n, c) weight of the error's modulus that is judged; None takes the larger of `weight`
    """
    judge = weight.max(axis=0) if part is None else part
    now, best = weight.copy(), None
    for _ in range(rounds):
        for _ in range(iterations):
            poles = relocate(omega, values, now, poles, kind)
        found = fit_coefficients(omega, values, now, poles, kind)
        error = np.abs(found(omega) - values) * judge
        if best is None or error.max() < best[1]:
            best = found, float(error.max())
        gain = np.sqrt(0.1 * error.max() + error)
        now = now * (gain / gain.mean())
        now *= weight.mean() / now.mean()
    return best


def _split(matrix, weight) -> np.ndarray:
    """Return weighted real parts above weighted imaginary parts: (n, k) with weight (2, n) to (2 n, k)."""
    return np.concatenate([weight[0][:, None] * matrix.real, weight[1][:, None] * matrix.imag])
