import math
import pickle

import credence
import numpy as np
import pytest
from credence._play import Chunk
from credence._tune_filter import _Scores
from filters import H, Q, R
from plugs import Filter, Growing, MapWorld, World


class Scaled(Filter):
    """Believes in multiples of the world's noise."""

    def __init__(self, q=1.0, r=1.0):
        self.believed_Q, self.believed_R = q * Q, r * R

    def update(self, z):
        self.innovation = z - self.state @ H.T
        self.S = H @ self.covariance @ H.T + self.believed_R
        K = self.covariance @ H.T / self.S
        self.state = self.state + np.squeeze(K @ self.innovation[..., np.newaxis], axis=-1)
        P = self.covariance - K @ self.S @ np.swapaxes(K, -1, -2)
        self.covariance = 0.5 * (P + np.swapaxes(P, -1, -2))


def test_finds_the_noise_of_the_world():
    tuning = credence.tune_filter(World(), Scaled, {"q": 5.0, "r": 0.3}, runs=80, steps=60)
    for name in ("q", "r"):
        p = tuning.parameters[name]
        assert p.identifiable and p.before == {"q": 5.0, "r": 0.3}[name]
        deviation = math.log(p.upper / p.lower) / (2 * 1.96)
        assert deviation < 0.3 and abs(math.log(p.value)) < 5 * deviation
        assert tuning.factors[name] == p.value
    assert tuning.before.verdict != "consistent"
    assert tuning.held_out.verdict == "consistent"
    assert tuning.correlation.shape == (2, 2)
    assert "log score" in repr(tuning)
    assert repr(pickle.loads(pickle.dumps(tuning))) == repr(tuning)
    assert repr(tuning).endswith(f"Verdict on fresh noise: {tuning.before.verdict} as it was, consistent with the tuned noise.\n")


def test_what_has_no_effect_is_held():
    class Deaf(Scaled):
        def __init__(self, q=1.0, nothing=1.0):
            super().__init__(q)

    tuning = credence.tune_filter(World(), Deaf, {"q": 2.0, "nothing": 3.0}, runs=40, steps=30)
    assert not tuning.parameters["nothing"].identifiable
    assert tuning.factors["nothing"] == 3.0
    assert tuning.parameters["q"].identifiable


def test_errors_name_what_is_wrong():
    with pytest.raises(ValueError, match="q = 0: only what is positive"):
        credence.tune_filter(World(), Scaled, {"q": 0.0}, runs=5, steps=5)
    with pytest.raises(ValueError, match="nothing to tune"):
        credence.tune_filter(World(), Scaled, {}, runs=5, steps=5)

    class Silent(Scaled):
        def update(self, z):
            super().update(z)
            self.innovation = None

    with pytest.raises(ValueError, match="no scores"):
        credence.tune_filter(World(), Silent, {"q": 1.0}, runs=5, steps=5)


@pytest.mark.parametrize(
    "start, told",
    [
        ([1.0], "start = .*: expected factors by name"),
        ({1: 1.0}, "start: 1: expected the name of an argument"),
        ({"q": "a"}, "start: q = 'a': expected a number"),
        ({"q": True}, "start: q = True: expected a number"),
    ],
)
def test_a_start_that_is_none_is_named(start, told):
    with pytest.raises(ValueError, match=told):
        credence.tune_filter(World(), Scaled, start, runs=5, steps=5)
    with pytest.raises(credence.PlugError, match="the filter is a Scaled"):
        credence.tune_filter(World(), Scaled(), {"q": 1.0}, runs=5, steps=5)


def test_factors_are_keyword_arguments_of_the_filter():
    with pytest.raises(credence.PlugError, match=r"made by Scaled\(p=1.0\), which fails: .* 'p'; p of `start` are"):
        credence.tune_filter(World(), Scaled, {"p": 1.0}, runs=5, steps=5)
    with pytest.raises(credence.PlugError, match=r"made by Filter\(q=1.0, r=2.0\), .*; q, r of `start` are its keyword arguments"):
        credence.tune_filter(World(), Filter, {"q": 1.0, "r": 2.0}, runs=5, steps=5)

    def scaled(q):
        return Scaled(q)

    with pytest.raises(credence.PlugError, match=r"made by scaled\(\), which fails: missing a required argument: 'q'$"):
        credence.study(World(), scaled, runs=5, steps=5)

    class Wrong(Scaled):
        def __init__(self, q=1.0):
            super().__init__(q + "a")

    with pytest.raises(TypeError, match="unsupported operand"):  # its own
        credence.tune_filter(World(), Wrong, {"q": 1.0}, runs=5, steps=5)


def test_processes_change_nothing():
    one, two = (
        credence.tune_filter(World(), Scaled, {"q": 5.0}, runs=130, steps=20, workers=workers) for workers in (1, 2)
    )
    assert two.factors == one.factors and repr(two) == repr(one)


