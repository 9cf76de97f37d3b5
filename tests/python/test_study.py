import os
import signal
import subprocess
import sys
import time
import warnings

import credence
import numpy as np
import pytest

from filters import F, H, Q, R
from plugs import LATE, Filter, Fragile, Growing, MapWorld, Optimistic, TimedFilter, TimedWorld, UntimedNoise, World

STUDY = {"runs": 150, "steps": 40, "seed": 4}


def test_the_right_filter_is_consistent_and_a_wrong_one_is_named():
    assert credence.study(World(), Filter, **STUDY).verdict == "consistent"
    wrong = credence.study(World(), Optimistic, names=["x", "v"], **STUDY)
    assert wrong.verdict == "optimistic"
    assert wrong.causes[0].name == "process noise Q assumed too small"
    assert "v" in [b.name for b in wrong.blocks if b.verdict == "optimistic"]


def test_late_measurements_are_named():
    late = credence.study(World(), Filter, noise={"measurement_delay": 3}, **STUDY)
    assert late.causes[0].name.startswith("measurements that arrive late")


def test_an_innovation_that_is_an_angle_and_not_wrapped_is_named():
    class Unwrapped(Filter):
        def update(self, z):
            super().update(z)
            self.innovation = self.innovation + 2.0 * np.pi

    plain = credence.study(World(), Unwrapped, **STUDY)
    assert "not wrapped" not in plain.causes[0].name
    for which in (True, [0]):
        named = credence.study(World(), Unwrapped, innovation_angles=which, **STUDY)
        assert named.causes[0].name == "an angle that is not wrapped"
    with pytest.raises(ValueError, match="innovation_angles"):
        credence.study(World(), Unwrapped, innovation_angles=[7], **STUDY)


def test_the_bits_do_not_depend_on_processes():
    batches = {"runs": 600, "steps": 10}  # two
    one = credence.study(World(), Optimistic, **batches)
    assert credence.study(World(), Optimistic, workers=2, **batches).to_dict() == one.to_dict()


class _ViewedWorld(World):
    """Measures by a view of the truth, which is exact, and has a minus() of its own."""

    def measure(self, x, k, noise):
        return x[..., :1]

    def minus(self, estimate, truth):
        return estimate - truth


def test_what_is_handed_over_may_be_changed():
    class InPlace(_ViewedWorld):
        def minus(self, estimate, truth):
            estimate -= truth
            truth *= 0.0
            return estimate

    class Consuming(Filter):
        def update(self, z):
            super().update(z)
            z *= 0.0

    expected = credence.study(_ViewedWorld(), Filter, **STUDY).mean_nees
    np.testing.assert_array_equal(credence.study(InPlace(), Consuming, **STUDY).mean_nees, expected)


def test_what_a_property_throws_is_not_taken_for_its_absence():
    class Mistyped(Filter):
        innovation = property(lambda self: self._nu)

        def update(self, z):
            pass

    with pytest.raises(credence.PlugError, match="every run fails, the first at step 1: AttributeError: .*_nu"):
        credence.study(World(), Mistyped, **STUDY)


def test_batches_and_single_runs_agree():
    batched = credence.study(World(), Optimistic, **STUDY)
    single = credence.study(World(), Optimistic, batch=False, **STUDY)
    np.testing.assert_allclose(single.mean_nees, batched.mean_nees, rtol=1e-9)
    assert single.verdict == batched.verdict


class _OneOfTwoCameras(World):
    """Of each run one camera sees: b where it is to, else a."""

    def initial(self, noise):
        self.sees_b = noise(1)[..., 0] > 0
        return super().initial(noise)


class _SeenByOne(Filter):
    def update(self, z):
        super().update(z)
        sensor = "b" if self.world.sees_b else "a"
        self.innovation, self.S = {sensor: self.innovation}, {sensor: self.S}


def test_sensors_that_only_some_runs_have_are_kept_of_single_runs():
    world = _OneOfTwoCameras()
    _SeenByOne.world = world
    result = credence.study(world, _SeenByOne, batch=False, runs=40, steps=20, seed=3)
    assert {sensor.name for sensor in result.sensors} == {"a", "b"}
    assert result.to_dict()["nis"]["values"] == 40 * 20


class _HeardLate(Filter):
    """The runs of the second batch, of 88, have another sensor."""

    def update(self, z):
        super().update(z)
        sensor = "b" if len(z) == 88 else "a"
        self.innovation, self.S = {sensor: self.innovation}, {sensor: self.S}


