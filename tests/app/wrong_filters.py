"""Right and wrong filters in numpy, written apart from the library, whose logs `credence check` judges.

usage: wrong_filters.py CREDENCE                 every case with few studies; fails where a verdict is wrong
       wrong_filters.py CREDENCE CASE STUDIES    the shares that docs/statistics.md quotes; CASE "all" for every one
"""

import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "analysis" / "laws"))
import linear_filters  # noqa: E402

NAMES = {"cv4": ["x.position", "y.position", "x.velocity", "y.velocity"], "walk": ["heading"],
         "slam": ["robot.x", "first.x", "second.x"]}


class Study:
    """Runs of one filter: arrays errors (T, M, n), covariances (T, n, n) or (T, M, n, n), and for each sensor
    innovations (T, M, m), NaN where it was silent, with their covariances (T, m, m) or (T, M, m, m)."""

    def __init__(self, names, errors, P, innovations):
        self.names, self.errors, self.P, self.innovations = names, errors, P, innovations

    def write(self, path):
        steps, runs, n = self.errors.shape
        upper = np.triu_indices(n)
        head = ["run", "step"] + [f"estimate.{s}" for s in self.names] + [f"truth.{s}" for s in self.names]
        head += [f"P.{i + 1}.{j + 1}" for i, j in zip(*upper)]
        for sensor, (nu, _) in self.innovations.items():
            of = f"{sensor}." if sensor else ""
            m = nu.shape[2]
            head += [f"innovation.{of}{i + 1}" for i in range(m)]
            head += [f"S.{of}{i + 1}.{j + 1}" for i, j in zip(*np.triu_indices(m))]
        text = lambda values: ",".join("" if np.isnan(v) else repr(float(v)) for v in values)
        zeros = ",".join(["0"] * n)
        P = matrix_texts(self.P, text)
        S = {s: matrix_texts(covs, text) for s, (_, covs) in self.innovations.items()}
        with open(path, "w") as log:
            log.write(",".join(head) + "\n")
            for run in range(runs):
                for k in range(steps):
                    row = f"{run},{k + 1},{text(self.errors[k, run])},{zeros},{P[k][run % len(P[k])]}"
                    for sensor, (nu, _) in self.innovations.items():
                        silent = np.isnan(nu[k, run]).any()
                        of_step = S[sensor][k]
                        cov = of_step[run % len(of_step)]
                        row += f",{text(nu[k, run])},{',' * cov.count(',') if silent else cov}"
                    log.write(row + "\n")


def matrix_texts(matrices, text):
    """The upper triangles of each step: one for all runs, or one for each."""
    upper = np.triu_indices(matrices.shape[-1])
    per_step = matrices[:, None] if matrices.ndim == 3 else matrices
    return [[text(m[upper]) for m in step] for step in per_step]


def simulate(model, names, runs, rng, believed=None, noise=None, sensors=1, gate=np.inf, bias=0.0):
    """The filter assumes `believed` (keys of the model), and measures with `sensors` copies of H one after the other,
    whose innovations are all written against the prior. An innovation with NIS beyond `gate` is not used. `bias`: of
    every measurement, in its standard deviations."""
    truth, filter_ = model, {**model, **(believed or {})}
    F, H, n = truth["F"], truth["H"], len(truth["F"])
    m, steps = len(H), truth["steps"]
    draw = noise or rng.standard_normal
    e = rng.standard_normal((runs, n)) @ linear_filters.root(truth["P0"]).T
    P = np.broadcast_to(filter_["P0"], (runs, n, n)) if np.isfinite(gate) else filter_["P0"]
    errors, covs, nus, Ss = [], [], [[] for _ in range(sensors)], []
    for _ in range(steps):
        P = F @ P @ F.T + filter_["Q"]
        e = e @ F.T + rng.standard_normal((runs, n)) @ linear_filters.root(truth["Q"]).T
        prior = e
        for s in range(sensors):
            S = H @ P @ H.T + filter_["R"]
            if s == 0:
                Ss.append(S)
            K = P @ H.T @ np.linalg.inv(S)
            w = (draw((runs, m)) + bias) @ linear_filters.root(truth["R"]).T
            nu = -(e @ H.T) + w
            nus[s].append(-(prior @ H.T) + w)
            used = np.ones(runs, bool)
            if np.isfinite(gate):
                used = np.einsum("ri,rij,rj->r", nu, np.linalg.inv(S), nu) <= gate
                nus[s][-1] = np.where(used[:, None], nu, np.nan)
                K = np.where(used[:, None, None], K, 0.0)
                e = e + np.einsum("rij,rj->ri", K, nu)
            else:
                e = e + nu @ K.T
            IKH = np.eye(n) - K @ H
            P = IKH @ P @ np.swapaxes(IKH, -1, -2) + K @ filter_["R"] @ np.swapaxes(K, -1, -2)
        errors.append(e)
        covs.append(P)
    names_of = [""] if sensors == 1 else [f"sensor{s + 1}" for s in range(sensors)]
    innovations = {name: (np.stack(nus[s]), np.stack(Ss)) for s, name in enumerate(names_of)}
    return Study(names, np.stack(errors), np.stack(covs), innovations)


