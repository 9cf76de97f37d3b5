"""Extended Kalman filters in numpy that take several sensors at a step, rightly or not, and the causes that `credence
check` names for their logs.

usage: wrong_sensors.py CREDENCE STUDIES [SEED [WORLD ...]]

Writes what docs/statistics.md sums up under "Several sensors": of each fault and world how often which cause came first.
Fails where more than one in ten filters that take their sensors in turn is told to take them against one prior, or more
than one in ten that do so is not, in the worlds where it matters.
"""

import collections
import sys

import numpy as np
from filter_logs import Log, World, check, derivative, root, turned

RUNS, STEPS = 30, 80


class Sensor:
    """z = h(x) + w, every so many steps, with the places of its angles."""

    def __init__(self, h, R, angles=(), period=1):
        self.h = h if callable(h) else lambda x: x @ np.atleast_2d(np.array(h, float)).T
        self.R, self.angles, self.period = np.atleast_2d(R).astype(float), angles, period

    def H(self, x):
        return derivative(self.h, x, self.angles)


class Plane(World):
    """Constant velocity in the plane, two sensors of the position. Linear."""

    names, nonlinear = ["x", "y", "vx", "vy"], False
    mean, P0 = np.zeros(4), np.diag([1, 1, 0.25, 0.25])
    Q = 0.05 * np.kron([[0.25, 0.5], [0.5, 1]], np.eye(2))
    sensors = {"rough": Sensor(np.eye(2, 4), 2 * np.eye(2)), "fine": Sensor(np.eye(2, 4), np.eye(2))}

    def f(self, x, k):
        return np.concatenate([x[:, :2] + x[:, 2:], x[:, 2:]], 1)


class Tanks(World):
    """The levels of three tanks, by a float, a fine gauge of two of them, and a sonar every other step. Linear."""

    names, nonlinear = ["first", "second", "third"], False
    mean, P0, Q = np.array([1.0, 0.8, 0.5]), 0.1 * np.eye(3), np.diag([0.004, 0.001, 0.002])
    sensors = {"float": Sensor([[1, 0, 0]], 0.05), "gauge": Sensor([[1, 1, 0]], 0.002),
               "sonar": Sensor([[0, 0.5, 1]], 0.02, period=2)}

    def f(self, x, k):
        return x @ np.array([[0.93, 0.05, 0], [0.05, 0.9, 0.05], [0, 0.05, 0.92]]).T + 0.02


class Clock(World):
    """Phase and frequency, the phase by five sensors of other rates. Linear."""

    names, nonlinear = ["phase", "frequency"], False
    mean, P0, Q = np.zeros(2), np.diag([1, 0.01]), np.diag([0.01, 1e-4])
    sensors = {f"s{i}": Sensor([[1, 0]], R, period=period)
               for i, (R, period) in enumerate([(1, 1), (0.5, 1), (0.2, 2), (2, 3), (0.05, 4)])}

    def f(self, x, k):
        return x @ np.array([[1, 1], [0, 1.0]]).T


class Space(World):
    """Position, velocity and acceleration in space, by two trackers of which the other is turned and finer. Linear."""

    names, nonlinear = [f"{block}.{axis}" for block in ("p", "v", "a") for axis in "xyz"], False
    mean, P0 = np.zeros(9), np.kron(np.diag([4, 1, 0.1]), np.eye(3))
    Q = 0.02 * np.kron(np.outer([0.1, 0.5, 1], [0.1, 0.5, 1]), np.eye(3))
    sensors = {"left": Sensor(np.eye(3, 9), np.diag([4, 4, 9.0])),
               "right": Sensor(np.hstack([[[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]], np.zeros((3, 6))]),
                               np.diag([0.3, 0.3, 0.5]))}

    def f(self, x, k):
        return x @ np.kron([[1, 1, 0.4], [0, 1, 0.8], [0, 0, 0.7]], np.eye(3)).T


class Car(World):
    """Position, heading, speed and rate of turn, by wheels, a gyro, a GPS and a compass of other rates."""

    names, angles = ["x", "y", "heading:angle", "speed", "turn"], (2,)
    mean, P0 = np.array([0, 0, 0.5, 4, 0.05]), np.diag([1, 1, 0.02, 0.1, 0.001])
    Q = np.diag([0.02, 4e-4])
    sensors = {"wheels": Sensor(lambda x: x[:, 3:4], 0.04), "gyro": Sensor(lambda x: x[:, 4:], 4e-4),
               "gps": Sensor(lambda x: x[:, :2], 2 * np.eye(2), period=4),
               "compass": Sensor(lambda x: x[:, 2:3], 0.01, angles=(0,), period=2)}

    def f(self, x, k):
        a, d = x[:, 2] + 0.1 * x[:, 4], 0.2 * x[:, 3]
        moved = [x[:, 0] + d * np.cos(a), x[:, 1] + d * np.sin(a), x[:, 2] + 0.2 * x[:, 4]]
        return np.stack([*moved, x[:, 3], x[:, 4]], 1)

    def G(self, x):
        return np.broadcast_to(np.eye(5)[:, 3:], (len(x), 5, 2))