class Expanding(Growing):
    """Believes in r times the noise of what sees its landmark, and tells that innovation."""

    def __init__(self, r=1.0):
        super().__init__()
        self.r = r

    def update(self, z):
        f, (z, seen) = self.filter, z
        super().update((z, None))
        self.innovation, self.S = {"": f.innovation}, {"": f.S}
        if seen is None:
            return
        noise = 0.25 * self.r
        if f.place is None:
            f.place, f.variance = seen, noise
            return
        self.innovation["landmark"], self.S["landmark"] = seen - f.place, np.array([[f.variance + noise]])
        K = f.variance / (f.variance + noise)
        f.place, f.variance = f.place + K * (seen - f.place), (1.0 - K) * f.variance


def test_a_filter_whose_state_grows_is_tuned():
    names = ["vehicle", "speed", "landmark"]
    tuning = credence.tune_filter(MapWorld(), Expanding, {"r": 4.0}, names=names, runs=60, steps=20)
    p = tuning.parameters["r"]
    assert p.identifiable and p.lower < 1.0 < p.upper and p.upper < 1.5
    assert (tuning.before.verdict, tuning.held_out.verdict) == ("pessimistic", "consistent")


def scores_of(innovations):
    """Value, Σ NIS, Σ lag-one products of each run, steps and components of all."""
    runs, steps = next(iter(innovations.values()))[0].shape[:2]
    scores = _Scores()
    scores.add(Chunk(np.zeros((runs, steps, 1)), np.ones((runs, steps, 1, 1)), innovations, None))
    *sums, ok, _ = scores.all()
    assert ok
    return sums


def test_the_neighbours_of_an_innovation_are_those_of_its_sensor_however_long_ago():
    often, seldom = np.ones((1, 21, 1)), np.full((1, 21, 1), np.nan)
    seldom[0, 2::5, 0] = [2.0, -2.0, 2.0, -2.0]
    assert scores_of({"seldom": (seldom, np.full((1, 21, 1, 1), 4.0))})[2] == -3.0
    both = {"often": (often, np.ones((1, 21, 1, 1))), "seldom": (seldom, np.full((1, 21, 1, 1), 4.0))}
    assert scores_of(both)[2] == 20.0 - 3.0


def test_of_an_innovation_that_is_silent_in_part_the_rest_scores():
    rng = np.random.default_rng(2)
    nu, root = rng.standard_normal((4, 15, 3)), rng.standard_normal((4, 15, 3, 3))
    S = root @ np.swapaxes(root, -1, -2) + np.eye(3)
    nu[rng.random(nu.shape) < 0.4] = np.nan
    S[:, :, 1, 0] = S[:, :, 0, 1] = np.where(np.isnan(nu[..., 0]), np.nan, S[:, :, 0, 1])
    value, nis, lag_one, steps, dof = scores_of({"": (nu, S)})
    wanted = np.zeros((3, 4))
    for run in range(4):
        before = np.zeros(3)
        for k in range(15):
            i = np.flatnonzero(~np.isnan(nu[run, k]))
            block, part = S[run, k][np.ix_(i, i)], nu[run, k, i]
            of_part = part @ np.linalg.solve(block, part) if i.size else 0.0
            u = np.linalg.solve(np.linalg.cholesky(block), part)
            wanted[:, run] += [-0.5 * (np.linalg.slogdet(2.0 * np.pi * block)[1] + of_part), of_part, u @ before[i]]
            before[i] = u
    np.testing.assert_allclose([value, nis, lag_one], wanted, rtol=1e-9)
    shown = ~np.isnan(nu)
    assert not shown.any(axis=-1).all() and (steps, dof) == (shown.any(axis=-1).sum(), shown.sum())


class Pair(World):
    """Measures the second state at every third step alone."""

    def measure(self, x, k, noise):
        z = x + 0.5 * noise(2)
        return z if k % 3 == 0 else np.where([True, False], z, np.nan)


class InTurn(Filter):
    """Takes the components one after the other."""

    def __init__(self, r=1.0):
        self.r = r

    def update(self, z):
        self.innovation, self.S = np.full(z.shape, np.nan), np.tile(np.eye(2), (len(z), 1, 1))
        for i in np.flatnonzero(~np.isnan(z[0])):
            self.innovation[:, i] = z[:, i] - self.state[:, i]
            self.S[:, i, i] = self.covariance[:, i, i] + 0.25 * self.r
            K = self.covariance[:, :, i] / self.S[:, i, i, np.newaxis]
            self.state = self.state + K * self.innovation[:, i, np.newaxis]
            self.covariance = self.covariance - K[:, :, np.newaxis] * self.covariance[:, i, np.newaxis, :]
            self.covariance = 0.5 * (self.covariance + np.swapaxes(self.covariance, -1, -2))


