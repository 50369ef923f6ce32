"""An optimisation from its file: what is wrong with a file, the searches, history and resumption, the shipped studies."""

import itertools
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fowtio.errors import CaseError, ModelError
from fowtio.optimise.archive import Archive
from fowtio.optimise.genetic import algorithm_of, evolve
from fowtio.optimise.run import ChunkJudge, optimise, reference_value
from fowtio.optimise.search import pareto_front, polish, search
from fowtio.optimise.setting import reference_of, setting_of, space_of
from fowtio.optimise.study import FrequencyBand, load_optimisation
from fowtio.optimise.workers import workers
from model.design.quantities import Evaluation
from model.design.space import DesignSpace, DesignVariable

SITES = Path(__file__).resolve().parents[2] / "validation" / "sites"
FEW = (FrequencyBand(low=0.003, high=0.07, count=24), FrequencyBand(low=0.08, high=0.6, count=16))


def small(study, **changes):
    """A study with few frequencies and small populations, for tests that do not look at the figures."""
    stages = tuple(replace(s, population=12, generations=2) for s in study.stages)
    return replace(study, bands=FEW, stages=stages, polish=False, **changes)


@pytest.fixture(scope="module")
def tuscany():
    return load_optimisation("tuscany")


def written(tmp_path, change=lambda text: text, name="tuscany"):
    for suffix in (".opt", ".cost"):
        shutil.copyfile(SITES / f"{name}{suffix}", tmp_path / f"{name}{suffix}")
    path = tmp_path / f"{name}.opt"
    path.write_text(change(path.read_text()))
    return path