def test_a_sensor_that_is_first_heard_late_is_one():
    result = credence.study(World(), _HeardLate, runs=600, steps=10)
    assert [sensor.name for sensor in result.sensors] == ["a", "b"]
    assert result.to_dict()["nis"]["values"] == 600 * 10
    alone = credence.study(World(), Filter, runs=600, steps=10)
    np.testing.assert_array_equal(result.mean_nees, alone.mean_nees)


def test_what_makes_no_filter_is_told():
    with pytest.raises(credence.PlugError, match="the filter is a Filter: expected what makes one when it is called"):
        credence.study(World(), Filter(), **STUDY)
    with pytest.raises(ValueError, match="workers = 2: world and filter cannot be handed to other processes"):
        credence.study(World(), lambda: Filter(), workers=2, **STUDY)


def test_a_study_is_a_check_of_what_it_played():
    kept = []

    class Spied(Filter):
        def update(self, z):
            super().update(z)
            kept.append((self.state, self.covariance, self.innovation, self.S))

    truths = []

    class Watched(World):
        def measure(self, x, k, noise):
            truths.append(x)
            return super().measure(x, k, noise)

    studied = credence.study(Watched(), Spied, runs=64, steps=20)
    state, P, nu, S = (np.stack([step[i] for step in kept[-20:]], axis=1) for i in range(4))
    checked = credence.check(state - np.stack(truths[-20:], axis=1), P, nu, S)
    assert checked.mean_nees.tolist() == studied.mean_nees.tolist()
    assert checked.p_value == studied.p_value


def test_noise_is_a_function_of_run_and_step():
    seen = {}

    class Listening(World):
        def step(self, x, k, noise):
            drawn = np.concatenate([noise(1), noise(1)], axis=-1)
            seen.setdefault((len(x), k), drawn)
            return x

    credence.study(Listening(), Filter, runs=70, steps=9)
    values = np.concatenate([v.ravel() for key, v in seen.items() if key[0] == 70])
    assert len(np.unique(values)) == values.size
    # 9 steps of 140: a mean of 0 and a variance of 1, within 5 standard errors.
    assert abs(values.mean()) < 5.0 / np.sqrt(values.size)
    assert abs(values.var() - 1.0) < 5.0 * np.sqrt(2.0 / values.size)


def test_an_exception_is_a_failed_run():
    result = credence.study(World(), Fragile, **STUDY)
    assert 0 < len(result.failures) < STUDY["runs"] / 2
    failure = result.failures[0]
    assert failure["outcome"] == "threw" and failure["says"] == "seed 4: RuntimeError: lost"
    alone = credence.study(World(), Fragile, batch=False, **STUDY)
    assert alone.failures == result.failures
    np.testing.assert_allclose(alone.mean_nees, result.mean_nees, rtol=1e-9)
    assert "threw at step" in repr(result)


def test_an_exception_of_the_world_is_no_failed_run():
    class Measures(World):
        def measure(self, x, k, noise):
            if k == 3 and x[0, 0] > 0.0:
                raise ArithmeticError("beyond its range")
            return super().measure(x, k, noise)

    class Subtracts(World):
        def minus(self, estimate, truth):
            if estimate[0, 0] > 0.0 or np.isnan(estimate).any():
                raise ArithmeticError("no difference")
            return estimate - truth

    class Lost(Filter):
        def update(self, z):
            self.state = np.full_like(self.state, np.nan)

    for world, function, said in ((Measures(), "measure", "beyond its range"), (Subtracts(), "minus", "no difference")):
        where = rf"^world\.{function}\(\) raises ArithmeticError: {said}, in run \d+ at step \d+, seed 4 .*batch=False"
        with pytest.raises(credence.PlugError, match=where):
            credence.study(world, Filter, **STUDY)
    with pytest.raises(credence.PlugError, match="every run fails"):  # the filter's own, as its estimate is NaN
        credence.study(Subtracts(), Lost, **STUDY)


def test_innovation_angles_without_an_innovation_are_refused():
    class Silent(Filter):
        def update(self, z):
            super().update(z)
            self.innovation = None

    with pytest.raises(ValueError, match="^innovation_angles belongs to filter.innovation, which is None at every step"):
        credence.study(World(), Silent, innovation_angles=[7], **STUDY)


