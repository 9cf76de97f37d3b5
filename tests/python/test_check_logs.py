import json
import os
import subprocess

import credence
import pytest

from scenario import SCENARIO


@pytest.fixture
def logs(tmp_path):
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(SCENARIO)
    folder = tmp_path / "logs"
    call = [os.environ["CREDENCE"], "run", str(scenario), "--quiet", "--log", str(folder)]
    subprocess.run(call, check=True, capture_output=True)
    return folder


def test_logs_are_judged_as_by_the_command(logs, tmp_path):
    result = credence.check_logs(logs)
    call = [os.environ["CREDENCE"], "check", str(logs), "--quiet", "--format", "json"]
    assert result.to_dict() == json.loads(subprocess.run(call, check=True, capture_output=True).stdout)
    assert result.verdict == "consistent" and result.complete
    files = sorted(logs.iterdir())
    assert credence.check_logs(files, name="logs", threads=2).to_dict() == result.to_dict()
    assert os.path.exists(result.report(tmp_path / "out"))


def test_what_cannot_be_judged_is_named(logs, tmp_path):
    file = sorted(logs.iterdir())[0]
    with pytest.raises(credence.DataError, match="absent.csv"):
        credence.check_logs(tmp_path / "absent.csv")
    with pytest.raises(credence.DataError, match=file.name):
        credence.check_logs([file, file])
    with pytest.raises(ValueError, match="excel"):
        credence.check_logs(file, format="excel")
    with pytest.raises(ValueError, match="se2"):
        credence.check_logs(file, align="plane")
    with pytest.raises(ValueError, match="estimate"):
        credence.check_logs(file, time_offset="soon")
    with pytest.raises(ValueError, match="trajectories"):
        credence.check_logs(file, time_offset=1.0)
    with pytest.raises(ValueError, match="trajectories"):
        credence.check_logs(file, time_offset=0.0)
    with pytest.raises(ValueError, match="empty"):
        credence.check_logs([])
