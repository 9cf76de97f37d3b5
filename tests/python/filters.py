"""Kalman filters over batches of runs, right and wrong."""

import numpy as np

F = np.array([[1.0, 0.5], [0.0, 1.0]])
H = np.array([[1.0, 0.0]])
Q = np.diag([0.01, 0.04])
R = np.array([[0.25]])
P0 = np.diag([1.0, 0.5])


def play(runs=200, steps=40, seed=1, believed_Q=Q, believed_R=R):
    """error (runs, steps, 2), P (runs, steps, 2, 2), innovation (runs, steps, 1), S (runs, steps, 1, 1)."""
    rng = np.random.default_rng(seed)
    error = np.empty((runs, steps, 2))
    P = np.empty((runs, steps, 2, 2))
    nu = np.empty((runs, steps, 1))
    S = np.empty((runs, steps, 1, 1))
    e = rng.standard_normal((runs, 2)) @ np.sqrt(P0)
    covariance = P0
    for k in range(steps):
        e = e @ F.T - rng.standard_normal((runs, 2)) @ np.sqrt(Q)
        covariance = F @ covariance @ F.T + believed_Q
        innovation = -e @ H.T + rng.standard_normal((runs, 1)) @ np.sqrt(R)
        s = H @ covariance @ H.T + believed_R
        K = covariance @ H.T / s
        e = e + innovation @ K.T
        covariance = covariance - K @ s @ K.T
        covariance = 0.5 * (covariance + covariance.T)
        error[:, k], P[:, k], nu[:, k], S[:, k] = e, covariance, innovation, s
    return error, P, nu, S