def test_innovation_angles_of_a_sensor_that_is_not_there_are_refused():
    with pytest.raises(ValueError, match=r"innovation_angles has the sensors \['gps'\], the filter's innovation \[''\]"):
        credence.study(World(), Filter, innovation_angles={"gps": [0]}, **STUDY)


def test_what_is_not_finite_is_a_failed_run():
    class Diverging(Filter):
        def update(self, z):
            super().update(z)
            self.state = np.where(np.abs(self.state) > 25.0, np.inf, self.state)

    failures = credence.study(World(), Diverging, **STUDY).failures
    assert failures and all(f["outcome"] == "diverged" for f in failures)


def test_the_numbers_are_those_of_the_built_in_filter_in_the_same_world():
    H = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])

    class Monobot:
        def prior(self):
            return np.zeros(3), np.eye(3)

        def initial(self, noise):
            return noise(3)

        def step(self, x, k, noise):
            return x + np.sqrt(0.1) * noise(1) * np.array([1.0, 0.0, 0.0])

        def measure(self, x, k, noise):
            return x @ H.T + np.sqrt(0.1) * noise(2)

    class MonobotFilter(Filter):
        def predict(self):
            self.covariance = self.covariance + np.diag([0.03, 0.0, 0.0])

        def update(self, z):
            self.innovation, self.S = z - self.state @ H.T, H @ self.covariance @ H.T + 0.1 * np.eye(2)
            K = self.covariance @ H.T @ np.linalg.inv(self.S)
            self.state = self.state + (K @ self.innovation[..., np.newaxis])[..., 0]
            P = self.covariance - K @ self.S @ K.transpose(0, 2, 1)
            self.covariance = 0.5 * (P + P.transpose(0, 2, 1))

    scenario = {
        "world": {"model": "monobot", "landmarks": 2},
        "study": {"runs": 130, "steps": 30, "seed": 8},
        "filter": {"process_scale": 0.3},
    }
    built_in = credence.run(scenario)
    group = credence.noise_group(scenario)
    plugged = credence.study(Monobot(), MonobotFilter, runs=130, steps=30, seed=8, noise_group=group)
    np.testing.assert_allclose(plugged.mean_nees, built_in.mean_nees, rtol=1e-9)
    np.testing.assert_allclose(plugged.mean_nis, built_in.mean_nis, rtol=1e-9)
    assert plugged.verdict == built_in.verdict == "optimistic"


class Lost(Filter):
    """Loses its state, not its covariance."""

    def update(self, z):
        super().update(z)
        self.state = np.where(self.state > 25.0, np.nan, self.state)


def test_where_minus_is_nan_there_is_no_truth():
    class Blind(World):
        def minus(self, estimate, truth):
            return np.where(np.abs(truth) > 20.0, np.nan, estimate - truth)

    result = credence.study(Blind(), Filter, names=["x", "v"], **STUDY)
    values = result.to_dict()["blocks"]["x"]["values"]
    assert not result.failures and result.verdict == "consistent"
    assert 0.5 * STUDY["runs"] * STUDY["steps"] < values < STUDY["runs"] * STUDY["steps"]
    alone = credence.study(Blind(), Filter, names=["x", "v"], batch=False, **STUDY)
    assert not alone.failures and alone.to_dict()["blocks"]["x"]["values"] == values
    lost = credence.study(Blind(), Lost, **STUDY)
    assert lost.failures and lost.failures == credence.study(World(), Lost, **STUDY).failures


def test_a_truth_that_is_nan_is_none():
    class Partly(World):
        """Knows its second state at every fourth step."""

        def initial(self, noise):
            self.x = super().initial(noise)
            return self.x

        def step(self, x, k, noise):
            self.x = super().step(self.x, k, noise)
            return self.x if k % 4 == 0 else np.where([True, False], self.x, np.nan)

        def measure(self, x, k, noise):
            return super().measure(self.x, k, noise)

    blocks = credence.study(Partly(), Filter, names=["x", "v"], **STUDY).to_dict()["blocks"]
    assert blocks["v"]["values"] * 4 == blocks["x"]["values"] == STUDY["runs"] * STUDY["steps"]


