"""Three linear-Gaussian filters in numpy, written apart from the library: what its laws are checked against.

simulate(model, runs, rng) gives the whitened errors of each step. A claimed covariance that is wrong by a factor
multiplies NEES by it, so one simulation serves all factors.
"""

import numpy as np


def constant_velocity(steps=100, dt=1.0, q=0.1, r=1.0):
    """Plane, state (x, y, vx, vy), position measured."""
    F = np.eye(4)
    F[0, 2] = F[1, 3] = dt
    g = np.array([[dt**2 / 2, 0], [0, dt**2 / 2], [dt, 0], [0, dt]])
    return dict(F=F, Q=q * g @ g.T, H=np.eye(2, 4), R=r * np.eye(2), P0=np.eye(4), steps=steps)


def walk(steps=300, q=0.0025, r=1.0):
    """A scalar random walk in its steady state: correlated over some twenty steps."""
    prior = (q + np.sqrt(q * q + 4 * q * r)) / 2
    return dict(F=np.eye(1), Q=q * np.eye(1), H=np.eye(1), R=r * np.eye(1),
                P0=np.array([[prior * r / (prior + r)]]), steps=steps)


def monobot(steps=100, landmarks=2, q=0.1, r=0.1):
    """SLAM on a line, partially observable: part of the error of a run never changes."""
    n = landmarks + 1
    H = np.hstack([-np.ones((landmarks, 1)), np.eye(landmarks)])
    Q = np.zeros((n, n))
    Q[0, 0] = q
    return dict(F=np.eye(n), Q=Q, H=H, R=r * np.eye(landmarks), P0=np.eye(n), steps=steps)


MODELS = {"cv4": constant_velocity, "walk": walk, "slam": monobot}


def root(P):
    w, v = np.linalg.eigh(P)
    return v * np.sqrt(np.maximum(w, 0))


def simulate(model, runs, rng, noise=None):
    """Yields, for each step, the errors whitened by the posterior covariance, an array runs × n. noise(shape) draws
    the measurement noise, of unit variance; None is Gaussian."""
    F, Q, H, R, P = (model[k] for k in ("F", "Q", "H", "R", "P0"))
    n, m = len(F), len(H)
    e = rng.standard_normal((runs, n)) @ root(P).T
    for _ in range(model["steps"]):
        P = F @ P @ F.T + Q
        e = e @ F.T + rng.standard_normal((runs, n)) @ root(Q).T
        S = H @ P @ H.T + R
        K = np.linalg.solve(S, H @ P).T
        w = (rng.standard_normal((runs, m)) if noise is None else noise((runs, m))) @ root(R).T
        e = e - (e @ H.T + w) @ K.T
        IKH = np.eye(n) - K @ H
        P = IKH @ P @ IKH.T + K @ R @ K.T
        yield np.linalg.solve(np.linalg.cholesky(P), e.T).T


def run_averages(model, runs, rng, noise=None):
    """X_i = Σ_k ε_ik / Σ_k n, one for each run."""
    total = np.zeros(runs)
    for u in simulate(model, runs, rng, noise):
        total += (u**2).sum(1)
    return total / (model["steps"] * len(model["F"]))