class Apart(InTurn):
    def update(self, z):
        super().update(z)
        self.innovation = {"x": self.innovation[:, :1], "v": self.innovation[:, 1:]}
        self.S = {"x": self.S[:, :1, :1], "v": self.S[:, 1:, 1:]}


def test_one_innovation_of_two_sensors_tunes_as_two():
    one, two = (credence.tune_filter(Pair(), make, {"r": 3.0}, runs=60, steps=30, seed=2) for make in (InTurn, Apart))
    of_one, of_two = one.parameters["r"], two.parameters["r"]
    assert of_one.lower < 1.0 < of_one.upper
    assert of_one.value == pytest.approx(of_two.value, rel=1e-6)
    assert of_two.lower < 1.0 < of_two.upper
    assert one.held_out.verdict == "consistent"
    assert not any("scored apart" in note for note in one.notes)
    assert any("scored apart" in note for note in two.notes), "that one comes after the other cannot be seen"
    assert (one.to_dict()["intervals"], two.to_dict()["intervals"]) == ("observed information", "sandwich")
    scores = [t.to_dict()["log_score"]["before"] for t in (one, two)]
    assert scores[0] == pytest.approx(scores[1], rel=1e-9), "a step counts once, however many sensors it has"


def test_what_a_study_is_told_its_studies_are():
    told = {"names": ["x", "v"], "units": ["m", "m/s"], "blocks": {"both": [0, 1]}, "nonlinear": True, "inflated": True}
    tuning = credence.tune_filter(World(), Scaled, {"q": 5.0}, runs=40, steps=20, **told)
    for of_tuning, q in ((tuning.before, 5.0), (tuning.held_out, tuning.factors["q"])):
        alone = credence.study(World(), lambda q=q: Scaled(q=q), runs=40, steps=20, seed=2, **told)
        assert of_tuning.to_dict() == alone.to_dict()


def test_noise_is_that_of_a_study():
    plain = credence.tune_filter(World(), Scaled, {"r": 1.0}, runs=60, steps=30)
    noisy = credence.tune_filter(
        World(), Scaled, {"r": 1.0}, runs=60, steps=30, noise={"outlier_rate": 0.05, "outlier_scale": 10}
    )
    assert noisy.factors["r"] > 2.0 * plain.factors["r"]


def test_ctrl_c_is_not_swallowed():
    class Interrupted(Scaled):
        made = 0

        def __init__(self, q=1.0):
            super().__init__(q)
            Interrupted.made += 1
            if Interrupted.made > 6:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        credence.tune_filter(World(), Interrupted, {"q": 2.0}, runs=40, steps=10)


@pytest.mark.parametrize("wrong", [{"runs": 80.0}, {"runs": 0}, {"steps": "a"}, {"seed": -1}, {"noise_group": 0.5}])
def test_numbers_that_are_none_are_named(wrong):
    (name,) = wrong
    with pytest.raises(ValueError, match=f"{name} = .*: expected a whole number from"):
        credence.tune_filter(World(), Scaled, {"q": 1.0}, **{"runs": 5, "steps": 5, **wrong})


def test_what_is_wrong_is_named_before_anything_is_played():
    class Counting(Scaled):
        updates = 0

        def update(self, z):
            Counting.updates += 1
            super().update(z)

    for wrong in ({"nonlinear": "no"}, {"inflated": 1}, {"units": ["m"]}, {"blocks": {"a": [7]}}):
        (argument,) = wrong
        with pytest.raises(ValueError, match=f"^{argument}"):
            credence.tune_filter(World(), Counting, {"q": 1.0}, runs=5, steps=5, **wrong)
        with pytest.raises(ValueError, match=f"^{argument}"):
            credence.study(World(), Counting, runs=5, steps=5, **wrong)
    assert Counting.updates == 0


def test_batch_is_a_flag():
    with pytest.raises(ValueError, match="^batch = 'no': expected True or False"):
        credence.tune_filter(World(), Scaled, {"q": 1.0}, runs=5, steps=5, batch="no")


@pytest.mark.parametrize("seed", [1, 2, 3, 5])
def test_trials_that_fail_do_not_end_the_search(seed):
    class Limited(Scaled):
        def __init__(self, q=1.0, r=1.0):
            super().__init__(q, r)
            self.lost = q > 4.0

        def update(self, z):
            super().update(z)
            if self.lost:
                raise RuntimeError("lost lock")

    whole = credence.tune_filter(World(), Scaled, {"q": 1.0, "r": 0.3}, runs=40, steps=60, seed=seed)
    tuning = credence.tune_filter(World(), Limited, {"q": 1.0, "r": 0.3}, runs=40, steps=60, seed=seed)
    for name in ("q", "r"):
        p, right = tuning.parameters[name], whole.parameters[name]
        assert abs(math.log(p.value / right.value)) < 0.1 * math.log(right.upper / right.lower)
    assert not any("no noise of this form" in note or "did not converge" in note for note in tuning.notes)