def test_a_state_that_is_no_array_is_lost_where_its_error_is_nan():
    class OfPairs(World):
        def minus(self, estimate, truth):
            x, v = estimate
            return np.stack([x, v[..., 0]], axis=-1) - truth

    class Paired(Shown):
        make = Filter

        def __init__(self):
            self._own = self.make()

        @property
        def state(self):
            return self._own.state[..., 0], self._own.state[..., 1:]

    class LostPair(Paired):
        make = Lost

    paired, plain = credence.study(OfPairs(), Paired, **STUDY), credence.study(World(), Filter, **STUDY)
    assert not paired.failures
    np.testing.assert_allclose(paired.mean_nees, plain.mean_nees, rtol=1e-9)
    lost = credence.study(OfPairs(), LostPair, **STUDY).failures
    assert lost and lost == credence.study(World(), Lost, **STUDY).failures


def test_silent_steps_and_several_sensors():
    class Twice(World):
        def measure(self, x, k, noise):
            return None if k % 3 == 0 else super().measure(x, k, noise)

    class Two(Filter):
        def update(self, z):
            super().update(z)
            self.innovation, self.S = {"gps": self.innovation}, {"gps": self.S}

    result = credence.study(Twice(), Two, **STUDY)
    assert [s.name for s in result.sensors] == ["gps"]
    assert np.isnan(result.mean_nis[2]) and result.mean_nis[3] > 0.0
    assert result.verdict == "consistent"


def test_numbers_that_are_none_are_named():
    def message(**options):
        with pytest.raises(ValueError) as error:
            credence.study(World(), Filter, runs=10, steps=5, **options)
        return str(error.value)

    assert message(seed=-1) == "seed = -1: expected a whole number from 0 to 18446744073709551615"
    assert message(seed=1.5).startswith("seed = 1.5: ")
    assert message(noise_group=2**64).startswith("noise_group = 18446744073709551616: ")
    for delay in (-1, 1.5):
        expected = f"noise['measurement_delay'] = {delay}: expected whole steps, from 0 on"
        assert message(noise={"measurement_delay": delay}) == expected


@pytest.mark.parametrize(
    ("mean", "P", "why"),
    [
        ([0.0, np.nan], np.eye(2), "the mean of .* is not finite"),
        ([0.0, 0.0], [[1.0, 0.0], [0.0, np.inf]], "the covariance of .* is not finite"),
        ([0.0, 0.0], [[1.0, 0.5], [0.2, 1.0]], "the covariance of .* is not symmetric"),
        ([0.0, 0.0], -np.eye(2), "the covariance of .* is not positive semidefinite"),
        ([0.0, 0.0], [[1e-12, 2e-6], [2e-6, 1.0]], "the covariance of .* is not positive semidefinite"),
    ],
)
def test_a_prior_that_no_filter_can_start_from_is_named(mean, P, why):
    class Bad(World):
        def prior(self):
            return np.array(mean), np.array(P)

    with pytest.raises(credence.PlugError, match=why):
        credence.study(Bad(), Filter, runs=10, steps=5)


@pytest.mark.parametrize("prior", [(0.0, 1.0), (np.zeros(0), np.zeros((0, 0)))])
def test_a_prior_that_is_none_is_named(prior):
    class Vague(World):
        def prior(self):
            return prior

    with pytest.raises(credence.PlugError, match=r"the mean of world.prior\(\) has shape \(0?,?\): expected \(n,\)"):
        credence.study(Vague(), Filter, runs=10, steps=5)


def test_no_study_has_more_runs_than_memory_for_their_list():
    with pytest.raises(ValueError, match="runs = 1000000000000: expected a whole number from 1 to 1000000000"):
        credence.study(World(), Filter, runs=10**12, steps=10)


@pytest.mark.parametrize("rounding", [1e-14, 1e-9])
def test_a_filter_may_round_differently_at_each_replay(rounding):
    """As numpy does where the last bit depends on where an array lies; the larger one as from a diffuse prior."""

    class Rounding(Filter):
        calls = 0

        def update(self, z):
            super().update(z)
            Rounding.calls += 1
            off = 1.0 + rounding * (Rounding.calls % 2)
            self.state, self.covariance = off * self.state, off * self.covariance

    assert credence.study(World(), Rounding, **{**STUDY, "steps": 5}).verdict == "consistent"
    assert Rounding.calls % 2 == 1  # of two replays of 5 steps, which differ


