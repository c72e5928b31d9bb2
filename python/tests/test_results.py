# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
import csv
import os
import xml.etree.ElementTree

import numpy as np
import pytest

import sightline as sl


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run, the same again, and one with three times the noise."""
    folder = tmp_path_factory.mktemp("runs")

    def run(name, **keys):
        study = sl.Study("cube-noise", trials=40, set={"solvers": ["orpe", "lspe"], **keys})
        return study.run(folder / name)

    return run("base"), run("same"), run("worse", **{"noise.scale": 3})


def test_columns_are_results_csv(runs):
    columns = runs[0].columns()
    with open(runs[0].path / "results.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(columns) == list(rows[0])
    assert len({len(values) for values in columns.values()}) == 1
    assert columns["trial"].dtype == np.int64 and columns["found"].dtype == np.int64
    assert columns["geodesic_deg"].dtype == columns["noise_px"].dtype == np.float64
    assert columns["solver"].dtype == columns["removed"].dtype == object
    for name in ("geodesic_deg", "true_tz_m", "noise_px"):
        assert columns[name].tolist() == [float(row[name]) for row in rows]
    assert np.isnan(columns["removed_probability"]).all()  # that these solvers do not state
    assert columns["removed"].tolist() == [row["removed"] for row in rows]


def test_pandas_takes_them(runs):
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(runs[0].columns())
    assert len(table) == len(runs[0].columns()["trial"])
    assert table.groupby("solver")["geodesic_deg"].mean().loc["lspe"] > 0


def test_the_store_is_there_by_columns(runs):
    observations = runs[0].observations()
    trials = runs[0].trials()
    assert len(observations["feature"]) == 8 * len(trials["trial"])
    assert set(observations["status"]) == {"found"}
    assert observations["trial"].tolist() == sorted(observations["trial"].tolist())
    assert trials["true_tz_m"].dtype == np.float64
    error = np.hypot(observations["pixel_u"] - observations["true_pixel_u"],
                     observations["pixel_v"] - observations["true_pixel_v"])
    assert np.allclose(error, observations["error_px"], atol=1e-9)


def test_a_run_is_found_again(runs, tmp_path):
    again = sl.Run(runs[0].path)
    assert again.summary == runs[0].summary and again.summary["study"] == "cube-noise"
    assert again.manifest["command"] == "sightline.Study('cube-noise').run()"
    assert again.report.html.lstrip().startswith("<!") and os.path.isfile(again.report)
    with pytest.raises(sl.InputError, match="holds no results.csv; must be the folder of a run"):
        sl.Run(tmp_path)


def test_a_report_is_written_anew_and_shown(runs):
    report = sl.Report(runs[0].path)
    shown = report._repr_html_()
    assert shown.count("<") == 2 and "srcdoc" in shown  # the page's own are escaped
    report.path.unlink()
    assert report.rewrite().html.lstrip().startswith("<!")
    with pytest.raises(sl.InputError, match="must be the folder of a run"):
        sl.Report(runs[0].path / "figures")


def test_comparisons_may_be_by_other_measures(runs):
    base, _, worse = runs
    rows = sl.compare(base, worse, measures=["geodesic_deg.p90", "failure_rate"]).columns()
    assert set(rows["quantity"]) == {"geodesic_deg.p90", "failure_rate"}
    with pytest.raises(sl.InputError, match="did you mean"):
        sl.compare(base, worse, measures=["geodesic_deg.p9"])


def test_comparisons_are_the_programs(runs, program):
    base, same, worse = runs
    unchanged = sl.compare(base, same)
    assert not unchanged.is_worse
    assert set(unchanged.columns()["verdict"]) == {"unchanged"}
    changed = sl.compare(base.path, worse.path)
    assert changed.is_worse and "worse" in set(changed.columns()["verdict"])
    columns = changed.columns()
    means = columns["quantity"] == "geodesic_deg.mean"
    noisy = means & (columns["condition"] != "noise_px 0.0")
    assert (columns["now"][noisy] > columns["base"][noisy]).any()
    outcome = program("compare", base.path, worse.path)
    assert outcome.returncode == 3 and outcome.stdout == str(changed) == changed.text
    suite = xml.etree.ElementTree.fromstring(changed.junit)
    assert suite.findall(".//failure") and not xml.etree.ElementTree.fromstring(
        unchanged.junit).findall(".//failure")


def test_what_cannot_be_compared(runs, tmp_path):
    with pytest.raises(sl.InputError, match="holds no summary.json"):
        sl.compare(runs[0], tmp_path)
    with pytest.raises(sl.InputError, match="tolerance is 2.0, must be from 0 to 1"):
        sl.compare(runs[0], runs[1], tolerance=2)
