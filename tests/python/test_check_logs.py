import json
import os
import subprocess

import credence
import numpy as np
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


def test_a_message_with_bytes_of_the_file_is_not_empty(tmp_path):
    file = tmp_path / "a.csv"
    file.write_bytes(b"step,estimate.x,truth.x,estimate.\xff,P.1.1\n1,2,3,4,5\n")
    with pytest.raises(credence.DataError, match=r"a\.csv:1: column truth\.\\xff is missing"):
        credence.check_logs(file)
    with pytest.raises(ValueError, match=r"^topic: .* is read as Credence CSV; accepted are bags"):
        credence.check_logs(file, topic="/x")


def test_errors_name_arguments_and_not_options_of_the_command(tmp_path):
    trajectory = tmp_path / "a--topic.tum"
    trajectory.write_text("0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n")
    with pytest.raises(ValueError, match=r"a--topic\.tum.* name the truth by truth$"):
        credence.check_logs(trajectory, format="tum")
    with pytest.raises(ValueError, match=r"^format excel: accepted are auto, "):
        credence.check_logs(trajectory, format="excel")
    with pytest.raises(ValueError, match=r"^truth: 3 files for 1 log;"):
        credence.check_logs(trajectory, truth=[trajectory] * 3)
    with pytest.raises(credence.ScenarioError, match=r'^[^-]*noise\.process_variance=-1'):
        credence.run(SCENARIO, **{"noise.process_variance": -1})


def test_options_are_those_that_the_command_accepts(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("estimate.x,truth.x,P.1.1\n1,2,3\n")
    with pytest.raises(ValueError, match=r"^within = -0\.5: expected 0\.001 to 10"):
        credence.check_logs(file, within=-0.5)
    for apart in (-1.0, 0.0, float("nan")):
        with pytest.raises(ValueError, match=r"^max_time_difference = "):
            credence.check_logs(file, max_time_difference=apart)
    for flag in ("partial", "sensitivity"):
        with pytest.raises(ValueError, match=f"^{flag} = 1: expected True or False"):
            credence.check_logs(file, **{flag: 1})
    for word in ("format", "topic", "truth_topic", "chart", "align"):
        with pytest.raises(ValueError, match=f"^{word} = 3: expected a str"):
            credence.check_logs(file, **{word: 3})
    for refused in (
        {"instance": "a"}, {"instance": 1.5}, {"time_offset": []}, {"lever_arm": "1,2,3"}, {"lever_arm": (1, "x", 3)},
        {"lever_arm": 5}, {"truth": 5},
    ):
        (argument,) = refused
        with pytest.raises(ValueError, match=f"^{argument} = .*: expected "):
            credence.check_logs(file, **refused)
    with pytest.raises(ValueError, match="^logs = None: expected files, or folders of them"):
        credence.check_logs(None)
    with pytest.raises(ValueError, match="^logs holds 5: expected files, or folders of them"):
        credence.check_logs([file, 5])
    with pytest.raises(ValueError, match=r"^progress = 3: expected a function of \(done, total\)"):
        credence.check_logs(file, progress=3)


def test_a_failed_run_has_its_name(tmp_path):
    file = tmp_path / "dv.csv"
    rows = "".join(f"{run},{step},{0.1 * run},0,1\n" for run in (105, 106) for step in (1, 2))
    file.write_text("run,step,estimate.x,truth.x,P.1.1\n" + rows + "# failed: diverged at step 3\n")
    result = credence.check_logs(file)
    assert "FAILED: run 106 of dv, diverged at step 3." in str(result)
    (failure,) = result.to_dict()["outcomes"]["failures"]
    assert (failure["run"], failure["name"]) == (1, "run 106 of dv")


def test_remarks_name_arguments_and_a_lever_arm_is_taken(tmp_path):
    unit = " ".join("0.01" if i == j else "0" for i in range(6) for j in range(i, 6))
    estimate, truth = tmp_path / "e.tum", tmp_path / "t.txt"
    estimate.write_text("".join(f"{k} {0.1 * (-1) ** k} {k} 0 0 0 0 1 {unit}\n" for k in range(30)))
    truth.write_text("".join(f"{k} 0.5 {k} 0 0 0 0 1\n" for k in range(30)))
    apart = credence.check_logs(estimate, truth=truth)
    assert "judged as of the chart body (chart)" in str(apart) and "--" not in str(apart)
    assert apart.remarks == apart.to_dict()["remarks"]
    moved = credence.check_logs(estimate, truth=truth, lever_arm=[0.5, 0, 0])
    np.testing.assert_allclose(moved.mean_nees, np.ones(30), rtol=1e-9)
    np.testing.assert_allclose(apart.mean_nees, np.tile([16.0, 36.0], 15), rtol=1e-9)
    with pytest.raises(ValueError, match=r"^lever_arm: accepted are x,y,z \(m\)"):
        credence.check_logs(estimate, truth=truth, lever_arm=[0.5, 0])


def test_the_truth_is_between_its_rows_or_the_nearest(tmp_path):
    unit = " ".join("0.01" if i == j else "0" for i in range(6) for j in range(i, 6))
    estimate, truth = tmp_path / "e.tum", tmp_path / "t.txt"
    estimate.write_text("".join(f"{k} 0.1 {k} 0 0 0 0 1 {unit}\n" for k in range(1, 31)))
    truth.write_text("".join(f"{k + 0.01} 0 {k + 0.01} 0 0 0 0 1\n" for k in range(31)))
    between = credence.check_logs(estimate, truth=truth, max_time_difference=1.1)
    np.testing.assert_allclose(between.mean_nees, np.ones(30), rtol=1e-9)  # 0.1²/0.01
    nearest = credence.check_logs(estimate, truth=truth, truth_time="nearest", max_time_difference=0.015)
    np.testing.assert_allclose(nearest.mean_nees, np.full(30, 1.01), rtol=1e-9)  # and 0.01²/0.01
    with pytest.raises(ValueError, match="truth_time = 'soon': expected 'interpolated' or 'nearest'"):
        credence.check_logs(estimate, truth=truth, truth_time="soon")


def test_no_message_holds_what_a_terminal_obeys(tmp_path):
    file = tmp_path / "a\x1b[31m.csv"
    file.write_text("step,estimate.x\x1b]0;t\x07,truth.x,P.1.1\n")
    with pytest.raises(credence.DataError) as refused:
        credence.check_logs(file)
    assert "a\\x1b[31m.csv:1: column 2, 'estimate.x?]0;t?': its name holds a control character" in str(refused.value)


def test_a_file_of_any_name_is_judged(tmp_path):
    file = os.fsdecode(bytes(tmp_path) + b"/\xff.csv")
    with open(file, "w") as log:
        log.write("innovation.1,S.1.1\n0.5,1\n-0.5,1\n")
    result = credence.check_logs(file)
    assert result.verdict == "consistent" and "\ufffd" not in str(result)
    assert credence.check_logs(os.fsencode(file)).to_dict() == result.to_dict()
    with pytest.raises(ValueError, match="holds a null character"):
        credence.check_logs("a\0b")
    with pytest.raises(credence.ScenarioError, match=r"/\\xff\.toml: no such|cannot be|\\xff"):
        credence.run(os.fsdecode(bytes(tmp_path) + b"/\xff.toml"))


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
