import json
import os
import subprocess

import credence
import numpy as np
import pytest

from scenario import SCENARIO


def test_a_scenario_gives_the_bits_of_the_command(tmp_path):
    file = tmp_path / "scenario.toml"
    file.write_text(SCENARIO)
    command = [os.environ["CREDENCE"], "run", str(file), "--quiet", "--format", "json"]
    command += ["--set", "filter.process_scale=0.2"]
    wanted = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    result = credence.run(file, **{"filter.process_scale": 0.2})
    assert result.to_dict() == wanted
    assert result.verdict == wanted["verdict"] == "optimistic"
    np.testing.assert_array_equal(result.mean_nees, wanted["nees"]["per_step"])
    assert os.path.exists(result.report(tmp_path / "out"))


def test_text_and_dict_are_scenarios_too():
    from_text = credence.run(SCENARIO, runs=100, threads=1)
    sections = {
        "world": {"model": "monobot", "landmarks": 2},
        "study": {"runs": 100, "steps": np.int64(20), "seed": 3},
    }
    assert credence.run(sections).to_dict() == from_text.to_dict()
    assert from_text.verdict == "consistent" and from_text.to_dict()["runs"] == 100


def test_a_sweep_is_a_structured_array(tmp_path):
    swept = {
        "world": {"model": "monobot", "landmarks": 2},
        "study": {"runs": 200, "steps": 20},
        "sweep": {"filter.measurement_scale": [0.25, 1.0], "filter.inflation": ["none", "map"]},
    }
    sweep = credence.sweep(swept)
    array = sweep.array
    assert array.shape == (4,) and set(array["filter.inflation"]) == {"none", "map"}
    right = array[(array["filter.measurement_scale"] == 1.0) & (array["filter.inflation"] == "none")]
    wrong = array[(array["filter.measurement_scale"] == 0.25) & (array["filter.inflation"] == "none")]
    assert right["verdict"] == "consistent" and wrong["verdict"] == "optimistic"
    assert wrong["factor_lower"] > 1.0 and wrong["sweep_p_value"] >= wrong["p_value"]
    assert os.path.exists(sweep.report(tmp_path / "out"))
    assert credence.sweep({**swept, "sweep": {**swept["sweep"], "skip_impossible": np.bool_(True)}}).array.shape == (4,)
    alone = credence.sweep({key: swept[key] for key in ("world", "study")}).array
    assert alone.dtype.names[0] == "verdict" and alone["runs"] == [200]
    file = tmp_path / "scenario.toml"
    file.write_text(SCENARIO + '[sweep]\n"filter.process_scale" = [0.5, 1.0]\n')
    command = [os.environ["CREDENCE"], "sweep", str(file), "--quiet", "--format", "json", "--out", str(tmp_path / "s")]
    wanted = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert credence.sweep(file).to_dict() == wanted
    fewer = credence.sweep(file, runs=64, steps=5, seed=7).to_dict()
    assert [c["runs"] for c in fewer["configurations"]] == [64, 64]
    assert fewer == credence.sweep(file, **{"study.runs": 64, "study.steps": 5, "study.seed": 7}).to_dict()


def test_scenarios_that_come_with_the_program_are_known_by_their_names():
    command = [os.environ["CREDENCE"], "run", "figure1_two_landmarks", "--runs", "64", "--quiet", "--format", "json"]
    wanted = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert credence.run("figure1_two_landmarks", runs=64).to_dict() == wanted
    with pytest.raises(ValueError, match="did you mean figure1_two_landmarks"):
        credence.run("figure1_two_landmark")
    with pytest.raises(ValueError, match="^sweep.x=1: of one configuration nothing is swept"):
        credence.run("figure1_two_landmarks", **{"sweep.x": 1})


def test_a_sweep_that_is_left_aside_is_told():
    with pytest.warns(UserWarning, match=r"mistuned_sweep has a \[sweep\], which run leaves aside") as told:
        credence.run("mistuned_sweep", runs=64)
    assert told[0].filename == __file__


def test_what_is_wrong_is_named():
    with pytest.raises(ValueError, match="landmark_count"):
        credence.run(SCENARIO, **{"world.landmark_count": 3})
    with pytest.raises(ValueError, match="threads = -1: expected 0 to 4096"):
        credence.run(SCENARIO, threads=-1)
    for directory in ("a\0b", "\ud800", 5):
        with pytest.raises(ValueError, match="is no path"):
            credence.load(directory)
        with pytest.raises(ValueError, match="is no path"):
            credence.run(SCENARIO, runs=64).report(directory)
    for plays in (credence.run, credence.sweep, credence.tune):
        with pytest.raises(ValueError, match="^runs = 5 and study.runs = 7: expected one of them"):
            plays(SCENARIO, runs=5, **{"study.runs": 7})
        with pytest.raises(ValueError, match="^a setting = .*: expected characters of Unicode"):
            plays(SCENARIO, **{"a.\udc80": 1})
        with pytest.raises(ValueError, match=r"^progress = 3: expected a function of \(done, total\)"):
            plays(SCENARIO, progress=3)
    with pytest.raises(ValueError, match="no section"):
        credence.run({"landmarks": 2})
    with pytest.raises(ValueError, match="nowhere.toml"):
        credence.run("nowhere.toml")
