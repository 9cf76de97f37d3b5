"""The laws of analysis/laws for run averages in numpy and scipy, from their equations: an independent reference."""

import numpy as np
from scipy import optimize, special, stats


def sample(X):
    """Mean, unbiased variance and skewness over the last axis."""
    m = X.mean(-1)
    d = X - m[..., None]
    m2 = (d**2).mean(-1)
    return m, m2 * X.shape[-1] / (X.shape[-1] - 1), (d**3).mean(-1) / m2**1.5


def sample_skewness(X):
    return sample(X)[2]


def cube_root_score(X, mu=1.0):
    M = X.shape[-1]
    m, v, _ = sample(X)
    c = 2 / 9 / np.maximum(1e-3, 2 * M * (m * m / v - 1 / M))
    return (np.cbrt(m / mu) - (1 - c)) / np.sqrt(c)


def cautious_skewness(X):
    """That of the sample and what it may lack in few runs, at most that of χ²₁."""
    M, g = X.shape[-1], sample(X)[2]
    return np.maximum(g, np.minimum(np.sqrt(8), g + (20 * g + 8) / M))


def hall_score(X, mu=1.0, skewness=sample_skewness):
    M = X.shape[-1]
    m, v, _ = sample(X)
    g = skewness(X)
    U = (m - mu) / np.sqrt(v)
    return np.sqrt(M) * (U + g * U**2 / 3 + g**2 * U**3 / 27 + g / (6 * M))


def lower_bound_p(mean, dof):
    """The p at which E[Y | Y in its lower tail p] = mean, Y ~ χ²(dof)/dof."""

    def excess(log_p):
        q = stats.chi2.ppf(np.exp(log_p), dof)
        return stats.chi2.cdf(q, dof + 2) / np.exp(log_p) - mean

    return 1.0 if mean >= 1 else np.exp(optimize.brentq(excess, np.log(1e-200), 0))


def run_mean_p(X, mu=1.0):
    """One-sided p-values (optimistic, pessimistic), for 20 runs or more."""
    t, far = stats.t(X.shape[-1] - 1), stats.t((X.shape[-1] - 1) / 3)
    z = cube_root_score(X, mu)
    low, high = np.minimum(z, hall_score(X, mu)), np.maximum(z, hall_score(X, mu, cautious_skewness))
    return t.sf(low), np.maximum(t.cdf(high), far.cdf(high) / 2)


def put_price(b, n):
    return b - 1 + stats.chi2.sf(n * b, n + 2) - b * stats.chi2.sf(n * b, n)


def log_betting(X, n, plus=(0.1, 0.25, 0.5, 0.99), strikes=(1.5, 2, 4), minus=(0.3, 0.9)):
    """ln W⁺ and ln W⁻ after each run (last axis)."""
    up = [np.cumsum(np.log1p(s * (X - 1)), -1) for s in plus]
    down = [np.cumsum(np.log1p(s * (np.maximum(b - X, 0) / put_price(b, n) - 1)), -1) for b in strikes for s in minus]
    return [special.logsumexp(w, axis=0) - np.log(len(w)) for w in (np.stack(up), np.stack(down))]


def steps_p(sums, dof):
    """Adjusted p-value of the worst step; sums: … × steps, each χ²(dof)."""
    p = 2 * np.minimum(stats.chi2.cdf(sums, dof), stats.chi2.sf(sums, dof))
    return np.minimum(1, p.min(-1) * sums.shape[-1])
