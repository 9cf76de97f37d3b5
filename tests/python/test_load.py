import os
import subprocess

import credence
import numpy as np
import pytest

from scenario import SCENARIO


def stored(tmp_path, text, command):
    file = tmp_path / "scenario.toml"
    file.write_text(text)
    folder = tmp_path / "out"
    call = [os.environ["CREDENCE"], command, str(file), "--quiet", "--out", str(folder)]
    subprocess.run(call, check=True, capture_output=True)
    return file, folder


def test_a_stored_study_is_its_run(tmp_path):
    file, folder = stored(tmp_path, SCENARIO, "run")
    result = credence.load(folder)
    assert isinstance(result, credence.Result)
    assert result.to_dict() == credence.run(file).to_dict()
    assert result.mean_nees.shape == (20,) and result.verdict == "consistent"
    assert os.path.exists(result.report(tmp_path / "again"))


def test_a_stored_sweep_is_a_structured_array(tmp_path):
    file, folder = stored(tmp_path, SCENARIO + '[sweep]\n"filter.process_scale" = [0.2, 1.0]\n', "sweep")
    sweep = credence.load(folder)
    assert isinstance(sweep, credence.Sweep)
    np.testing.assert_array_equal(sweep.array, credence.sweep(file).array)
    assert list(sweep.array["verdict"]) == ["optimistic", "consistent"]
    assert "<pre>" in sweep._repr_html_()


def test_a_folder_without_results_is_named(tmp_path):
    with pytest.raises(credence.StoreError, match="nowhere"):
        credence.load(tmp_path / "nowhere")