@pytest.mark.parametrize("batch", [True, False])
def test_a_world_may_draw_nothing(batch):
    drawn = set()

    class Certain(World):
        def initial(self, noise):
            drawn.add(noise(0).shape)
            return super().initial(noise)

        def step(self, x, k, noise):
            drawn.add(noise(0).shape)
            return super().step(x, k, noise)

    study = {"runs": 20, "steps": 6, "batch": batch}
    assert credence.study(Certain(), Filter, **study).to_dict() == credence.study(World(), Filter, **study).to_dict()
    assert drawn == ({(20, 0)} if batch else {(0,)})


def test_plugs_that_are_none_are_named():
    def message(world, make_filter):
        with pytest.raises(credence.PlugError) as error:
            credence.study(world, make_filter, **STUDY)
        return str(error.value)

    class Random(Filter):
        def update(self, z):
            super().update(z + np.random.standard_normal(z.shape))

    assert message(World(), Random).startswith("run 0 is not the same twice, in its error at step 1, ")

    class Seldom(World):
        """With noise of its own at every tenth step, and no measurement before."""

        def measure(self, x, k, noise):
            return x[:, :1] + np.random.standard_normal((len(x), 1)) if k % 10 == 0 else None

    assert message(Seldom(), Filter).startswith("run 0 is not the same twice, in its error at step 10, ")

    class Telling(Filter):
        """What it shows is not what it has used."""

        def update(self, z):
            super().update(z)
            self.innovation = self.innovation + np.random.standard_normal(z.shape)

    assert message(World(), Telling).startswith("run 0 is not the same twice, in its innovation at step 1, ")

    class Sampling(Filter):
        """As the mean of a million samples would be."""

        def update(self, z):
            super().update(z + 1e-3 * np.random.standard_normal(z.shape))

    assert message(World(), Sampling).endswith("draws random numbers of its own, or keeps something from run to run")

    class Remembering(Shown):
        seen = 0

        @property
        def covariance(self):
            Remembering.seen += 1
            return (1.0 + 0.001 * Remembering.seen) * self._own.covariance

    assert message(World(), Remembering).startswith("run 0 is not the same twice, in its covariance at step 1, ")

    for shape, shown in [  # NumPy would broadcast them
        ("(64, 1)", lambda x: x[:, :1]),
        ("(2,)", lambda x: x.mean(axis=0)),
        ("(1, 2)", lambda x: x[:1]),
        ("()", lambda x: None),
    ]:

        class Broad(Shown):
            state = property(lambda self, shown=shown: shown(self._own.state))

        assert message(World(), Broad) == f"filter.state has shape {shape}: expected (64, 2)"

    class Flat(Filter):
        def update(self, z):
            super().update(z)
            self.covariance = self.covariance[..., 0]

    assert message(World(), Flat) == "filter.covariance has shape (64, 2): expected (64, 2, 2) or (2, 2)"

    class Short(Filter):
        def update(self, z):
            super().update(z)
            self.S = self.S[:10]

    assert message(World(), Short) == "filter.S has shape (10, 1, 1): expected (64, 1, 1) or (1, 1)"

    class OneAxis(World):
        def measure(self, x, k, noise):
            return super().measure(x, k, noise)[:, 0]

    class Broadcasting(Filter):
        def update(self, z):
            super().update(z[..., np.newaxis])
            self.innovation = z - self.state @ H.T

    assert message(OneAxis(), Broadcasting) == (
        "filter.innovation has shape (64, 64), and filter.S (64, 1, 1): is z, as measure() returns it, of shape (64,), "
        "where (64, m) is expected?"
    )
    with pytest.raises(ValueError, match="runs = 0"):
        credence.study(World(), Filter, runs=0)
    with pytest.raises(ValueError, match="^names = 5: expected one for each state"):
        credence.study(World(), Filter, runs=5, names=5)
    with pytest.raises(ValueError, match="^noise = 5: expected a dict"):
        credence.study(World(), Filter, runs=5, noise=5)
    with pytest.raises(ValueError, match=r"^noise\['student_dof'\] = 1180591620717411303424: expected 0 to"):
        credence.study(World(), Filter, runs=5, noise={"student_dof": 2**70})

    class Halves(World):
        def measure(self, x, k, noise):
            return x[:, :1] + noise(1.0)

    assert "noise(1.0): expected how many numbers" in message(Halves(), Filter)

    class Vague(World):
        def prior(self):
            return self.told

    for told, kind in ((None, "NoneType"), (np.zeros(2), "ndarray"), ((0.0,), "tuple")):
        Vague.told = told
        assert message(Vague(), Filter) == (
            f"world.prior() gives {kind}: expected the mean (n,) and the covariance (n, n)"
        )
    for dt in (-1, float("nan"), float("inf"), 1e300, "a"):
        world = World()
        world.dt = dt
        with pytest.raises(credence.PlugError, match="^world.dt = .*: expected the time of a step in s"):
            credence.study(world, TimedFilter, runs=5, steps=5)
    for flag in ("batch", "nonlinear", "inflated"):
        with pytest.raises(ValueError, match=f"^{flag} = 'no': expected True or False"):
            credence.study(World(), Filter, runs=5, steps=5, **{flag: "no"})


