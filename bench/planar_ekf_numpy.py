"""EKF-SLAM in the plane as a loop of numpy, run after run: what Credence's runs per second are compared with.

A unicycle on a circle of 10 m, 10 landmarks of known association beside it, range and bearing to all within the
range; pose NEES and whole NEES at each step. `planar_ekf_numpy.py RUNS STEPS` prints runs per second of processor time.
"""

import sys
import time

import numpy as np

RADIUS, SPEED, DT, RANGE = 10.0, 1.0, 0.25, 30.0
Q = np.diag([0.1**2, 0.05**2])
R = np.diag([0.1**2, np.deg2rad(1.0) ** 2])
START_STD = np.array([0.05, 0.05, np.deg2rad(1.0)])


def wrap(angle):
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def move(pose, u):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    moved = pose + DT * np.array([u[0] * c, u[0] * s, u[1]])
    moved[2] = wrap(moved[2])
    F = np.array([[1.0, 0.0, -DT * u[0] * s], [0.0, 1.0, DT * u[0] * c], [0.0, 0.0, 1.0]])
    G = DT * np.array([[c, 0.0], [s, 0.0], [0.0, 1.0]])
    return moved, F, G


def measure(pose, landmark):
    d = landmark - pose[:2]
    q = np.hypot(*d)
    return np.array([q, wrap(np.arctan2(d[1], d[0]) - pose[2])]), d, q


def run(landmarks, steps, rng):
    """One run; returns the mean NEES over n."""
    truth = np.array([RADIUS, 0.0, np.pi / 2])
    x = truth + START_STD * rng.standard_normal(3)
    P = np.diag(START_STD**2)
    place = {}
    u = np.array([SPEED, SPEED / RADIUS])
    total = 0.0
    for _ in range(steps):
        noisy = u + np.sqrt(np.diag(Q)) * rng.standard_normal(2)
        truth, _, _ = move(truth, noisy)
        x[:3], F, G = move(x[:3], u)
        P[:3, :3] = F @ P[:3, :3] @ F.T + G @ Q @ G.T
        P[:3, 3:] = F @ P[:3, 3:]
        P[3:, :3] = P[:3, 3:].T
        seen = []
        for i, landmark in enumerate(landmarks):
            z, _, q = measure(truth, landmark)
            if q <= RANGE:
                seen.append((i, z + np.sqrt(np.diag(R)) * rng.standard_normal(2)))
        known = [(i, z) for i, z in seen if i in place]
        if known:
            H = np.zeros((2 * len(known), len(x)))
            nu = np.empty(2 * len(known))
            for r, (i, z) in enumerate(known):
                at = place[i]
                predicted, d, q = measure(x[:3], x[at : at + 2])
                own = np.array([d / q, [-d[1] / q**2, d[0] / q**2]])
                H[2 * r : 2 * r + 2, :2] = -own
                H[2 * r + 1, 2] = -1.0
                H[2 * r : 2 * r + 2, at : at + 2] = own
                nu[2 * r : 2 * r + 2] = z - predicted
                nu[2 * r + 1] = wrap(nu[2 * r + 1])
            noise = np.kron(np.eye(len(known)), R)
            S = H @ P @ H.T + noise
            K = np.linalg.solve(S, H @ P).T
            x = x + K @ nu
            x[2] = wrap(x[2])
            A = np.eye(len(x)) - K @ H
            P = A @ P @ A.T + K @ noise @ K.T
        for i, z in seen:
            if i in place:
                continue
            place[i] = n = len(x)
            b = x[2] + z[1]
            c, s = np.cos(b), np.sin(b)
            J_r = np.array([[1.0, 0.0, -z[0] * s], [0.0, 1.0, z[0] * c]])
            J_z = np.array([[c, -z[0] * s], [s, z[0] * c]])
            x = np.append(x, x[:2] + z[0] * np.array([c, s]))
            grown = np.zeros((n + 2, n + 2))
            grown[:n, :n] = P
            grown[n:, :n] = J_r @ P[:3]
            grown[:n, n:] = grown[n:, :n].T
            grown[n:, n:] = J_r @ P[:3, :3] @ J_r.T + J_z @ R @ J_z.T
            P = grown
        error = x - np.concatenate([truth] + [landmarks[i] for i in place])
        error[2] = wrap(error[2])
        total += error @ np.linalg.solve(P, error) / len(x)
    return total / steps


def main():
    runs, steps = int(sys.argv[1]), int(sys.argv[2])
    angles = 2.0 * np.pi * (np.arange(10) + 0.5) / 10.0
    radii = np.where(np.arange(10) % 2 == 0, 0.7, 1.3) * RADIUS
    landmarks = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    rng = np.random.default_rng(1)
    begin = time.process_time()
    nees = [run(landmarks, steps, rng) for _ in range(runs)]
    seconds = time.process_time() - begin
    print(f"{runs / seconds:.3g} runs of {steps} steps per second of processor time, mean NEES/n {np.mean(nees):.3f}")


main()
