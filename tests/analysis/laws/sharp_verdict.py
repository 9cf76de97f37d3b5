"""Levels and powers of the laws over runs, by simulation apart from the library. docs/statistics.md quotes it.

usage: sharp_verdict.py levels | power | betting | shape | tails [STUDIES]
       sharp_verdict.py golden        the numbers that the C++ tests expect
"""

import sys

import numpy as np
from scipy import special, stats

import linear_filters
import reference_laws as laws

LAWS = {  # X = Σ λ_j χ²₁: the λ_j, and a constant rest
    "chi2_1": [1.0], "chi2_2/2": [0.5] * 2, "chi2_4/4": [0.25] * 4, "chi2_20/20": [0.05] * 20,
    "0.5^j": 0.5 ** np.arange(1, 40), "0.9^j": 0.9 ** np.arange(60) / 10, "1/j^2": 6 / np.pi**2 / np.arange(1, 100.0) ** 2,
    "0.1 chi2_1 + 0.9": [0.1], "0.33 chi2_1 + 0.67": [0.33], "0.67 chi2_1 + 0.33": [0.67],
    "0.33 chi2_3/3 + 0.67": [0.11] * 3, "0.5 chi2_2/2 + 0.5": [0.25] * 2,
}
STAYING = {  # one error that stays among many that do not
    f"{share} chi2_1 + {1 - share} chi2_{rest}/{rest}": [share] + [(1 - share) / rest] * rest
    for share in (0.05, 0.1, 0.2, 0.4) for rest in (200, 2000)
}


def draw(weights, shape, rng):
    weights = np.asarray(weights)
    values, counts = np.unique(weights, return_counts=True)
    X = np.full(shape, 1 - weights.sum())
    for value, count in zip(values, counts):
        X += value * rng.chisquare(count, shape)
    return X