@pytest.mark.parametrize(
    "noise, wrong",
    [
        ({"outlier_rate": 0.05, "outlier_scale": 10.0}, True),
        ({"measurement_correlation": 0.9}, True),
        ({"measurement_delay": 3}, True),
        ({"process_correlation": 0.0}, False),
    ],
)
def test_switches_of_the_noise_change_the_verdict(noise, wrong):
    result = credence.study(World(), Filter, noise=noise, **STUDY)
    plain = credence.study(World(), Filter, **STUDY)
    if wrong:
        assert result.verdict in ("optimistic", "mixed")
    else:
        assert result.to_dict() == plain.to_dict()


def test_a_late_measurement_is_late_by_so_many_steps():
    heard = []

    class Listening(Filter):
        def update(self, z):
            heard.append(z[0, 0])
            super().update(z)

    said = []

    class Spoken(World):
        def measure(self, x, k, noise):
            z = super().measure(x, k, noise)
            said.append(z[0, 0])
            return z

    credence.study(Spoken(), Listening, runs=1, steps=10, noise={"measurement_delay": 2})
    # The plug is tried twice over 5 steps first.
    assert heard[-8:] == said[-10:-2] and len(heard) == 2 * 3 + 8


def test_a_switch_that_there_is_not_is_named():
    with pytest.raises(ValueError, match=r"noise\['outliers'\]"):
        credence.study(World(), Filter, noise={"outliers": 0.1}, **STUDY)
    with pytest.raises(ValueError, match="degrees of freedom"):
        credence.study(World(), Filter, noise={"student_dof": 2}, **STUDY)


def test_noise_that_does_not_scale_with_the_time_step_is_named():
    timed = credence.study(TimedWorld(), TimedFilter, runs=64, steps=10)
    assert timed.to_dict() == credence.study(World(), Filter, runs=64, steps=10).to_dict()
    with pytest.raises(ValueError, match="Q does not scale with dt: two predictions of half a step"):
        credence.study(TimedWorld(), UntimedNoise, runs=64, steps=10)


class Masked(Growing):
    masks = True


class Overconfident(Growing):
    claimed = 0.25


MAP = {"names": ["vehicle", "speed", "landmark"], **STUDY}


def test_a_state_may_grow():
    result = credence.study(MapWorld(), Growing, **MAP)
    assert result.verdict == "consistent" and not result.failures
    landmark = result.to_dict()["blocks"]["landmark"]
    assert landmark["values"] == STUDY["runs"] * (STUDY["steps"] - LATE + 1)
    assert credence.study(MapWorld(), Masked, **MAP).to_dict() == result.to_dict()
    wrong = credence.study(MapWorld(), Overconfident, **MAP)
    assert [b.name for b in wrong.blocks if b.verdict == "optimistic"] == ["landmark"]
    alone = credence.study(MapWorld(), Growing, batch=False, **MAP)
    np.testing.assert_allclose(alone.mean_nees, result.mean_nees, rtol=1e-9)


def test_states_that_are_none_are_named():
    class Fourth(Growing):
        def states(self):
            return [0, 3]

    with pytest.raises(credence.PlugError, match=r"states\(\) = \[0, 3\]: there are 3 states"):
        credence.study(MapWorld(), Fourth, **MAP)

    class Endless(Growing):
        def states(self):
            return list(range(100))

    with pytest.raises(credence.PlugError, match=r"states\(\) = \[ 0,  1,  2, \.\.\., 97, 98, 99\]: there are 3 states"):
        credence.study(MapWorld(), Endless, **MAP)

    class Short(Growing):
        def states(self):
            return [0]

    with pytest.raises(credence.PlugError, match=r"filter.state has shape \(64, 2\): expected \(64, 1\)"):
        credence.study(MapWorld(), Short, **MAP)


