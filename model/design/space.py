"""The space of designs: variables with bounds and spacing, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

DIMENSIONS = ("diameter", "radius", "draft", "anchor_radius", "line_length")
"""What makes a design: column diameter, platform radius, draft, anchor radius, line length [m]."""


@dataclass(frozen=True, kw_only=True)
class DesignVariable:
    """One dimension that is varied: name (of DIMENSIONS), lower and upper bound [m], spacing [m]; relative_to another dimension whose
    value is added, None for none.
    """

    name: str
    lower: float
    upper: float
    spacing: float
    relative_to: str | None = None

    @property
    def count(self) -> int:
        """Number of values."""
        return round((self.upper - self.lower) / self.spacing) + 1


@dataclass(frozen=True, eq=False, kw_only=True)
class DesignSpace:
    """Variables (v), the dimensions that are fixed [m], and optionally the rule that gives the line length of designs (N, 5) whose
    length is not known.
    """

    variables: tuple[DesignVariable, ...]
    fixed: dict[str, float]
    length_rule: Callable[[np.ndarray], np.ndarray] | None = None

    @property
    def size(self) -> int:
        """Number of designs in the space."""
        return int(np.prod([v.count for v in self.variables]))

    @property
    def counts(self) -> np.ndarray:
        """Number of values of every variable (v)."""
        return np.array([v.count for v in self.variables])

    def designs(self, index) -> np.ndarray:
        """Return the designs (N, 5) in the order of DIMENSIONS [m] at places (N, v) of the grid."""
        index = np.atleast_2d(index)
        out = np.full((len(index), len(DIMENSIONS)), np.nan)
        for name, value in self.fixed.items():
            out[:, DIMENSIONS.index(name)] = value
        ordered = sorted(enumerate(self.variables), key=lambda kv: kv[1].relative_to is not None)
        for k, v in ordered:
            values = v.lower + v.spacing * index[:, k]
            if v.relative_to is not None:
                values = values + out[:, DIMENSIONS.index(v.relative_to)]
            out[:, DIMENSIONS.index(v.name)] = values
        if self.length_rule is not None:
            out[:, -1] = self.length_rule(out)
        return out

    def completed(self, designs) -> np.ndarray:
        """Return designs (N, 5) with the dimensions that are not given (NaN) as the space holds them: fixed, or by its rule."""
        out = np.array(np.atleast_2d(designs), dtype=float)
        for name, value in self.fixed.items():
            column = out[:, DIMENSIONS.index(name)]
            column[np.isnan(column)] = value
        open_length = np.isnan(out[:, -1])
        if self.length_rule is not None and open_length.any():
            out[open_length, -1] = self.length_rule(out[open_length])
        return out

    def places(self, designs) -> np.ndarray:
        """Return the nearest places (N, v) of the grid to designs (N, 5), bounds kept."""
        designs = np.atleast_2d(designs)
        out = np.empty((len(designs), len(self.variables)), dtype=int)
        for k, v in enumerate(self.variables):
            value = designs[:, DIMENSIONS.index(v.name)]
            if v.relative_to is not None:
                value = value - designs[:, DIMENSIONS.index(v.relative_to)]
            out[:, k] = np.clip(np.round((value - v.lower) / v.spacing), 0, v.count - 1)
        return out

    def every(self) -> np.ndarray:
        """Return all places (N, v) of the grid, the last variable running fastest."""
        return np.stack(np.meshgrid(*[np.arange(c) for c in self.counts], indexing="ij"), axis=-1).reshape(-1, len(self.variables))

    def reduced(self, designs) -> DesignSpace:
        """Return the part of the space that just holds some of its designs (N, 5), with the same spacing."""
        places = self.places(designs)
        variables = tuple(
            replace(v, lower=v.lower + v.spacing * int(lo), upper=v.lower + v.spacing * int(hi))
            for v, lo, hi in zip(self.variables, places.min(axis=0), places.max(axis=0), strict=True)
        )
        return replace(self, variables=variables)
