import copy
import json
import os
import pickle
import re
import signal
import subprocess
import sys
import time

import credence
import numpy as np
import pytest

from filters import F, H, P0, Q, R, play


def write_log(path, error, P, nu, S, names=("x", "v")):
    """The arrays as one CSV log, every number in the digits that read back to it."""
    n, m = error.shape[-1], nu.shape[-1]
    header = ["run", "step"] + [f"estimate.{s}" for s in names] + [f"truth.{s}" for s in names]
    header += [f"P.{i + 1}.{j + 1}" for i in range(n) for j in range(i, n)]
    header += [f"innovation.{i + 1}" for i in range(m)]
    header += [f"S.{i + 1}.{j + 1}" for i in range(m) for j in range(i, m)]
    with open(path, "w") as file:
        file.write(",".join(header) + "\n")
        for r in range(len(error)):
            for k in range(error.shape[1]):
                row = [r, k + 1, *error[r, k], *np.zeros(n), *P[r, k][np.triu_indices(n)]]
                row += [*nu[r, k], *S[r, k][np.triu_indices(m)]]
                file.write(",".join("" if x != x else repr(float(x)) for x in row) + "\n")


def checked(path, *options):
    command = [os.environ["CREDENCE"], "check", str(path), "--quiet", "--format", "json", *options]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def test_a_right_filter_is_consistent():
    result = credence.check(*play(), names=["x", "v"])
    assert result.verdict == "consistent"
    assert str(result.verdict) == f"{result.verdict}" == "consistent"
    assert result.p_value > 0.05
    assert "no evidence against" in result.says
    assert result.causes == []
    assert [b.name for b in result.blocks] == ["x", "v"]
    assert result.factor.lower < 1.0 < result.factor.upper
    assert result.mean_nees.shape == (40,) and result.nees_bounds.shape == (40, 2)


def test_heavy_tails_are_a_verdict():
    random = np.random.default_rng(1)
    scale = np.where(random.random((200, 20, 1)) < 0.05, 5.0, 1.0) / np.sqrt(0.95 + 0.05 * 25.0)
    error = scale * random.normal(size=(200, 20, 2))
    result = credence.check(error, np.eye(2), names=["x", "y"])
    assert result.verdict is credence.Verdict.not_gaussian == "not Gaussian"
    assert "the covariance is right" in result.says


def test_a_covariance_that_is_right_on_average_only_is_mixed():
    random = np.random.default_rng(3)
    claimed = np.where(random.random((40, 50, 1)) < 0.5, 2.5, 0.625)  # of 1: its mean NEES over n is 1
    P = np.eye(2) * claimed[..., None]
    result = credence.check(random.normal(size=(40, 50, 2)), P, names=["x", "y"])
    assert result.verdict == "mixed"
    assert "optimistic in" in result.says and "where its σ is 0.562 to 1.00" in result.says
    assert "pessimistic in" in result.says and "where its σ is 1.00 to 1.78" in result.says
    assert "By the σ that is claimed, the factor on σ² is" in str(result)
    assert credence.check(np.sqrt(claimed) * random.normal(size=(40, 50, 2)), P).verdict == "consistent"


def test_one_run_that_diverges_is_named():
    error, P, innovation, S = play()
    error = error.copy()
    error[7, 30:] += 60.0 * np.sqrt(P[7, 30:].diagonal(axis1=-2, axis2=-1))
    result = credence.check(error, P, innovation, S, names=["x", "v"])
    assert result.verdict == "optimistic"
    assert f"in run 7 (of 0 to {len(error) - 1}) alone, from step 31 on" in result.says
    assert result.causes[0].name == "a filter that loses its way in a few runs"
    assert [run["run"] for run in result.to_dict()["battery"]["lost_runs"]] == [7]


def test_the_version_can_be_cited():
    assert credence.__version__.count(".") == 2
    assert isinstance(credence.__commit__, str)
def test_more_numbers_than_there_is_memory_are_refused_before_they_are_judged():
    for shape in ((10**6, 10**5, 10), (10**9, 1000)):
        with pytest.raises(ValueError, match=r"error has shape .* would take 8e\+03 GB"):
            credence.check(np.broadcast_to(np.float64(0.5), shape), np.eye(shape[-1]))
    nu = np.broadcast_to(np.ones(1), (10**6, 10**6, 1))
    with pytest.raises(ValueError, match="innovation has shape"):
        credence.check(innovation=nu, S=np.eye(1))


