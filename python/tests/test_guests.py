# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Callables as solvers and extractors."""

import os

import numpy as np
import pytest

import sightline as sl

NUMERIC = dict(name="cube-noise", trials=4, set={"solvers": ["lspe"]})
IMAGES = dict(name="boeing-random", trials=3, set={"solvers": ["lspe"]})
NUMBERS = ("theta_error_deg", "t_error_percent", "geodesic_deg", "add_m", "tx_m", "nees")


def twin(question):
    """The built-in lspe, by way of Python."""
    return sl.solve(question.points, question.pixels, question.camera, "lspe",
                    sigma=question.sigma, covariance=question.covariance,
                    initial=question.initial)


def rows_of(run, solver):
    columns = run.columns()
    chosen = columns["solver"] == solver
    return {name: values[chosen] for name, values in columns.items()}


def same(a, b):
    return np.array_equal(a, b, equal_nan=True)


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("study", [NUMERIC, IMAGES])
def test_a_callable_stands_beside_the_built_in_ones(here, study, jobs):
    run = sl.Study(**study).run("run", solvers=["lspe", twin, ("mirror", mirrored)], jobs=jobs)
    ours, theirs, wrong = (rows_of(run, name) for name in ("lspe", "twin", "mirror"))
    assert len(ours["trial"]) == len(theirs["trial"]) == len(sl.Study(**study))
    for name in NUMBERS:
        assert same(ours[name], theirs[name]), name
        is_of_translation = name in ("t_error_percent", "tx_m")  # which the mirror leaves
        assert is_of_translation or name == "nees" or not same(ours[name], wrong[name])
    assert run.errors == []
    assert [cell["solver"] for cell in run.summary["cells"]][:3] == ["lspe", "twin", "mirror"]
    assert "twin" in run.report.html


def mirrored(question):
    pose = twin(question).cam_from_target
    turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    return pose @ turn


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_callable_that_raises_is_a_failed_trial(here, capfd, jobs):
    def fragile(question):
        if question.trial.trial % 2 == 1:
            raise RuntimeError(f"no pose\nof trial {question.trial.trial}")
        return twin(question)

    run = sl.Study(**NUMERIC).run("run", solvers=["lspe", fragile], jobs=jobs)
    rows = rows_of(run, "fragile")
    expected = np.where(rows["trial"] % 2 == 1, "raised an error", "ok")
    assert (rows["status"] == expected).all()
    assert np.isnan(rows["add_m"][rows["trial"] % 2 == 1]).all()
    assert (rows_of(run, "lspe")["status"] == "ok").all()
    failures = sum(c["failures"] for c in run.summary["cells"] if c["solver"] == "fragile")
    assert failures == (expected != "ok").sum() == len(run.errors)
    text = "solver fragile: trial 1: raised an error: RuntimeError: no pose of trial 1"
    assert text in run.errors
    assert "failed answers of callables, the first: solver fragile" in capfd.readouterr().err


@pytest.mark.parametrize("answer, status", [
    (None, "no estimate"),
    ("pose", "answer unreadable"),
    (np.eye(3), "answer unreadable"),
    (np.full((4, 4), np.nan), "answer unreadable"),
    (np.diag([1.0, 1, -1, 1]), "not rigid"),
    ((np.full((3, 3), np.nan), np.zeros(3)), "not rigid"),
    (sl.PoseEstimate("degenerate"), "degenerate"),
    (sl.PoseEstimate("tired"), "answer unreadable"),
    (sl.PoseEstimate("ok", np.eye(4), removed=(99,)), "answer unreadable"),
    ((np.eye(3), [0, 0, 20]), "ok"),
])
def test_answers_that_are_none(here, answer, status):
    run = sl.Study(**NUMERIC).run("run", solvers=[("guest", lambda question: answer)])
    assert set(run.columns()["status"]) == {status}
    assert bool(run.errors) == (status == "answer unreadable")


def test_what_a_callable_says_of_removals_and_covariance_counts(here):
    def weighed(question):
        return sl.solve(question.points, question.pixels, question.camera, "orpe_weighed",
                        sigma=question.sigma)

    study = sl.Study("cube-outliers", trials=2, set={"solvers": ["orpe_weighed"]})
    run = study.run("run", solvers=["orpe_weighed", weighed])
    ours, theirs = rows_of(run, "orpe_weighed"), rows_of(run, "weighed")
    assert any(ours["removed"])
    for name in ("removed", "false_removals", "missed_outliers", "nees", "removed_probability"):
        assert (ours[name] == theirs[name]).all(), name