WORLDS = {world.__name__.lower(): world for world in (Plane, Tanks, Clock, Space, Car)}
ONE_PRIOR = "innovations of several sensors"
FAULTS = {
    "nothing": {},
    "Q × 0.2": {"Q": 0.2},
    "Q × 5": {"Q": 5.0},
    "R × 0.25": {"R": 0.25},
    "R × 4": {"R": 4.0},
    "P0 × 0.1": {"P0": 0.1},
    "a bias of 0.7 σ of the first sensor": {"bias": 0.7},
    "1 % of outliers, 12 times as large": {"outliers": 0.01},
    "noise of which sensors share half": {"shared": 0.5},
    "ν and S of the prior in the log alone": {"mode": "log"},
    "ν of the prior, K and S of the updated P": {"mode": "stale"},
    "ν, K and S of the prior, P updated in turn": {"mode": "parallel"},
    "two estimates of one prior, fused as if independent": {"mode": "fused"},
}
CLEAR = ("plane", "tanks", "clock", "space")  # where sensors of one prior share much of it


def times(A, x):
    return np.einsum("rij,rj->ri", A, x)


def updated(P, K, H, R):
    A = np.eye(P.shape[-1]) - K @ H
    P = A @ P @ A.swapaxes(1, 2) + K @ R @ K.swapaxes(1, 2)
    return 0.5 * (P + P.swapaxes(1, 2))


def played(world, rng, mode="in turn", Q=1.0, R=1.0, P0=1.0, bias=0.0, outliers=0.0, shared=0.0):
    """The log of a filter whose Q, R and P0 are the true ones times these."""
    n, angles = len(world.mean), world.angles
    truth = world.mean + rng.standard_normal((RUNS, n)) @ root(world.P0).T
    x, P = np.tile(world.mean, (RUNS, 1)), np.tile(P0 * world.P0, (RUNS, 1, 1))
    rows = []
    for k in range(STEPS):
        v = rng.standard_normal((RUNS, len(world.Q))) @ root(world.Q).T
        truth = turned(angles, world.f(truth, k) + times(world.G(truth), v))
        F, G = world.F(x, k), world.G(x)
        x = turned(angles, world.f(x, k))
        P = F @ P @ F.swapaxes(1, 2) + G @ (Q * world.Q) @ G.swapaxes(1, 2)
        prior, prior_P, estimates, innovations = x, P, [], []
        common = rng.standard_normal((RUNS, 1))
        for i, sensor in enumerate(world.sensors.values()):
            m = len(sensor.R)
            if k % sensor.period:
                innovations += [np.full((RUNS, m), np.nan), np.tile(np.eye(m), (RUNS, 1, 1))]
                continue
            w = np.sqrt(1 - shared) * rng.standard_normal((RUNS, m)) + np.sqrt(shared) * common
            if outliers:
                w = w * np.where(rng.random((RUNS, 1)) < outliers, 12.0, 1.0)
            w[:, 0] += bias * (i == 0)
            z, assumed = turned(sensor.angles, sensor.h(truth) + w @ root(sensor.R).T), R * sensor.R

            def update(x, P):
                H = sensor.H(x)
                S = H @ P @ H.swapaxes(1, 2) + assumed
                return turned(sensor.angles, z - sensor.h(x)), 0.5 * (S + S.swapaxes(1, 2)), H

            (nu, S, H), (nu_prior, S_prior, H_prior) = update(x, P), update(prior, prior_P)
            K = np.linalg.solve(S, H @ P).swapaxes(1, 2)
            K_prior = np.linalg.solve(S_prior, H_prior @ prior_P).swapaxes(1, 2)
            innovations += [nu if mode == "in turn" else nu_prior, S if mode in ("in turn", "stale") else S_prior]
            if mode == "fused":
                estimates.append((x + times(K_prior, nu_prior), updated(prior_P, K_prior, H_prior, assumed)))
            elif mode == "parallel":
                x, P = turned(angles, x + times(K_prior, nu_prior)), updated(P, K_prior, H_prior, assumed)
            else:
                x = turned(angles, x + times(K, nu_prior if mode == "stale" else nu))
                P = updated(P, K, H, assumed)
        if estimates:
            information = [np.linalg.inv(of) for _, of in estimates]
            P = np.linalg.inv(sum(information))
            first = estimates[0][0]
            away = sum(times(J, turned(angles, y - first)) for J, (y, _) in zip(information, estimates))
            x = turned(angles, first + times(P, away))
        rows.append([x, truth, P, *innovations])
    estimate, truth, P, *innovations = (np.stack(column, 1) for column in zip(*rows))
    return Log(world, estimate, truth, P, dict(zip(world.sensors, zip(innovations[::2], innovations[1::2]))))


def main(credence, studies, seed="1", *worlds):
    worlds, failed = worlds or tuple(WORLDS), False
    print(f"| fault | {' | '.join(worlds)} |\n|{'---|' * (1 + len(worlds))}")
    for name, fault in FAULTS.items():
        cells, one_prior = [], collections.Counter()
        for at in worlds:
            named = collections.Counter()
            for study in range(int(studies)):
                rng = np.random.default_rng([int(seed), study, *at.encode(), *name.encode()])
                causes = check(credence, played(WORLDS[at](), rng, **fault))["battery"]["causes"]
                named[causes[0]["cause"] if causes else "none"] += 1
                one_prior[at] += any(cause["cause"].startswith(ONE_PRIOR) for cause in causes)
            cells.append(", ".join(f"{cause} {count}" for cause, count in named.most_common()))
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
        if fault.get("mode") in ("log", "stale", "parallel"):
            failed = failed or any(one_prior[at] < 0.9 * int(studies) for at in worlds if at in CLEAR)
        elif "shared" not in fault and "mode" not in fault:
            failed = failed or one_prior.total() > 0.1 * int(studies) * len(worlds)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) > 2 else __doc__)
