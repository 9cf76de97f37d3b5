"""Right and wrong filters in numpy, written apart from the library, whose logs `credence check` judges.

usage: wrong_filters.py CREDENCE                 every case with few studies; fails where a verdict is wrong
       wrong_filters.py CREDENCE CASE STUDIES    the shares that docs/statistics.md quotes; CASE "all" for every one
"""

import collections
import sys

import numpy as np
from filter_logs import Linear, check, simulate
from linear_filters import MODELS

NAMES = {"cv4": ["x.position", "y.position", "x.velocity", "y.velocity"], "walk": ["heading"],
         "slam": ["robot.x", "first.x", "second.x"]}


def filtered(model, runs, rng, options=None, **faults):
    """The log of one of linear_filters, made with these options."""
    made = MODELS[model](**(options or {}))
    return simulate(Linear(NAMES[model], made), runs, made["steps"], rng, **faults)


def scaled(log, factors):
    """P multiplied by D P D, D = diag(√factors): a row for each step, or one for all."""
    D = np.sqrt(np.broadcast_to(factors, log.P.shape[1:3]))
    log.P = log.P * D[:, :, None] * D[:, None, :]
    return log


def plain(model, runs, factor=1.0, **options):
    """Truth = factor × claimed, in P and in S."""
    def make(rng):
        log = filtered(model, runs, rng, options)
        log.P = log.P / factor
        log.sensors = {s: (nu, S / factor) for s, (nu, S) in log.sensors.items()}
        return log
    return make


def one_state_wrong(rng):
    return scaled(plain("cv4", 50)(rng), np.array([2.0, 2 / 3, 2.0, 2 / 3]))


def pessimistic_then_optimistic(rng):
    factors = np.full((200, 4), 1 / 1.15)
    factors[:3] = 6
    return scaled(plain("cv4", 50, steps=200)(rng), factors)


def heavy_tails(runs):
    def make(rng):
        t4 = lambda shape: rng.standard_t(4, shape) / np.sqrt(2)
        return filtered("cv4", runs, rng, noise=t4)
    return make


def wrong(options=None, **faults):
    """Fifty runs of constant velocity: wrong noise, a wrong system (a biased sensor), or both, the kinds that [Yan
    2025] tells apart; or several sensors, or a gate."""
    return lambda rng: filtered("cv4", 50, rng, options, **faults)


BIAS = (0.5, 0.5)  # of every component, in its standard deviations
CASES = {
    **{f"cv4 50 x 100, factor {f:.3g}": plain("cv4", 50, f) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    **{f"walk 200 x 300, factor {f:.3g}": plain("walk", 200, f) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    **{f"cv4 10 x 1000, factor {f:.3g}": plain("cv4", 10, f, steps=1000) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    **{f"slam 50 x 100, factor {f:.3g}": plain("slam", 50, f) for f in (1, 1.05, 1.1, 1.2, 1 / 1.1)},
    "x twice too large, y 2/3": one_state_wrong,
    "six times too large in 3 steps, 15 % too small in 197": pessimistic_then_optimistic,
    "P0 x 25, Q x 0.5": wrong(P0=25.0, Q=0.5),
    "Student t4 noise, 50 runs": heavy_tails(50),
    "Student t4 noise, 200 runs": heavy_tails(200),
    "two sensors against one prior": wrong(sensors=2),
    "two sensors against one prior, Q and its truth x 10": wrong({"q": 1.0}, sensors=2),
    "a gate at 99 %": wrong(gate=9.2103),
    "Q x 0.1": wrong(Q=0.1),
    "mismatch: none": wrong(),
    "mismatch: R x 0.5": wrong(R=0.5),
    "mismatch: R x 2": wrong(R=2.0),
    "mismatch: Q x 0.2": wrong(Q=0.2),
    "mismatch: Q x 5": wrong(Q=5.0),
    "mismatch: bias 0.5 sigma": wrong(bias=BIAS),
    "mismatch: bias 0.5 sigma, R x 0.5": wrong(bias=BIAS, R=0.5),
    "mismatch: bias 0.5 sigma, R x 2": wrong(bias=BIAS, R=2.0),
    "mismatch: bias 0.5 sigma, Q x 0.2": wrong(bias=BIAS, Q=0.2),
    "mismatch: bias 0.5 sigma, Q x 5": wrong(bias=BIAS, Q=5.0),
}


def count(credence, case, studies, seed=1):
    """How often each word, each verdict on NEES, and each first cause was given; and tests that reject alone."""
    rng = np.random.default_rng([seed, *case.encode()])
    tally = collections.Counter()
    for _ in range(studies):
        document = check(credence, CASES[case](rng))
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