def test_a_plug_that_never_runs_is_told_at_once():
    class Alone(Filter):
        def predict(self):
            self.state = F @ self.state

    with pytest.raises(credence.PlugError, match="every run fails, the first at step 1: ValueError: .*batch=False"):
        credence.study(World(), Alone, **STUDY)

    class Untimed(Filter):
        pass

    with pytest.raises(credence.PlugError, match="TypeError: .*of a world with dt predict"):
        credence.study(TimedWorld(), Untimed, **STUDY)

    class Renamed:
        predict = update = state = None

    with pytest.raises(credence.PlugError, match=r"the filter Renamed has no reset\(\): it needs reset\(\), predict\(\)"):
        credence.study(World(), Renamed, **STUDY)
    with pytest.raises(credence.PlugError, match="the world is the class World: expected one of it"):
        credence.study(World, Filter, **STUDY)


def test_of_a_world_with_dt_times_are_told():
    class Wrong(TimedFilter):
        def update(self, z):
            super().update(z)
            self.covariance = 0.1 * self.covariance if self.late() else self.covariance

        steps = 0

        def late(self):
            self.steps += 1
            return self.steps > 20

    result = credence.study(TimedWorld(), Wrong, **STUDY)
    assert " (t = " in result.says and result.says.endswith(" s)"), result.says


def test_of_several_sensors_the_clearest_lag_tells_the_cause():
    """A precise sensor at every step and a coarse one at every second, one after the other: with too small a Q their innovations
    at one step are correlated, too, which is no sign of one prior for both."""

    class TwoSensors(World):
        def measure(self, x, k, noise):
            both = noise(2) * np.sqrt([0.3, 3.0])
            seen = {"near": x[..., :1] + both[..., :1]}
            if k % 2 == 0:
                seen["far"] = x[..., :1] + both[..., 1:]
            return seen

    class InTurn(Filter):
        believed_Q = 0.1 * Q

        def update(self, z):
            self.innovation, self.S = {}, {}
            for name, value in z.items():
                self.innovation[name] = value - self.state @ H.T
                self.S[name] = H @ self.covariance @ H.T + {"near": 0.3, "far": 3.0}[name]
                K = self.covariance @ H.T / self.S[name]
                self.state = self.state + np.squeeze(K @ self.innovation[name][..., np.newaxis], axis=-1)
                P = self.covariance - K @ self.S[name] @ np.swapaxes(K, -1, -2)
                self.covariance = 0.5 * (P + np.swapaxes(P, -1, -2))

    result = credence.study(TwoSensors(), InTurn, runs=200, steps=60)
    assert result.verdict in ("optimistic", "mixed")
    assert result.causes[0].name == "process noise Q assumed too small"


class Turned(World):
    """Its minus() turns the sign of one state."""

    def minus(self, estimate, truth):
        return (estimate - truth) * [1.0, -1.0]


class Shown:
    """A right filter that shows something else."""

    def __init__(self):
        self._own = Filter()

    def __getattr__(self, name):
        return getattr(self._own, name)


class Deviations(Shown):
    @property
    def covariance(self):
        return np.sign(self._own.covariance) * np.sqrt(np.abs(self._own.covariance))


class Winding(Shown):
    @property
    def state(self):
        return self._own.state + [0.0, 2.0 * np.pi]


def test_mistakes_of_the_numbers_are_told_as_check_tells_them():
    assert not credence.study(World(), Filter, **STUDY).remarks
    turned = credence.study(Turned(), Filter, **STUDY)
    assert "opposite sign" in turned.remarks[0]
    deviations = credence.study(World(), Deviations, **STUDY)
    assert "P holds standard deviations" in deviations.remarks[0]
    assert not any("covariance" in cause.name or "freedom" in cause.name for cause in deviations.causes)


def test_an_innovation_that_a_silent_sensor_keeps_is_told():
    class Seldom(World):
        def measure(self, x, k, noise):
            z = super().measure(x, k, noise)
            return {"often": z, "seldom": z + noise(1)} if k % 5 == 0 else {"often": z}

    class Stale(Filter):
        def reset(self, mean, P):
            super().reset(mean, P)
            self.kept = {}, {}

        def update(self, z):
            super().update(z["often"])
            nu, S = self.kept
            nu["often"], S["often"] = self.innovation, self.S
            if "seldom" in z:
                nu["seldom"], S["seldom"] = z["seldom"] - self.state @ H.T, H @ self.covariance @ H.T + R + 1.0
            self.innovation, self.S = self.kept

    told = credence.study(Seldom(), Stale, **STUDY)
    assert any("of seldom are those of the row before to the last bit" in remark for remark in told.remarks)