def scaled(study, factors):
    """P multiplied by D P D, D = diag(√factors): a row for each step, or one for all."""
    D = np.sqrt(np.broadcast_to(factors, (len(study.P), study.P.shape[1])))
    study.P = study.P * D[:, :, None] * D[:, None, :]
    return study


def plain(model, runs, factor=1.0, **options):
    """Truth = factor × claimed, in P and in S."""
    def make(rng):
        study = simulate(linear_filters.MODELS[model](**options), NAMES[model], runs, rng)
        study.P = study.P / factor
        study.innovations = {s: (nu, S / factor) for s, (nu, S) in study.innovations.items()}
        return study
    return make


def one_state_wrong(rng):
    return scaled(plain("cv4", 50)(rng), np.array([2.0, 2 / 3, 2.0, 2 / 3]))


def pessimistic_then_optimistic(rng):
    factors = np.full((200, 4), 1 / 1.15)
    factors[:3] = 6
    return scaled(plain("cv4", 50, steps=200)(rng), factors)


def wrong_start_and_noise(rng):
    model = linear_filters.constant_velocity()
    return simulate(model, NAMES["cv4"], 50, rng, {"P0": 25 * model["P0"], "Q": 0.5 * model["Q"]})


def heavy_tails(runs):
    def make(rng):
        t4 = lambda shape: rng.standard_t(4, shape) / np.sqrt(2)
        return simulate(linear_filters.constant_velocity(), NAMES["cv4"], runs, rng, noise=t4)
    return make


def two_sensors(q):
    def make(rng):
        return simulate(linear_filters.constant_velocity(q=q), NAMES["cv4"], 50, rng, sensors=2)
    return make


def process_noise(scale):
    def make(rng):
        model = linear_filters.constant_velocity()
        return simulate(model, NAMES["cv4"], 50, rng, {"Q": scale * model["Q"]})
    return make


def mismatch(bias=0.0, **scales):
    """Wrong noise, a wrong system (a biased sensor), or both: the kinds that [Yan 2025] tells apart."""
    def make(rng):
        model = linear_filters.constant_velocity()
        believed = {key: scale * model[key] for key, scale in scales.items()}
        return simulate(model, NAMES["cv4"], 50, rng, believed, bias=bias)
    return make