# --- the file ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["tuscany", "sardinia", "rao_peaks"])
def test_the_shipped_studies_are_read(name):
    study = load_optimisation(name)
    assert len(study.stages) in (3, 9)
    assert study.published
    assert {v.name for v in study.spaces["full"]} == {"diameter", "radius", "draft", "anchor_radius", "line_length"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("CostState ", "CostStat ", "did you mean CostState"),
        ("all      mean_pitch:rated ", "all      mean_pich:rated  ", "did you mean mean_pitch"),
        ("all      mean_pitch:rated ", "all      mean_pitch:storm ", "there are rated"),
        ("ultimate*1.15", "ultimat*1.15", "expected reference or a stage"),
        ("full   diameter ", "full   diamter  ", "did you mean diameter"),
        ("14.0   20.0   0.5 ", "14.0   20.2   0.5 ", "no whole number of steps"),
        ("reduced:pareto ", "reduced:nothing", "no stage before it"),
        (" nsga2 ", " ga    ", "nsga2 two or more"),
        ('"1.15 0.62"', '"1.15"     ', "one number for each of the 2 objectives"),
        ("u09     9.0        B           jonswap ", "u09     9.0        B           jonswop ", "did you mean jonswap"),
        ('"tuscany"    CostFile', '"atlantis"   CostFile', "cost file"),
        ("0.1106", "-0.110", "from 0 to 1"),
        ("<=        5.0", "<         5.0", "expected <= or >="),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_line(tmp_path, old, new, said):
    path = written(tmp_path, lambda text: text.replace(old, new, 1))
    assert new in path.read_text()
    with pytest.raises(CaseError) as caught:
        load_optimisation(path)
    assert said in str(caught.value)
    assert "tuscany.opt, line" in str(caught.value)


def test_everything_wrong_is_said_at_once(tmp_path):
    path = written(tmp_path, lambda t: t.replace("mean_pitch:rated ", "mean_pich:rated ", 1).replace("reduced:pareto", "reduced:parete").replace("25           Life", "0            Life"))
    with pytest.raises(CaseError) as caught:
        load_optimisation(path)
    assert len(caught.value.problems) >= 3


# --- searches on a landscape in closed form ----------------------------------------------------------------------------


def bowl(counts=(13, 31, 25), bound=None):
    """An archive over a grid with f = sum (x - x0)^2 in steps, x0 = (9, 20, 4); sum of steps below `bound` is infeasible."""
    variables = tuple(
        DesignVariable(name=n, lower=0.0, upper=float(c - 1), spacing=1.0) for n, c in zip(("diameter", "radius", "draft"), counts, strict=True)
    )
    space = DesignSpace(variables=variables, fixed={"anchor_radius": 0.0, "line_length": 0.0})

    def judge(designs):
        x = designs[:, :3]
        f = ((x - [9, 20, 4]) ** 2).sum(axis=1)
        g = ((x - [2, 25, 20]) ** 2).sum(axis=1)
        over = np.zeros(len(x)) if bound is None else np.maximum(0.0, bound - x.sum(axis=1))
        return Evaluation(names=("f", "g"), values=np.stack([f, g], axis=1), violation=over, reason=tuple("low" if o else "" for o in over))

    return Archive(space=space, names=("f", "g"), evaluate=judge)


def quiet(text):
    pass


@pytest.mark.parametrize("bound", [None, 38.0])
def test_every_design_and_the_way_downhill_find_the_optimum(bound):
    archive = bowl(bound=bound)
    search(archive, "grid", ("f",), population=0, generations=0, crossover=0, elite=0, seed=1, progress=quiet)
    best = archive.best("f")
    if bound is None:
        assert archive.designs[best][:3].tolist() == [9, 20, 4]
    else:  # on the plane x + y + z = 38, five steps further: 5^2 / 3 shared out is at the least 2^2 + 2^2 + 1^2
        assert archive.value("f", best) == 9
    other = bowl(bound=bound)
    start = other.rows(np.array([[12, 30, 24]]))[0]
    assert other.value("f", polish(other, "f", start, quiet)) == archive.value("f", best)


def test_the_genetic_algorithm_comes_near_and_keeps_its_elite():
    gaps = []
    for seed in range(10):
        archive = bowl()
        search(archive, "ga", ("f",), population=200, generations=5, crossover=0.8, elite=2, seed=seed, progress=quiet)
        best = [archive.value("f", g).min() for g in archive.generations]
        assert all(b <= a for a, b in itertools.pairwise(best))
        assert [len(g) for g in archive.generations] == [200] * 5
        gaps.append(best[-1])
    # of 10,075 designs at most 1,000 are seen; a random search of 1,000 comes to 13 on average
    assert np.mean(gaps) < 2


def test_the_same_seed_gives_the_same_search():
    seen = []
    for _ in range(2):
        archive = bowl()
        search(archive, "nsga2", ("f", "g"), population=40, generations=4, crossover=0.8, elite=0, seed=3, progress=quiet)
        seen.append(archive.places)
    assert (seen[0] == seen[1]).all()


def test_the_front_is_what_nothing_betters():
    archive = bowl()
    archive.rows(archive.space.every())
    front = pareto_front(archive, ("f", "g"), np.arange(0, 10075, 37))
    f, g = archive.value("f", front), archive.value("g", front)
    assert (np.diff(f) >= 0).all()
    assert (np.diff(g) <= 0).all()


def test_crossover_alone_takes_every_variable_from_a_parent():
    members = []
    evolve(
        algorithm_of("ga", 50, 1.0, 0), np.array([5, 5]), 1, 3, 1, lambda p: (p.sum(axis=1, keepdims=True).astype(float), np.zeros(len(p))), members.append
    )
    for before, after in itertools.pairwise(members):
        for k in (0, 1):
            assert set(after[:, k]) <= set(before[:, k])


# --- a study run ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run_once(tuscany, tmp_path_factory):
    folder = tmp_path_factory.mktemp("optimise")
    return folder, optimise(small(tuscany), folder)


def test_stages_build_on_each_other(run_once):
    _, result = run_once
    ultimate, pareto, fatigue = (result.stages[n] for n in ("ultimate", "pareto", "fatigue"))
    assert fatigue.space.size < pareto.space.size
    inside = fatigue.space.designs(fatigue.space.places(pareto.archive.designs[pareto.picks]))
    assert inside == pytest.approx(pareto.archive.designs[pareto.picks])
    limit = next(c.limit for c in fatigue.constraints if c.quantity == "tower_moment:rated")
    assert limit == pytest.approx(1.15 * ultimate.archive.value("tower_moment:rated", ultimate.best))
    cost = next(c.limit for c in ultimate.constraints if c.quantity == "cost")
    assert cost == reference_value(result.reference, "cost")


def test_a_stopped_run_goes_on_to_the_same_result(run_once, tuscany, tmp_path, monkeypatch):
    _, whole = run_once
    saves = []

    class Killed(BaseException):
        pass

    original = Archive.close_generation

    def until_killed(self, rows):
        original(self, rows)
        saves.append(1)
        if len(saves) == 3:
            raise Killed

    monkeypatch.setattr(Archive, "close_generation", until_killed)
    with pytest.raises(Killed):
        optimise(small(tuscany), tmp_path)
    monkeypatch.undo()
    again = optimise(small(tuscany), tmp_path)
    first = again.stages["ultimate"].archive
    assert first.evaluated == 0  # the stage was whole: nothing is solved again
    for name, stage in whole.stages.items():
        other = again.stages[name]
        assert (stage.archive.designs[stage.front] == other.archive.designs[other.front]).all()
        if stage.best is not None:
            assert (stage.optimum == other.optimum).all()
            assert stage.archive.values[stage.best] == pytest.approx(other.archive.values[other.best], rel=0, abs=0, nan_ok=True)


def test_a_finished_run_repeats_itself(tuscany, tmp_path):
    """The history then holds the neighbours of the front too, which the search itself has not seen: they must not change its picks."""
    study = replace(small(tuscany), polish=True)
    first = optimise(study, tmp_path, stages=["pareto"])
    again = optimise(study, tmp_path, stages=["pareto"])
    for name, stage in first.stages.items():
        other = again.stages[name]
        assert other.archive.evaluated == 0
        assert (stage.archive.designs[stage.front] == other.archive.designs[other.front]).all()
        assert (stage.archive.designs[stage.picks] == other.archive.designs[other.picks]).all()


def test_a_history_of_another_study_is_refused(run_once, tuscany):
    folder, _ = run_once
    other = small(tuscany, years=20.0)
    with pytest.raises(ModelError, match="another study or version"):
        optimise(other, folder)


def test_a_full_disk_leaves_the_history_whole(run_once, tuscany, tmp_path, monkeypatch):
    import xarray as xr

    written_whole = xr.Dataset.to_netcdf
    calls = []

    def full(self, *args, **kwargs):
        calls.append(1)
        if len(calls) > 1:
            raise OSError(28, "No space left on device")
        return written_whole(self, *args, **kwargs)

    monkeypatch.setattr(xr.Dataset, "to_netcdf", full)
    with pytest.raises(ModelError, match="No space left"):
        optimise(small(tuscany), tmp_path, stages=["ultimate"])
    monkeypatch.undo()
    assert [p.name for p in (tmp_path / "history").iterdir()] == ["ultimate.nc"]
    again = optimise(small(tuscany), tmp_path, stages=["ultimate"])
    assert (again.stages["ultimate"].optimum == run_once[1].stages["ultimate"].optimum).all()


def test_threads_change_nothing_to_the_bit(run_once, tuscany):
    _, whole = run_once
    with workers(2) as spread:
        other = optimise(small(tuscany), stages=["ultimate"], mapper=spread)
    a, b = whole.stages["ultimate"].archive, other.stages["ultimate"].archive
    assert (a.places[: len(b.places)] == b.places).all()
    assert np.array_equal(a.values[: len(b.values)], b.values, equal_nan=True)


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_to_the_bit(run_once, tuscany):
    distributed = pytest.importorskip("dask.distributed")
    _, whole = run_once
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, workers(cluster=cluster.scheduler_address) as spread:
        other = optimise(small(tuscany), stages=["ultimate"], mapper=spread)
    a, b = whole.stages["ultimate"].archive, other.stages["ultimate"].archive
    assert np.array_equal(a.values[: len(b.values)], b.values, equal_nan=True)


def test_a_cluster_that_is_not_there_is_said():
    pytest.importorskip("dask.distributed")
    with pytest.raises(ModelError, match="no Dask cluster at"), workers(cluster="tcp://127.0.0.1:1"):
        pass


def test_no_feasible_design_says_what_it_fails_at(tuscany):
    from fowtio.optimise.study import ConstraintEntry

    stage = replace(tuscany.stages[0], population=6, generations=1)
    never = ConstraintEntry(stage="all", quantity="metacentric_height", relation=">=", factor=1000.0, of=None, line=1)
    with pytest.raises(ModelError, match="fail at metacentric_height >= 1000"):
        optimise(replace(small(tuscany), stages=(stage,), constraints=(never,)))


def test_extreme_turbulence_of_a_state_is_that_of_a_study(tmp_path):
    """The same words as in a study: an extreme class is stronger than the normal one at the same speed."""
    study = load_optimisation(written(tmp_path, lambda t: t.replace("rated   11.0       B    ", "rated   11.0       ETM-B", 1)))
    extreme, normal = (setting_of(replace(s, bands=FEW)).state("rated") for s in (study, load_optimisation("tuscany")))
    assert (extreme.wind_spectrum > normal.wind_spectrum).all()


def test_a_line_that_is_not_varied_keeps_the_stiffness_of_the_reference():
    study = replace(load_optimisation("rao_peaks"), bands=FEW)
    setting = setting_of(study)
    reference = reference_of(study, setting)
    space = space_of(study, "hull", setting, reference)
    designs = space.designs([[0, 18, 5], [12, 30, 24]])
    names = ("mooring_stiffness",)
    found = ChunkJudge(setting=setting, names=names, constraints=())(designs)
    assert found.values[:, 0] == pytest.approx(reference_value(reference, "mooring_stiffness"), rel=1e-5)


# --- against the source thesis ----------------------------------------------------------------------------------------


def test_published_designs_of_both_sites():
    """Mean pitch and cost of tables 31 to 38: pitch depends on thrust, hydrostatics and ballast, cost on inferred walls."""
    for name in ("tuscany", "sardinia"):
        study = replace(load_optimisation(name), bands=FEW)
        setting = setting_of(study)
        designs = np.array([p.design for p in study.published])
        found = ChunkJudge(setting=setting, names=("mean_pitch:rated", "cost", "mean_surge:rated"), constraints=())(designs)
        pitch = np.array([p.values["mean_pitch:rated"] for p in study.published])
        cost = np.array([p.values["cost"] for p in study.published])
        # the thesis's thrust and ours agree to 1 %, ballast density and steel are inferred: 5 % in pitch, 10 % in cost (as asked of costs)
        assert found.values[:, 0] == pytest.approx(pitch, rel=0.07)
        assert found.values[:, 1] == pytest.approx(cost, rel=0.10)
