"""What a search has evaluated: every design once, kept on disk after every generation so that a stopped run goes on."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fowtio.errors import ModelError
from fowtio.write.atomic import atomic_file
from model.design.quantities import Constraint, Evaluation
from model.design.space import DIMENSIONS, DesignSpace

CHUNK = 50
"""Designs evaluated together: a constant, so that results do not depend on how many processors share them."""


@dataclass(eq=False, kw_only=True)
class Archive:
    """The evaluations of one stage: places (N, v) of designs in its space, their dimensions (N, 5) [m], quantities, violation and
    reason; generations, rows of the archive that each generation's members are; visited, rows asked for in this run, whether they were
    known from the file or not; path of the file, None to keep nothing; digest of everything that results depend on.
    """

    space: DesignSpace
    names: tuple[str, ...]
    evaluate: Callable[[np.ndarray], Evaluation]
    digest: str = ""
    path: Path | None = None
    places: np.ndarray = field(init=False)
    designs: np.ndarray = field(init=False)
    values: np.ndarray = field(init=False)
    violation: np.ndarray = field(init=False)
    reason: list[str] = field(default_factory=list)
    generations: list[np.ndarray] = field(default_factory=list)
    known: dict[bytes, int] = field(default_factory=dict)
    evaluated: int = 0
    visited: set[int] = field(default_factory=set)

    def __post_init__(self):
        v, k = len(self.space.variables), len(self.names)
        self.places, self.designs = np.zeros((0, v), dtype=int), np.zeros((0, len(DIMENSIONS)))
        self.values, self.violation = np.zeros((0, k)), np.zeros(0)
        if self.path is not None and self.path.is_file():
            self._load()

    def rows(self, places) -> np.ndarray:
        """Return the rows (N) of designs at places (N, v), evaluating those that are not known yet."""
        places = np.asarray(places, dtype=int)
        keys = [p.tobytes() for p in places]
        new = list(dict.fromkeys(k for k in keys if k not in self.known))
        if new:
            at = np.array([np.frombuffer(k, dtype=places.dtype) for k in new])
            designs = self.space.designs(at)
            self._add(at, designs, self.evaluate(designs))
            self.evaluated += len(new)
        found = np.array([self.known[k] for k in keys])
        self.visited.update(found.tolist())
        return found

    def close_generation(self, rows) -> None:
        """Note the members of a generation and write the archive."""
        self.generations.append(np.asarray(rows))
        self.save()

    def value(self, name: str, rows=slice(None)) -> np.ndarray:
        """Return a quantity of rows."""
        return self.values[rows, self.names.index(name)]

    @property
    def feasible(self) -> np.ndarray:
        """Whether each design (N) keeps all constraints."""
        return self.violation == 0

    def best(self, name: str, rows=None) -> int | None:
        """Return the row of the feasible design with the smallest value of a quantity, None when none is feasible."""
        rows = np.arange(len(self.violation)) if rows is None else np.asarray(rows)
        rows = rows[self.feasible[rows]]
        return int(rows[np.argmin(self.value(name, rows))]) if len(rows) else None

    def _add(self, places, designs, found: Evaluation) -> None:
        for k, place in enumerate(places):
            self.known[place.tobytes()] = len(self.violation) + k
        columns = [found.names.index(n) for n in self.names]
        self.places, self.designs = np.concatenate([self.places, places]), np.concatenate([self.designs, designs])
        self.values = np.concatenate([self.values, found.values[:, columns]])
        self.violation = np.concatenate([self.violation, found.violation])
        self.reason += found.reason

    def save(self) -> None:
        """Write the archive to its file, whole or not at all."""
        if self.path is None:
            return
        import xarray as xr

        members = np.concatenate([np.stack([np.full(len(g), k), g], axis=1) for k, g in enumerate(self.generations)]) if self.generations else np.zeros((0, 2), int)
        data = xr.Dataset(
            {
                "place": (("design", "variable"), self.places), "dimension": (("design", "name_of_dimension"), self.designs, {"units": "m"}),
                "value": (("design", "quantity"), self.values), "violation": ("design", self.violation),
                "reason": ("design", np.array(self.reason, dtype=str) if self.reason else np.zeros(0, dtype="U1")), "member": (("entry", "generation_and_design"), members),
            },
            coords={"variable": [v.name for v in self.space.variables], "name_of_dimension": list(DIMENSIONS), "quantity": list(self.names)},
            attrs={"title": "designs evaluated by fowtio optimise", "digest": self.digest},
        )  # fmt: skip
        try:
            with atomic_file(self.path) as temporary:
                data.to_netcdf(temporary, engine="h5netcdf")
        except OSError as error:
            raise ModelError(f"{self.path}: the history cannot be written ({error.strerror or error}); what was written before is whole") from None

    def _load(self) -> None:
        import xarray as xr

        try:
            with xr.open_dataset(self.path, engine="h5netcdf") as data:
                data = data.load()
        except (OSError, ValueError) as error:
            raise ModelError(f"{self.path}: not a readable history ({error}); remove it or give another folder") from None
        if data.attrs.get("digest") != self.digest or tuple(data["quantity"].values) != self.names:
            raise ModelError(
                f"{self.path}: the history belongs to another study or version (its file, cost file, coefficients or fowtio changed); "
                "give another folder with -o, or --fresh to begin anew"
            )
        found = Evaluation(
            names=self.names, values=data["value"].values, violation=data["violation"].values, reason=tuple(str(r) for r in data["reason"].values)
        )
        self._add(data["place"].values.astype(int), data["dimension"].values, found)


def in_chunks(evaluate_chunk: Callable[[np.ndarray], Evaluation], designs: np.ndarray, run: Callable) -> Evaluation:
    """Return the evaluation of designs in chunks of constant size; run maps a function over chunks."""
    parts = list(run(evaluate_chunk, [designs[k : k + CHUNK] for k in range(0, len(designs), CHUNK)]))
    return Evaluation(
        names=parts[0].names, values=np.concatenate([p.values for p in parts]), violation=np.concatenate([p.violation for p in parts]),
        reason=tuple(r for p in parts for r in p.reason),
    )  # fmt: skip


def failed_constraints(archive: Archive, constraints: Sequence[Constraint] = ()) -> list[tuple[str, int]]:
    """Return what designs failed at first and how many, the most frequent first; constraints are told with their limits."""
    bounds = {(c.quantity, f"{c.relation} {c.limit:.4g}"): f"{c.quantity} {c.relation} {c.limit:.4g}" for c in constraints}
    counts: dict[str, int] = {}
    for text in archive.reason:
        if text:
            quantity, bound = text.split(" ")[0], " ".join(text.partition(" is not ")[2].split(" ")[:2])
            key = bounds.get((quantity, bound), quantity) if bound else re.sub(r"-?\d[\d.e+-]*", "..", text)
            counts[key] = counts.get(key, 0) + 1
    return sorted(counts.items(), key=lambda kv: -kv[1])