def test_questions_say_all_that_is_known(here):
    seen = []

    def curious(question):
        seen.append(question)

    study = sl.Study(**IMAGES)
    study.run("run", solvers=[curious])
    question = seen[0]
    assert len(seen) >= len(study)  # and once more for the report's frames
    assert question.points.shape == (len(question.features), 3)
    assert question.pixels.shape == (len(question.features), 2)
    assert question.covariance.shape == (len(question.features), 2, 2)
    assert question.initial.shape == (4, 4) and question.sigma is None
    assert question.trial == sl.TrialName(trial=0, scene_id=0, im_id=0, gt_id=0)
    target = sl.target("boeing707")
    places = dict(zip(target.features, target.points))
    assert all(same(places[n], p) for n, p in zip(question.features, question.points))


def predicted(question):
    assert question.image.dtype == np.uint8 and question.image.ndim == 2
    assert not question.image.flags.writeable and question.white == 255
    assert question.image.shape == (question.camera.height_px, question.camera.width_px)
    return {n: (*p, 3.0) for n, p in zip(question.features, question.predicted)}


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_extractor_has_cells_of_its_own(here, jobs):
    run = sl.Study(**IMAGES).run("run", extractor=["by_kind", predicted], jobs=jobs)
    columns = run.columns()
    assert list(columns["extractor"][:2]) == ["by_kind", "predicted"]
    ours = columns["extractor"] == "predicted"
    # The prior's own pixels fit the prior's pose, and err as it does.
    assert columns["reprojection_rms_px"][ours].max() < 1e-6
    assert columns["reprojection_rms_px"][~ours].min() > 1e-3
    assert (columns["geodesic_deg"][ours] > 0.01).all()
    frames = [frame for frame in sl.Study(**IMAGES).frames()]
    observations = run.observations()
    assert set(observations["status"]) >= {"found"}
    assert len(frames) == 3


@pytest.mark.parametrize("answer, status", [
    (lambda q: 1 / 0, "raised an error"),
    (lambda q: None, "no estimate"),
    (lambda q: {"nose_cone": (1, 2)}, "answer unreadable"),
    (lambda q: {q.features[0]: (1, 2, -1)}, "ok?"),
    (lambda q: np.zeros((1, 2)), "answer unreadable"),
    (lambda q: {}, "too_few_points"),
    (lambda q: np.full((len(q.features), 2), np.nan), "too_few_points"),
])
def test_answers_of_extractors(here, answer, status):
    run = sl.Study(**IMAGES).run("run", extractor=("net", answer))
    if status == "ok?":  # a sigma's sign means nothing: its square counts
        status = "too_few_points"
    assert set(run.columns()["status"]) == {status}
    assert bool(run.errors) == (status in ("raised an error", "answer unreadable"))


def test_callables_need_names_of_their_own(here):
    study = sl.Study(**NUMERIC)
    with pytest.raises(sl.InputError, match=r"name is '<lambda>', must be letters.*give a pair"):
        study.run("x", solvers=[lambda q: None])
    with pytest.raises(sl.InputError, match="the name 'orpe' is another's already"):
        study.run("x", solvers=[("orpe", twin)])
    with pytest.raises(sl.InputError, match="the name 'twin' is another's already"):
        study.run("x", solvers=[twin, twin])
    with pytest.raises(sl.InputError, match="neither a name nor a callable"):
        study.run("x", solvers=[3])
    with pytest.raises(sl.InputError, match=r'holds "lsep" \(did you mean'):
        study.run("x", solvers=["lsep", twin])
    with pytest.raises(sl.InputError, match="extractors"):
        study.run("x", extractor=("net", predicted))  # has no images
    assert os.listdir(here) == []


def test_what_ends_a_program_ends_the_run(here):
    def impatient(question):
        raise KeyboardInterrupt

    def leaving(question):
        raise SystemExit(3)

    with pytest.raises(KeyboardInterrupt):
        sl.Study(**NUMERIC).run("x", solvers=[impatient])
    with pytest.raises(SystemExit):
        sl.Study(**NUMERIC).run("x", solvers=[leaving])
    assert os.listdir(here) == []


def test_the_program_reads_what_callables_made(here, program):
    run = sl.Study(**IMAGES).run("run", solvers=["lspe", twin], extractor=("net", predicted))
    before = (run.path / "results.csv").read_bytes()
    outcome = program("report", "run")
    assert outcome.returncode == 0, outcome.stderr
    assert (run.path / "results.csv").read_bytes() == before
    assert program("compare", "run", "run").returncode == 0
    again = program("study", "run/study.toml", "--out", "again")
    assert again.returncode == 1
    assert "functions.solvers" in again.stderr and '"twin"' in again.stderr
    assert not (here / "again").exists()