def test_an_interruption_is_heard_within_a_run():
    # One run of a minute or more. Whether runs are distinct is looked at in numpy, which takes its time as well.
    code = (
        "import credence, numpy as np, sys\n"
        "from credence import _check\n"
        "_check.require_distinct = lambda parts, name: print('judging', flush=True)\n"
        "credence.check(np.broadcast_to(np.array([0.5]), (1, 2 * 10**7, 1)), np.eye(1))\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "judging\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate()
    assert said.rstrip().endswith("KeyboardInterrupt")
    assert child.returncode == -signal.SIGINT


@pytest.mark.parametrize("names", [["a\x1b[31m", "b"], ["a", "b\x9b"], ["a\n", "b"]])
def test_names_hold_no_control_characters(names):
    with pytest.raises(ValueError, match=r"names = .*: holds a control character"):
        credence.check(*play(), names=names)
    error, P, nu, S = play()
    with pytest.raises(ValueError, match="the name of a sensor"):
        credence.check(error, P, {"".join(names): nu}, {"".join(names): S})


def test_wrong_filters_are_named():
    optimistic = credence.check(*play(believed_Q=0.2 * Q, runs=500))
    assert optimistic.verdict == "optimistic"
    assert optimistic.causes[0].name == "process noise Q assumed too small"
    assert optimistic.factor.lower > 1.0
    pessimistic = credence.check(*play(believed_R=4.0 * R, runs=500))
    assert pessimistic.verdict == "pessimistic"
    rejecting = [t for t in pessimistic.tests if t.adjusted < 0.05]
    assert rejecting and all(t.exactness in ("exact", "approximate", "conservative") for t in pessimistic.tests)


@pytest.mark.parametrize("believed", [Q, 0.3 * Q])
def test_arrays_say_what_their_log_says_to_the_last_bit(tmp_path, believed):
    error, P, nu, S = play(believed_Q=believed, runs=130, steps=25)
    error[3, 4] = np.nan
    nu[5, 7:9] = np.nan
    write_log(tmp_path / "log.csv", error, P, nu, S)
    wanted = checked(tmp_path / "log.csv")
    got = credence.check(error, P, nu, S, names=["x", "v"], threads=2).to_dict()
    for document in (wanted, got):
        document["calibration"].pop("unit_names")  # of the log and its runs, or of the runs alone
        for cause in document["battery"]["causes"]:  # arrays have no estimates, which that takes
            cause["why"] = cause["why"].split("; late measurements were not tested")[0]
    for key in wanted.keys() - {"files", "format"}:
        assert got[key] == wanted[key], key


def test_late_measurements_are_told_where_the_estimate_is_given():
    runs, steps, late = 150, 40, 3
    rng = np.random.default_rng(4)
    x = rng.standard_normal((runs, 2)) @ np.sqrt(P0) + [0.0, 2.0]
    truth = np.empty((steps, runs, 2))
    for k in range(steps):
        x = truth[k] = x @ F.T + rng.standard_normal((runs, 2)) @ np.sqrt(Q)
    z = truth @ H.T + rng.standard_normal((steps, runs, 1)) @ np.sqrt(R)
    estimate, P, covariance = np.empty((runs, steps, 2)), np.empty((steps, 2, 2)), P0
    x = np.tile([0.0, 2.0], (runs, 1))
    for k in range(steps):
        x, covariance = x @ F.T, F @ covariance @ F.T + Q
        if k >= late:
            s = H @ covariance @ H.T + R
            K = covariance @ H.T / s
            x, covariance = x + (z[k - late] - x @ H.T) @ K.T, covariance - K @ s @ K.T
        estimate[:, k], P[k] = x, 0.5 * (covariance + covariance.T)
    error = estimate - truth.transpose(1, 0, 2)
    word = "measurements that arrive late"
    told = credence.check(error, P, estimate=estimate)
    assert told.verdict == "optimistic" and told.causes[0].name.startswith(word)
    untold = credence.check(error, P)
    assert untold.verdict == "optimistic" and not any(c.name.startswith(word) for c in untold.causes)
    gone = estimate.copy()
    gone[3, 4, 1] = np.nan
    with pytest.raises(ValueError, match=r"^estimate\[3, 4, 1\] is nan$"):
        credence.check(error, P, estimate=gone)
    with pytest.raises(ValueError, match=r"^estimate has shape \(150, 40, 1\): expected \(150, 40, 2\), as error$"):
        credence.check(error, P, estimate=estimate[..., :1])
    with pytest.raises(ValueError, match="^estimate belongs to error, which is None"):
        credence.check(innovation=error, S=np.eye(2), estimate=estimate)


def test_threads_do_not_change_the_bits():
    arrays = play(runs=200, steps=10)
    assert credence.check(*arrays, threads=1).to_dict() == credence.check(*arrays, threads=3).to_dict()


def test_the_same_arrays_in_other_forms():
    error, P, nu, S = play(runs=70, steps=12)
    wanted = credence.check(error, P, nu, S).to_dict()
    assert credence.check(list(error), list(P), list(nu), list(S)).to_dict() == wanted
    assert credence.check(error, P[0], nu, S[0]).to_dict() == wanted, "one P for all runs"
    assert credence.check(np.asfortranarray(error), P, nu, S).to_dict() == wanted, "converted"
    wide = np.zeros((70, 24, 2))
    wide[:, ::2] = error
    assert credence.check(wide[:, ::2], P, nu, S).to_dict() == wanted, "strided"
    silent = error.copy()
    silent[3, 4] = silent[60, :, 1] = np.nan
    masked = np.ma.masked_array(np.nan_to_num(silent, nan=50.0), np.isnan(silent))
    assert credence.check(masked, P, nu, S).to_dict() == credence.check(silent, P, nu, S).to_dict(), "masked"
    assert credence.check(error, P, {"gps": nu}, {"gps": S}).verdict == wanted["verdict"]


def test_runs_of_different_lengths():
    error, P, nu, S = play(runs=60, steps=20)
    lengths = [20 - r % 7 for r in range(60)]
    ragged = [[a[r, :k] for r, k in enumerate(lengths)] for a in (error, P, nu, S)]
    result = credence.check(*ragged)
    assert result.to_dict()["rows"] == sum(lengths)
    padded_error, padded_nu = error.copy(), nu.copy()
    for r, k in enumerate(lengths):
        padded_error[r, k:], padded_nu[r, k:] = np.nan, np.nan
    padded = credence.check(padded_error, P, padded_nu, S)
    np.testing.assert_array_equal(result.mean_nees, padded.mean_nees)


def test_observations_in_one_innovation_are_followed_one_by_one():
    def tests(innovation, S, observation=None):
        judged = credence.check(innovation=innovation, S=S, observation=observation)
        return {test.name: (test.p_value, test.says) for test in judged.tests}

    whiteness = "whiteness of the innovation"
    _, _, nu, S = play()
    runs, steps = nu.shape[:2]
    both, both_S = np.full((runs, steps, 2), np.nan), np.tile(np.eye(2), (runs, steps, 1, 1))
    both[..., :1], both_S[..., :1, :1] = nu, S
    alone = tests(nu, S)
    assert tests(both, both_S, 1) == alone
    assert tests({"gps": both}, {"gps": both_S}, {"gps": 1})[whiteness + " of gps"] == alone[whiteness]
    both[..., 1:] = np.random.default_rng(5).standard_normal((runs, steps, 1))
    assert "dof 80" in tests(both, both_S)[whiteness][1]  # 20 lags of a matrix of two by two
    assert "dof 20" in tests(both, both_S, 1)[whiteness][1]  # of one number
    for wrong in (0, 3, 1.0, True):
        with pytest.raises(ValueError, match="expected a divisor of the 2 components"):
            tests(both, both_S, wrong)
    with pytest.raises(ValueError, match="observation has the sensors"):
        tests(both, both_S, {"gps": 1})


def test_what_the_filter_assumes_gives_the_factor_on_R_and_causes():
    error, P, nu, S = play()
    half = 0.5 * S

    def told(R=None, **more):
        return credence.check(error, P, nu, S, R=R, **more).to_dict()["battery"]

    def factor(R, **more):
        return told(R, **more)["scale"]["measurement_noise"]["factor"]

    assert factor(None) is None
    always = factor([[1.0]])
    assert always is not None and always == factor(np.ones_like(S)) == factor({"": np.eye(1)})
    assert factor(half) != always
    assert not credence.check(error, P, nu, S, R=half).remarks
    assert credence.check(error, P, nu, S, R=[[1.0]]).remarks[0].startswith("R is larger than S, by tr(S⁻¹ R)/m = ")
    wide_nu = np.concatenate([nu, nu], axis=2)
    wide_S = np.einsum("ij,rsk->rsij", np.eye(2), S[..., 0])
    both = [credence.check(innovation=wide_nu, S=wide_S, R=R, observation=1) for R in ([[1.0]], np.eye(2))]
    assert both[0].to_dict()["battery"]["scale"] == both[1].to_dict()["battery"]["scale"]
    with pytest.raises(ValueError, match=r"R\[0, 0, 0, 0\] is -1"):
        factor([[-1.0]])
    with pytest.raises(ValueError, match="R has the sensors"):
        factor({"gps": [[1.0]]})
    with pytest.raises(ValueError, match="R has shape"):
        factor(np.eye(3))
    wrong = {"nonlinear": "linearis", "inflated": "inflat"}
    for flag, word in wrong.items():
        scale = 0.5 if flag == "nonlinear" else 2.0
        causes = [c["cause"] for c in credence.check(error, scale * P, nu, S, **{flag: True}).to_dict()["battery"]["causes"]]
        assert any(word in cause for cause in causes), (flag, causes)


def test_one_run_and_innovations_alone():
    error, P, nu, S = play(runs=1, steps=400)
    assert credence.check(error[0], P[0], nu[0], S[0]).to_dict()["runs"] == 1
    alone = credence.check(innovation=nu[0], S=S[0])
    assert alone.sensors[0].expected == 1.0 and alone.mean_nees.size in (0, 400)


def test_several_sensors():
    error, P, nu, S = play()
    result = credence.check(error, P, {"gps": nu, "radar": 3.0 * nu}, {"gps": S, "radar": S})
    assert [s.name for s in result.sensors] == ["gps", "radar"]
    assert result.sensors[0].verdict == "consistent" and result.sensors[1].verdict == "optimistic"


def test_angles_are_wrapped_and_blocks_are_named():
    error, P, _, _ = play()
    turned = error + np.array([0.0, 2.0 * np.pi])
    assert credence.check(turned, P, angles=[1]).verdict == "consistent"
    assert credence.check(turned, P).verdict == "optimistic"
    named = credence.check(error, P, names=["x", "v"], angles=["v"], blocks={"place": ["x"], "all": slice(None)})
    assert [b.name for b in named.blocks] == ["place", "all"]


def units_taken(result):
    """The document without its units, and these."""
    document = result.to_dict()
    for joined in document["word"]["joined"]:  # "v where its σ is 0.316 to 0.562 rad/s"
        joined["name"] = re.sub(r"(where its σ is \S+ to \S+) rad/s$", r"\1", joined["name"])
    return [row.pop("unit") for row in document["battery"]["accuracy"]], document


def test_units_stand_beside_errors_and_change_no_number(tmp_path):
    error, P, nu, S = play()
    plain = credence.check(error, P, nu, S, names=["x", "v"])
    nothing, numbers = units_taken(plain)
    assert nothing == ["", ""]

    def page_of(result, folder):
        result.report(tmp_path / folder)
        return re.sub("<[^>]*>", "", (tmp_path / folder / "index.html").read_text())

    assert "x (m)" not in page_of(plain, "plain")
    listed = ["m", "rad/s"]
    for kind, units in (("list", listed), ("dict", {"x": "m", "v": "rad/s"}), ("array", np.array(listed))):
        told = credence.check(error, P, nu, S, names=["x", "v"], units=units)
        assert units_taken(told) == (listed, numbers)
        page = page_of(told, kind)
        assert "x (m)" in page and "v (°/s)" in page
    named = credence.check(error, P, nu, S, names=["x [m]", "v[rad/s]"])
    assert units_taken(named) == (listed, numbers)
    assert units_taken(credence.check(error, P, nu, S, names=["x", "v [rad/s]"], units={"x": "m"})) == (listed, numbers)
    with pytest.raises(ValueError, match=re.escape("units: v is in 'm/s', and by its name in 'rad/s'")):
        credence.check(error, P, names=["x", "v [rad/s]"], units=["m", "m/s"])
    assert credence.check(error, P, names=["x", "v"], units={}).verdict == "consistent"
    assert credence.check(error, P, angles=["x2"], units=["m", "rad"]).verdict == "consistent"


def test_mistakes_of_units_are_told_as_of_a_log(tmp_path):
    rng = np.random.default_rng(3)
    variances = np.array([0.01, 0.04, 0.0025])
    error = rng.standard_normal((20, 100, 3)) * np.sqrt(variances)
    deviations = np.diag(np.sqrt(variances))
    result = credence.check(error, deviations)
    assert any("standard deviations" in remark for remark in result.to_dict()["remarks"])
    assert "standard deviations" in str(result)
    assert [c.name for c in result.causes if c.name == "the scale of the covariance"] == []
    np.savez(tmp_path / "log.npz", error=error, P=np.broadcast_to(deviations, (20, 100, 3, 3)))
    assert checked(tmp_path / "log.npz")["remarks"] == result.to_dict()["remarks"]
    assert credence.check(error, np.diag(variances)).to_dict()["remarks"] == []
    degrees = np.where(np.arange(3) == 2, np.degrees(error), error)
    told = credence.check(degrees, np.diag(variances), names=["x", "y", "yaw"], angles=["yaw"])
    assert any("yaw is perhaps in degrees" in remark for remark in told.to_dict()["remarks"])


def test_an_innovation_of_an_angle_is_declared():
    error, P, nu, S = play()
    nu = nu.copy()
    nu[:5, 20] += 2.0 * np.pi
    plain = credence.check(error, P, nu, S)
    assert not any("angle" in cause.name for cause in plain.causes)
    for angles in ([0], [True], True):
        declared = credence.check(error, P, nu, S, innovation_angles=angles)
        assert any("angle" in cause.name for cause in declared.causes), declared.causes
    two = credence.check(error, P, {"gps": nu, "compass": nu[:, ::-1]}, {"gps": S, "compass": S},
                         innovation_angles={"compass": [0]})
    assert any("angle" in cause.name for cause in two.causes)
    with pytest.raises(ValueError, match="innovation_angles has the sensors"):
        credence.check(error, P, nu, S, innovation_angles={"sonar": [0]})
    with pytest.raises(ValueError, match="innovation_angles"):
        credence.check(error, P, nu, S, innovation_angles=[1])


def test_what_counts_as_right_is_asked():
    error, P, nu, S = play()
    assert credence.check(error, P, nu, S, within=0.5).to_dict() != credence.check(error, P, nu, S).to_dict()
    with pytest.raises(ValueError, match="within"):
        credence.check(error, P, nu, S, within=0.0)


def test_nothing_is_copied_and_nothing_is_changed():
    error, P, nu, S = play(runs=10, steps=10, seed=2)
    for array in (error, P, nu, S):
        array.flags.writeable = False
    assert credence.check(error, P, nu, S).verdict == "consistent"


def bad(change):
    """A message of check(error, P, innovation, S) after a change of them."""
    arrays = dict(zip(("error", "P", "innovation", "S"), (a.copy() for a in play(runs=5, steps=20))))
    change(arrays)
    with pytest.raises(ValueError) as error:
        credence.check(**arrays)
    return str(error.value)


def test_bad_arrays_are_named():
    def asymmetric(a):
        a["P"][3, 17, 0, 1] += 1.0

    def infinite(a):
        a["error"][4, 2, 1] = np.inf

    def unknown(a):
        a["S"][2, 3] = np.nan

    def missing_variance(a):
        a["P"][1, 0, 1, 1] = np.nan

    assert bad(asymmetric).startswith("P[3, 17] is not symmetric: its entries [0, 1] and [1, 0] are ")
    assert bad(infinite) == "error[4, 2, 1] is inf"
    assert bad(unknown) == "S[2, 3, 0, 0] is nan"
    assert bad(missing_variance) == "P[1, 0, 1, 1] is nan"
    assert bad(lambda a: a.update(P=a["P"][:, :, 0])) == (
        "P has shape (5, 20, 2): expected (5, 20, 2, 2) (or (20, 2, 2) or (2, 2) where all are the same), as error; "
        "variances alone are a covariance as "
        "v[..., None] * numpy.eye(n)"
    )
    assert bad(lambda a: a.update(S=a["S"][:4])).endswith(", as innovation")
    assert bad(lambda a: a.update(P=a["P"][:4])) == (
        "P has shape (4, 20, 2, 2): expected (5, 20, 2, 2) (or (20, 2, 2) or (2, 2) where all are the same), as error"
    )
    assert bad(lambda a: a.update(innovation=a["innovation"][:, :19])).startswith("innovation has shape (5, 19, 1)")
    assert bad(lambda a: a.update(error=a["error"][0, 0])).startswith("error has shape (2,): expected (runs, steps, n)")
    assert bad(lambda a: a.update(S=None)) == "innovation and S belong together: one of them is None"
    assert bad(lambda a: a.update(error=a["error"].astype(complex))).startswith("error is of dtype complex128")
    assert bad(lambda a: a.update(names=["x"])) == "names has 1 entry: the state has 2"
    assert bad(lambda a: a.update(angles=["heading"])) == "angles: there is no state 'heading' among x1, x2"
    assert bad(lambda a: a.update(units=["m"])) == "units has 1 entry: the state has 2"
    assert bad(lambda a: a.update(units={"v": "m"})) == "units: there is no state 'v' among x1, x2"
    assert bad(lambda a: a.update(units="m")) == (
        "units = 'm': expected one for each state, or a dict of states and their units"
    )
    assert bad(lambda a: a.update(units=["m", 1])) == "units = 1: expected a str"
    assert bad(lambda a: a.update(angles=[1], units=["m", "deg"])) == (
        "units: x2 is an angle, in 'deg'; an angle is in rad"
    )
    assert bad(lambda a: a.update(confidence=1.5)) == "confidence = 1.5: expected 0.5 to 0.999999"
    assert bad(lambda a: a.update(confidence="x")) == "confidence = 'x': expected 0.5 to 0.999999"
    assert bad(lambda a: a.update(within=None)) == "within = None: expected 0.001 to 10"
    assert bad(lambda a: a.update(name=None)) == "name = None: expected a str"
    assert bad(lambda a: a.update(name="\udcff")) == "name = '\\udcff': expected characters of Unicode"
    assert bad(lambda a: a.update(names=["a\udcff", "b"])) == "names = 'a\\udcff': expected characters of Unicode"
    assert bad(lambda a: a.update(blocks=[1])) == "blocks = [1]: expected a dict of names and their states"
    assert bad(lambda a: a.update(blocks={None: [0]})) == "the name of a block = None: expected a str"
    assert bad(lambda a: a.update(blocks={"a": None})) == (
        "blocks['a'] = None: expected names, numbers, booleans or a slice"
    )
    assert bad(lambda a: a.update(innovation={1: a["innovation"]}, S={1: a["S"]})) == (
        "the name of a sensor = 1: expected a str"
    )
    assert bad(lambda a: a.update({k: a[k][:, :0] for k in ("error", "P", "innovation", "S")})) == (
        "error has shape (5, 0, 2): it holds no steps"
    )
    assert bad(lambda a: a.update(error=a["error"][:0])) == "error has shape (0, 20, 2): it holds no steps"
    assert bad(lambda a: a.update(error=[a["error"][0], a["error"][1, :0]])) == (
        "error[1] has shape (0, 2): it holds no steps"
    )
    assert bad(lambda a: a.update(error=[[[1.0, 2.0], [3.0]]])).startswith("error: ")
    assert bad(lambda a: a.update(blocks={"none": []})) == "blocks['none'] has no states"
    assert bad(lambda a: a.update(blocks={"a": [0, 0]})) == "blocks['a'] has 0 twice"
    assert bad(lambda a: a.update(angles=["x1", 0])) == "angles has 0 twice"
    assert bad(lambda a: a.update(innovation_angles=[5])) == (
        "innovation_angles: there is no component 5; the innovation has 1"
    )
    assert bad(lambda a: a.update(angles=[True, 1])) == "angles: there is no state True; the state has 2"
    for flag in ("nonlinear", "inflated", "sensitivity"):
        assert bad(lambda a: a.update({flag: "no"})) == f"{flag} = 'no': expected True or False"
    states = {"estimate": np.zeros((5, 20, 2)), "names": ["x"], "angles": [0], "units": ["m"], "blocks": {"a": [0]}}
    for argument, value in states.items():
        assert bad(lambda a: a.update({"error": None, "P": None, argument: value})) == (
            f"{argument} belongs to error, which is None"
        )
    for argument, value in {"innovation_angles": [0], "observation": 1, "R": np.eye(1)}.items():
        assert bad(lambda a: a.update({"innovation": None, "S": None, argument: value})) == (
            f"{argument} belongs to innovation, which is None"
        )
    for threads in (-1, 4097, 1.5, True):
        assert bad(lambda a: a.update(threads=threads)) == f"threads = {threads}: expected 0 to 4096"
    with pytest.raises(ValueError, match="nothing to judge"):
        credence.check(innovation={}, S={})

    def listed(a):
        for key in a:
            a[key] = list(a[key])
        a["P"][2][7, 1, 0] += 1.0

    assert bad(listed).startswith("P[2][7] is not symmetric")

    def listed_short(a):
        for key in a:
            a[key] = list(a[key])
        a["P"][2] = a["P"][2][:7]

    assert bad(listed_short) == "P[2] has shape (7, 2, 2): expected (20, 2, 2), as error[2]"


def test_what_is_no_covariance_is_counted_and_not_repaired():
    error, P, nu, S = play(runs=70, steps=20)
    P[66, 4] = [[1.0, 2.0], [2.0, 1.0]]
    document = credence.check(error, P, nu, S).to_dict()
    assert document["rejected_rows"] == 1
    assert document["rejected"][0]["first"] == "run 66:5"


def test_errors_beyond_all_measure_are_optimistic_and_not_without_a_test():
    error, P, nu, S = play(runs=20, steps=20)
    for diverged in (1e60, 1e110, 1e150, 1e160, 1e200, 1e308):
        error[3, 11:] = diverged
        result = credence.check(error, P)
        assert result.verdict == "optimistic" and result.p_value < 1e-12, diverged
        assert not result.to_dict()["rejected"]
    innovation, S = np.random.default_rng(1).standard_normal((20, 20, 1)), np.ones((20, 20, 1, 1))
    innovation[3, 11] = 1e200
    assert credence.check(innovation=innovation, S=S).verdict == "optimistic"


def test_a_report_and_a_notebook(tmp_path):
    result = credence.check(*play(believed_Q=0.2 * Q), name="my <filter>")
    page = result.report(tmp_path / "out")
    assert "optimistic" in open(page).read()
    assert result.report(os.fsencode(tmp_path / "out")) == page
    assert repr(result).startswith("Can this covariance be trusted? No: optimistic")
    assert "<b>optimistic</b>" in result._repr_html_()
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(OSError):
        result.report(blocked)


def test_a_large_state_of_single_blocks_is_judged():
    rng = np.random.default_rng(3)
    result = credence.check(rng.standard_normal((70, 10, 15)), np.eye(15))
    assert result.verdict == "consistent" and len(result.blocks) == 15


def test_a_run_that_is_there_twice_is_refused():
    error, P, nu, S = play(runs=12, steps=20)
    twice = error.copy()
    twice[7] = error[3]
    with pytest.raises(ValueError, match=r"error\[7\] has the same numbers as error\[3\]"):
        credence.check(twice, P)
    with pytest.raises(ValueError, match=r"error\[12\] has the same numbers as error\[0\]"):
        credence.check([*error, error[0]], [*P, P[0]])
    again = nu.copy()
    again[11] = nu[0]
    with pytest.raises(ValueError, match=r"innovation\['gps'\]\[11\] has the same numbers"):
        credence.check(innovation={"gps": again}, S={"gps": S})
    # what is coarse, or starts at the truth, may agree by chance
    credence.check(np.round(error[:, :4], 0), P[:, :4])
    error[:, :3] = 0.0
    credence.check(error, P)


def test_a_rounded_copy_is_named_by_its_run():
    error, P, _, _ = play(runs=6, steps=200)
    error[4] = error[1].astype(np.float32)
    (remark,) = credence.check(error, P).remarks
    assert remark.startswith("run 4 has, in all rows that were looked at of the 200 it shares, the errors of run 1,")


def test_a_run_that_was_cut_off_is_there_twice():
    error, P, nu, S = play(runs=12, steps=20)
    for long_first in (True, False):
        runs, covariances = [*error], [*P]
        runs[2 if long_first else 9] = error[5][:13]
        covariances[2 if long_first else 9] = P[5][:13]
        later, before = (5, 2) if long_first else (9, 5)
        with pytest.raises(ValueError, match=rf"error\[{later}\] .*as error\[{before}\] in its first 13 steps"):
            credence.check(runs, covariances)
    cut = nu.copy()
    cut[4] = nu[8]
    cut[4, 15:] = np.nan
    with pytest.raises(ValueError, match=r"innovation\[8\] .*as innovation\[4\] in its first 15 steps"):
        credence.check(innovation=cut, S=S)
    branched = error.copy()
    branched[1, :18] = error[0, :18]  # from there on runs of their own
    credence.check(branched, P)


def test_runs_of_few_levels_may_agree_by_chance():
    rng = np.random.default_rng(4)
    levels = rng.choice([-1.0, 1.0], size=(1000, 17, 1))  # 2^-17 a pair, of half a million
    assert len({run.tobytes() for run in levels}) < 1000
    credence.check(levels, np.eye(1))
    long = rng.choice([-1.0, 1.0], size=(3, 1000, 1))
    long[2] = long[0]
    with pytest.raises(ValueError, match=r"error\[2\] has the same numbers as error\[0\],"):
        credence.check(long, np.eye(1))


def test_with_dt_the_time_of_steps_is_told():
    error, P, nu, S = play()
    error[:, 20:] *= 3.0
    says = credence.check(error, P, nu, S, dt=0.5).says
    assert "from step 21 on (t = 10.5 s)" in says, says
    assert says.replace(" (t = 10.5 s)", "") == credence.check(error, P, nu, S).says
    with pytest.raises(ValueError, match="dt = -1"):
        credence.check(error, P, nu, S, dt=-1)


def numbers(told, key=""):
    """All p-values of a document, by what is tested."""
    if isinstance(told, dict):
        name = f"{key}/{told['name']}" if isinstance(told.get("name"), str) else key
        for k, value in told.items():
            yield from numbers(value, f"{name}/{k}")
    elif isinstance(told, list):
        for value in told:
            yield from numbers(value, key)
    elif isinstance(told, float) and ("p_value" in key or "adjusted" in key):
        yield key, told


def causes_of(told):
    return [cause["cause"] for cause in told["battery"]["causes"]]


# One direction is too large by 1.5: each order of the states has its own Cholesky factor, and had its own word.
# Units are powers of ten: ranges of σ are quarters of decades.
@pytest.mark.parametrize("names", [("a", "b", "c", "d"), ("p.a", "v.b", "p.c", "v.d")])
def test_neither_order_nor_units_of_the_states_change_what_is_said(tmp_path, names):
    random = np.random.default_rng(5)
    runs, steps, n = 25, 20, 4
    error, P = np.empty((runs, steps, n)), np.empty((runs, steps, n, n))
    for r in range(runs):
        A = random.normal(size=(n, n))
        P[r] = A @ A.T + 0.3 * np.eye(n)
        for k in range(steps):
            G = np.diag(1.0 + 0.5 * random.random(n))
            P[r, k] = G @ P[r, k] @ G
            values, vectors = np.linalg.eigh(P[r, k])
            u = random.normal(size=n) * np.array([1.0, 1.0, 1.0, np.sqrt(1.5)])
            error[r, k] = vectors @ (np.sqrt(values) * u)
    P = (P + P.swapaxes(2, 3)) / 2
    nu, S = random.normal(size=(runs, steps, 1)), np.ones((runs, steps, 1, 1))

    def said(order, unit):
        unit, path = np.asarray(unit)[order], tmp_path / "log.csv"
        write_log(path, error[..., order] * unit, P[:, :, order][..., order] * np.outer(unit, unit), nu, S,
                  [names[i] for i in order])
        return checked(path)

    right = said([0, 1, 2, 3], [1, 1, 1, 1])
    expected = sorted(value for key, value in numbers(right) if "/calibration" not in key)
    assert len(expected) > 20
    for order, unit in [([3, 1, 0, 2], [1, 1, 1, 1]), ([2, 3, 1, 0], [1, 1, 1, 1]), ([1, 0, 3, 2], [1, 1, 1, 1]),
                        ([0, 1, 2, 3], [1e-3, 100, 1, 10]), ([2, 0, 3, 1], [1e3, 1, 1e3, 1])]:
        other = said(order, unit)
        assert other["verdict"] == right["verdict"]
        assert causes_of(other) == causes_of(right)
        values = sorted(value for key, value in numbers(other) if "/calibration" not in key)
        assert values == pytest.approx(expected, rel=1e-9), order


def test_a_result_goes_to_another_process_without_its_report(tmp_path):
    result = credence.check(*play(), names=["x", "v"])
    came = pickle.loads(pickle.dumps(result))
    assert came.verdict == result.verdict and came.p_value == result.p_value and came.says == result.says
    assert repr(came) == repr(result) and came.to_dict() == result.to_dict()
    assert came.tests == result.tests and np.array_equal(came.mean_nees, result.mean_nees)
    assert pickle.loads(pickle.dumps(came)).to_dict() == result.to_dict()
    with pytest.raises(ValueError, match="was pickled has no figures left"):
        came.report(tmp_path / "out")
    assert not (tmp_path / "out").exists()
    for copied in (copy.copy(result), copy.deepcopy(result)):
        assert os.path.exists(copied.report(tmp_path / "copied"))


def test_swapped_axes_are_told_and_not_judged(tmp_path):
    arrays = play(runs=50, steps=100)
    swapped = [np.swapaxes(array, 0, 1) for array in arrays]
    for result in (credence.check(*swapped), credence.check(*swapped[:2])):
        assert result.verdict == "undecided" and not result.causes
        assert "swapped" in result.says
        assert "(steps, runs, n) is given for (runs, steps, n)" in result.remarks[0]
        assert "swapped" in repr(result)
    assert not credence.check(*arrays).remarks
    error, P, nu, S = swapped
    np.savez(tmp_path / "swapped.npz", error=error, P=P, innovation=nu, S=S)
    logged = credence.check_logs(str(tmp_path / "swapped.npz"))
    assert logged.verdict == "undecided" and not logged.causes
    assert "swapped" in logged.says and any("axes of the arrays look swapped" in r for r in logged.remarks)


def test_a_name_says_that_a_state_is_an_angle(tmp_path):
    random = np.random.default_rng(0)
    error = 0.1 * random.normal(size=(30, 40, 2))
    error[..., 1] += 2.0 * np.pi * random.integers(-1, 2, size=(30, 40))
    P = 0.01 * np.eye(2)
    named = credence.check(error, P, names=["x", "h:angle"])
    assert named.verdict == "consistent" and [b.name for b in named.blocks] == ["x", "h"]
    assert named.to_dict() == credence.check(error, P, names=["x", "h"], angles=["h"]).to_dict()
    np.savez(tmp_path / "a.npz", error=error, P=np.broadcast_to(P, (30, 40, 2, 2)), names=np.array(["x", "h:angle"]))
    assert credence.check_logs(str(tmp_path / "a.npz")).p_value == named.p_value
    with pytest.raises(ValueError, match="different words"):
        credence.check(error, P, names=["h", "h:angle"])