CASES = {
    **{f"cv4 50 x 100, factor {f:.3g}": plain("cv4", 50, f) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    **{f"walk 200 x 300, factor {f:.3g}": plain("walk", 200, f) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    **{f"cv4 10 x 1000, factor {f:.3g}": plain("cv4", 10, f, steps=1000) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    **{f"slam 50 x 100, factor {f:.3g}": plain("slam", 50, f) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    "x twice too large, y 2/3": one_state_wrong,
    "six times too large in 3 steps, 15 % too small in 197": pessimistic_then_optimistic,
    "P0 x 25, Q x 0.5": wrong_start_and_noise,
    "Student t4 noise, 50 runs": heavy_tails(50),
    "Student t4 noise, 200 runs": heavy_tails(200),
    "two sensors against one prior": two_sensors(0.1),
    "two sensors against one prior, Q and its truth x 10": two_sensors(1.0),
    "a gate at 99 %": lambda rng: simulate(linear_filters.constant_velocity(), NAMES["cv4"], 50, rng, gate=9.2103),
    "Q x 0.1": process_noise(0.1),
    "mismatch: none": mismatch(),
    "mismatch: R x 0.5": mismatch(R=0.5),
    "mismatch: R x 2": mismatch(R=2.0),
    "mismatch: Q x 0.2": mismatch(Q=0.2),
    "mismatch: Q x 5": mismatch(Q=5.0),
    "mismatch: bias 0.5 sigma": mismatch(0.5),
    "mismatch: bias 0.5 sigma, R x 0.5": mismatch(0.5, R=0.5),
    "mismatch: bias 0.5 sigma, R x 2": mismatch(0.5, R=2.0),
    "mismatch: bias 0.5 sigma, Q x 0.2": mismatch(0.5, Q=0.2),
    "mismatch: bias 0.5 sigma, Q x 5": mismatch(0.5, Q=5.0),
}


def judge(credence, study, folder):
    log = folder / "log.csv"
    study.write(log)
    out = subprocess.run([credence, "check", log, "--format", "json", "--quiet"], capture_output=True, text=True)
    if out.returncode != 0:
        raise SystemExit(f"credence check failed:\n{out.stderr}")
    return json.loads(out.stdout)


def count(credence, case, studies, seed=1):
    """How often each word, each verdict on NEES, and each first cause was given; and tests that reject alone."""
    rng = np.random.default_rng([seed, *case.encode()])
    tally = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(studies):
            document = judge(credence, CASES[case](rng), pathlib.Path(folder))
            tally["word", document["verdict"]] += 1
            tally["NEES", document["nees"]["verdict"]] += 1
            causes = document["battery"]["causes"]
            tally["cause", "; ".join(c["cause"] for c in causes) or "-"] += 1
            for test in document["battery"]["tests"]:
                tally["alone", test["name"]] += test["p_value"] is not None and test["p_value"] <= 0.05
    return tally


EXPECTED = {  # in ten studies: the words that are right, and the least number of them
    "cv4 50 x 100, factor 1": ({"consistent"}, 8),
    "cv4 50 x 100, factor 1.1": ({"optimistic"}, 9),
    "cv4 50 x 100, factor 0.909": ({"pessimistic"}, 9),
    "x twice too large, y 2/3": ({"mixed"}, 9),
    "six times too large in 3 steps, 15 % too small in 197": ({"mixed"}, 9),
    "Student t4 noise, 200 runs": ({"not Gaussian", "consistent"}, 8),
    "two sensors against one prior": ({"consistent"}, 8),
}

EXPECTED_CAUSES = {  # in ten studies: words of the causes that must be named, all of them, in at least nine
    "mismatch: R x 0.5": ["measurement noise R assumed too small"],
    "mismatch: Q x 5": ["process noise Q assumed too large"],
    "mismatch: bias 0.5 sigma": ["a bias"],
    "mismatch: bias 0.5 sigma, R x 0.5": ["a bias", "measurement noise R assumed too small"],
    "mismatch: bias 0.5 sigma, Q x 5": ["a bias", "process noise Q assumed too large"],
}


def main(credence, case=None, studies="10"):
    failed = False
    cases = [*EXPECTED, *EXPECTED_CAUSES] if case is None else [c for c in CASES if case in ("all", c)]
    if not cases:
        raise SystemExit("no such case; one of: " + "; ".join(CASES))
    for name in cases:
        tally = count(credence, name, int(studies))
        print(name, flush=True)
        for kind in ("word", "NEES", "cause", "alone"):
            line = {key[1]: n for key, n in tally.most_common() if key[0] == kind and n > 0}
            if case is not None or kind == "word":
                print(f"  {kind}: {line}", flush=True)
        if case is None and name in EXPECTED_CAUSES:
            named = sum(n for (kind, text), n in tally.items()
                        if kind == "cause" and all(cause in text for cause in EXPECTED_CAUSES[name]))
            if named < 9:
                print(f"  named in {named} of {studies}: {EXPECTED_CAUSES[name]}")
                failed = True
        elif case is None:
            words, least = EXPECTED[name]
            if sum(tally["word", word] for word in words) < least:
                print(f"  expected: {' or '.join(sorted(words))}, at least {least} of {studies}")
                failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) in (2, 4) else __doc__)