def test_a_name_says_that_a_state_is_an_angle():
    by_name = credence.study(World(), Winding, names=["x", "v:angle"], runs=100, steps=10)
    by_list = credence.study(World(), Winding, names=["x", "v"], angles=["v"], runs=100, steps=10)
    assert by_name.to_dict() == by_list.to_dict()
    assert [b.name for b in by_name.blocks] == ["x", "v"]
    in_units = credence.study(
        World(), Winding, names=["x", "v:angle"], units={"x": "m", "v": "rad"}, runs=100, steps=10
    )
    assert [row["unit"] for row in in_units.to_dict()["battery"]["accuracy"]] == ["m", "rad"]
    with pytest.raises(ValueError, match="units has 3 entries: the state has 2"):
        credence.study(World(), Winding, units=["m", "m", "m"], runs=100, steps=10)


class Slow(Filter):
    def update(self, z):
        time.sleep(0.02)
        super().update(z)


def test_ctrl_c_ends_the_processes_at_once(tmp_path):
    script = tmp_path / "slow.py"
    begun = tmp_path / "begun"
    script.write_text(
        "import credence, pathlib, test_study as t\n"
        "class Told(t.Slow):\n"
        "    def update(self, z):\n"
        f"        pathlib.Path({str(begun)!r}).touch()\n"
        "        super().update(z)\n"
        "if __name__ == '__main__':\n"
        "    try: credence.study(t.World(), Told, runs=512 * 30, steps=200, workers=2)\n"
        "    except KeyboardInterrupt: print('interrupted')\n"
    )
    path = os.pathsep.join([os.path.dirname(__file__), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        [sys.executable, str(script)],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    while not begun.exists() and process.poll() is None:
        time.sleep(0.05)
    time.sleep(1.0)  # of the plug check, which comes first
    os.killpg(process.pid, signal.SIGINT)
    try:
        out = process.communicate(timeout=60.0)[0]
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert "interrupted" in out  # within the time limit above, where the study is of minutes


def test_workers_without_a_main_guard_are_told_of_it(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text("import credence, plugs\ncredence.study(plugs.World(), plugs.Filter, runs=600, steps=5, workers=2)\n")
    path = os.pathsep.join([os.path.dirname(__file__), os.environ.get("PYTHONPATH", "")])
    ended = subprocess.run(
        [sys.executable, str(script)], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120
    )
    assert ended.returncode == 1
    assert 'if __name__ == "__main__":' in ended.stderr.splitlines()[-1]
    assert ended.stderr.count("Traceback") == 1


class OneByOne(World):
    """Its z of a batch has another shape than that of one run."""

    def measure(self, x, k, noise):
        return super().measure(x, k, noise)[:, 0]


def test_runs_that_no_batch_can_be_made_of_are_told_once():
    with pytest.warns(RuntimeWarning, match="batches cannot be played, as they raise ValueError") as warned:
        told = credence.study(OneByOne(), Filter, runs=600, steps=5)
    assert len(warned) == 1 and not told.failures
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        failed = credence.study(World(), Fragile, runs=150, steps=40, seed=4)  # whose runs fail by themselves
        assert failed.failures
        credence.study(World(), Filter, batch=False, runs=20, steps=5)


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({"workers": 0}, "workers = 0: expected a whole number from 1"),
        ({"workers": -1}, "workers = -1"),
        ({"runs": 80.0}, "runs = 80.0: expected a whole number"),
        ({"steps": True}, "steps = True"),
        ({"seed": -1}, "seed = -1"),
        ({"noise": {"outlier_rate": "a"}}, "noise\\['outlier_rate'\\] = 'a': expected a number"),
        ({"noise": {"student_dof": 4.5}}, "noise\\['student_dof'\\] = 4.5: expected a whole number"),
    ],
)
def test_numbers_that_are_none_are_named(wrong, message):
    with pytest.raises(ValueError, match=message):
        credence.study(World(), Filter, **{"runs": 10, "steps": 5, **wrong})