def levels(studies, rng):
    print("% rejected at 2.5 % a side: cube root, Hall, both (20 runs and more), bound (fewer): optimistic pessimistic")
    for M in (2, 5, 10, 20, 50, 200, 1000):
        t = stats.t.ppf(0.975, M - 1)
        bound = stats.chi2.cdf(stats.chi2.ppf(0.025, M), M + 2) / 0.025
        rows = []
        for name, weights in (LAWS | STAYING).items():
            X = draw(weights, (studies if M < 1000 else studies // 4, M), rng)
            z, h = laws.cube_root_score(X), laws.hall_score(X)
            up, down = (p <= 0.025 for p in laws.run_mean_p(X))
            rows.append([np.mean(z > t), np.mean(z < -t), np.mean(h > t), np.mean(h < -t), np.mean(up), np.mean(down),
                         np.mean(up | down), np.mean(X.mean(1) <= bound)])
            print(f"M {M:4} {name:22}", np.round(100 * np.array(rows[-1]), 1))
        for some in (rows[:len(LAWS)], rows[len(LAWS):]):
            print(f"M {M:4} least {np.round(100 * np.min(some, 0), 1)} largest {np.round(100 * np.max(some, 0), 1)}")


def study_sums(model, studies, runs, rng):
    """Run averages (studies × runs) and sums over the runs of each step (studies × steps)."""
    total, steps = 0, []
    for u in linear_filters.simulate(model, studies * runs, rng):
        nees = (u**2).sum(1).reshape(studies, runs)
        total = total + nees
        steps.append(nees.sum(1))
    return total / (model["steps"] * len(model["F"])), np.stack(steps, 1)


def power(studies, rng):
    print("% of studies: run mean alone at 5 % | run mean and steps, each at 2.5 %")
    for name, runs in (("cv4", 50), ("cv4", 200), ("walk", 50), ("walk", 200), ("slam", 50), ("slam", 200)):
        model = linear_filters.MODELS[name]()
        X, sums = study_sums(model, studies, runs, rng)
        dof = runs * len(model["F"])
        for factor in (1, 1.05, 1.1, 1.2, 1 / 1.05, 1 / 1.1, 1 / 1.2):
            p = 2 * np.minimum(*laws.run_mean_p(factor * X))
            joint = np.minimum(p, laws.steps_p(factor * sums, dof))
            print(f"{name:5} M {runs:4} factor {factor:.3f}: {100 * np.mean(p <= 0.05):5.1f} | "
                  f"{100 * np.mean(joint <= 0.025):5.1f}")


def betting(studies, rng):
    print("bar ln 40 on ½ (W⁺ + W⁻): % of studies within 200 runs, median runs to stop (of 600)")
    for name, make in linear_filters.MODELS.items():
        model = make()
        X = linear_filters.run_averages(model, studies * 600, rng).reshape(studies, 600)
        for factor in (1, 1.05, 1.1, 1.2, 1.5, 1 / 1.05, 1 / 1.1, 1 / 1.2, 1 / 1.5):
            up, down = laws.log_betting(factor * X, len(model["F"]))
            stopped = np.logaddexp(up, down) - np.log(2) >= np.log(40)
            first = np.where(stopped.any(1), stopped.argmax(1) + 1, np.inf)
            print(f"{name:5} factor {factor:.3f}: {100 * np.mean(first <= 200):5.1f} %, median {np.median(first):g}")


def shape(studies, rng):
    print("% rejected at 5 % and 1 %: likelihood ratio as type III law of three cumulants | Bartlett's factor | plain χ²")
    for n in (1, 2, 4, 8, 12):
        for M in (n + 1, 2 * n, 5 * n, 20 * n):
            A = np.zeros((studies, n, n))  # Bartlett decomposition of a Wishart matrix
            for i in range(n):
                A[:, i, i] = np.sqrt(rng.chisquare(M - i, studies))
                A[:, i, :i] = rng.standard_normal((studies, i))
            w = np.linalg.eigvalsh(A @ A.transpose(0, 2, 1) / M)
            ratio = M * (w - np.log(w) - 1).sum(1)
            h, dof = (M - np.arange(n)) / 2, n * (n + 1) / 2
            k1 = -M * (special.digamma(h).sum() + n * np.log(2 / M))
            k2 = M**2 * special.polygamma(1, h).sum() - 2 * n * M
            k3 = -(M**3) * special.polygamma(2, h).sum() - 4 * n * M
            nu = 8 * k2**3 / k3**2
            p3 = stats.chi2.sf(nu + (ratio - k1) * np.sqrt(2 * nu / k2), nu)
            others = stats.chi2.sf(ratio * dof / k1, dof), stats.chi2.sf(ratio, dof)
            print(f"n {n:2} M {M:3}:", *(f"{100 * np.mean(p <= 0.05):.2f} {100 * np.mean(p <= 0.01):.2f} |" for p in (p3, *others)))


def tails(studies, rng):
    print("% of studies at 2.5 %: heavy tails | run mean optimistic, pessimistic; right covariance, law of measurement noise")
    noises = {"gauss": None, "t4": lambda shape: rng.standard_t(4, shape) / np.sqrt(2),
              "laplace": lambda shape: rng.laplace(size=shape) / np.sqrt(2)}
    for name, make in linear_filters.MODELS.items():
        model, n = make(), len(make()["F"])
        for law, M in (("gauss", 20), ("gauss", 50), ("gauss", 200), ("t4", 50), ("laplace", 50)):
            X = K = 0
            for u in linear_filters.simulate(model, studies * M, rng, noises[law]):
                nees = (u**2).sum(1).reshape(studies, M)
                X, K = X + nees / (n * model["steps"]), K + nees**2 / (n * (n + 2) * model["steps"])
            heavy = np.mean(stats.t.sf(laws.hall_score(K - 2 * X + 2), M - 1) <= 0.025)
            sides = [np.mean(p <= 0.025) for p in laws.run_mean_p(X)]
            print(f"{name:5} {law:8} M {M:3}: {100 * heavy:5.1f} |", *np.round(100 * np.array(sides), 1))


def golden(_, rng):
    X = np.round(linear_filters.run_averages(linear_filters.monobot(), 24, rng), 3)
    print("X", ", ".join(map(str, X)))
    print("24 runs: mean, variance, skewness", *laws.sample(X))
    print("p optimistic, pessimistic of mean 1, of mean 1.5:", *laws.run_mean_p(X), *laws.run_mean_p(X, 1.5))
    less = np.where(X > 6, 1.3, X)
    print("the largest 1.3: p optimistic of mean 1, pessimistic of 1.1 and 1.8:", laws.run_mean_p(less)[0],
          *(laws.run_mean_p(less, mu)[1] for mu in (1.1, 1.8)))
    few = stats.t.sf(laws.cube_root_score(X[:8], 1.5), 7), laws.lower_bound_p(X[:8].mean() / 1.5, 24)
    print("first 8 runs, mean 1.5, n = 3:", *few)
    up, down = laws.log_betting(X, 3)
    print("ln W+, ln W- after 8 and 24 runs, n = 3:", up[7], down[7], up[23], down[23])


if __name__ == "__main__":
    what, studies = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    {"levels": levels, "power": power, "betting": betting, "shape": shape, "tails": tails, "golden": golden}[what](studies, np.random.default_rng(2026))
