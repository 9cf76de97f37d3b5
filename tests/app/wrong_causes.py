"""Extended Kalman filters in numpy with one fault each, and the causes that `credence check` names for their logs.

usage: wrong_causes.py CREDENCE STUDIES [SEED [WORLD ...]]

Writes a table as that of docs/statistics.md, "Which cause"; fails where the right cause is named in less than half of
the studies of a fault.
"""

import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

RUNS, STEPS = 50, 100


def wrap(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def turned(v, values):
    """The values of a run each, those of the places `v` as angles."""
    values = values.copy()
    for i in v:
        values[:, i] = wrap(values[:, i])
    return values


def derivative(function, x, angles):
    """The Jacobian of every run, by central differences."""
    columns = []
    for i in range(x.shape[1]):
        step = 1e-5 * np.eye(x.shape[1])[i]
        columns.append(turned(angles, function(x + step) - function(x - step)) / 2e-5)
    return np.stack(columns, -1)


class World:
    """x = f(x, k) + G(x) v, z = h(x) + w; blocks: what a filter keeps that drops the covariances between them."""

    angles, measured_angles, nonlinear = (), (), True

    def G(self, x):
        return np.broadcast_to(np.eye(len(self.mean)), (len(x), len(self.mean), len(self.mean)))


class Inertial(World):
    """Position, velocity and the bias of an accelerometer; the position is measured. Linear."""

    names, blocks, nonlinear = ["p", "v", "b"], [[0], [1], [2]], False
    mean, P0 = np.zeros(3), np.diag([1.0, 0.25, 0.01])
    Q, R = np.diag([0.01, 0.04, 1e-4]), np.eye(1)

    def f(self, x, k):
        F = np.array([[1, 1, -0.5], [0, 1, -1], [0, 0, 1.0]])
        return x @ F.T + np.array([0.5, 1.0, 0.0]) * np.sin(k / 9)

    def h(self, x):
        return x[:, :1]


class Targets(World):
    """A target of nearly constant velocity, whose range and bearing are measured."""

    names, blocks = ["x", "y", "vx", "vy"], [[0, 1], [2, 3]]
    measured_angles = (1,)
    mean, P0 = np.array([400.0, 300.0, -4.0, 3.0]), np.diag([25.0, 25.0, 4.0, 4.0])
    Q, R = 0.2 * np.kron([[1 / 3, 0.5], [0.5, 1]], np.eye(2)), np.diag([25.0, 1e-4])

    def f(self, x, k):
        return np.concatenate([x[:, :2] + x[:, 2:], x[:, 2:]], 1)

    def h(self, x):
        return np.stack([np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0])], -1)


class Pendulum(World):
    """Angle and rate; the sine of the angle is measured."""

    names, blocks = ["angle", "rate"], [[0], [1]]
    mean, P0 = np.array([0.8, 0.0]), np.diag([0.01, 0.04])
    Q, R = np.array([[4e-4]]), np.array([[2.5e-3]])

    def f(self, x, k):
        return np.stack([x[:, 0] + 0.05 * x[:, 1], x[:, 1] - 9.81 * 0.05 * np.sin(x[:, 0])], 1)

    def G(self, x):
        return np.broadcast_to([[0.0], [1.0]], (len(x), 2, 1))

    def h(self, x):
        return np.sin(x[:, :1])


class Unicycle(World):
    """Odometry of a vehicle that turns, with a GPS."""

    names, blocks, angles = ["x", "y", "heading:angle"], [[0, 1], [2]], (2,)
    mean, P0 = np.array([0.0, 0.0, 0.3]), np.diag([0.04, 0.04, 0.01])
    Q, R = np.diag([0.01, 9e-4]), 0.09 * np.eye(2)

    def f(self, x, k):
        v, w = 0.5 * (1 + 0.3 * np.sin(k / 7)), 0.15 * np.cos(k / 11)
        return np.stack([x[:, 0] + v * np.cos(x[:, 2]), x[:, 1] + v * np.sin(x[:, 2]), x[:, 2] + w], 1)

    def G(self, x):
        G = np.zeros((len(x), 3, 2))
        G[:, 0, 0], G[:, 1, 0], G[:, 2, 1] = np.cos(x[:, 2]), np.sin(x[:, 2]), 1.0
        return G

    def h(self, x):
        return x[:, :2]


class Beacons(Unicycle):
    """The same with the range and bearing of three beacons."""

    measured_angles = (1, 3, 5)
    Q, R = np.diag([2.5e-3, 4e-4]), np.diag([0.04, 2.5e-3] * 3)

    def h(self, x):
        d = np.array([[6.0, 0.0], [-4.0, 7.0], [0.0, -6.0]]) - x[:, None, :2]
        bearing = wrap(np.arctan2(d[..., 1], d[..., 0]) - x[:, None, 2])
        return np.stack([np.hypot(d[..., 0], d[..., 1]), bearing], -1).reshape(len(x), -1)


class Turning(World):
    """Position, heading, speed and rate of turn; position and speed are measured."""

    names, angles = ["x", "y", "heading:angle", "speed", "turn"], (2,)
    blocks = [[0, 1], [2], [3, 4]]
    mean, P0 = np.array([0.0, 0.0, 0.5, 2.0, 0.05]), np.diag([0.25, 0.25, 0.01, 0.04, 4e-4])
    Q, R = np.diag([0.01, 4e-4]), np.diag([0.25, 0.25, 0.09])

    def f(self, x, k):
        a = x[:, 2] + 0.5 * x[:, 4]
        moved = [x[:, 0] + x[:, 3] * np.cos(a), x[:, 1] + x[:, 3] * np.sin(a), x[:, 2] + x[:, 4]]
        return np.stack([*moved, x[:, 3], x[:, 4]], 1)

    def G(self, x):
        return np.broadcast_to(np.eye(5)[:, 3:], (len(x), 5, 2))

    def h(self, x):
        return x[:, [0, 1, 3]]


WORLDS = {world.__name__.lower(): world for world in (Inertial, Targets, Pendulum, Unicycle, Beacons, Turning)}
FAULTS = {  # the fault, and how a cause begins that is right
    "nothing": ({}, ""),
    "Q × 0.2": ({"Q": 0.2}, "process noise Q assumed too small"),
    "Q × 5": ({"Q": 5.0}, "process noise Q assumed too large"),
    "R × 0.25": ({"R": 0.25}, "measurement noise R assumed too small"),
    "R × 4": ({"R": 4.0}, "measurement noise R assumed too large"),
    "P0 × 0.1": ({"P0": 0.1}, "the initial covariance"),
    "P of blocks alone, at every step": ({"keep": "blocks"}, "cross-covariances"),
    "a diagonal P, at every step": ({"keep": "states"}, "cross-covariances"),
    "P of blocks alone, in the log": ({"logged": "blocks"}, "cross-covariances"),
    "measurements 1 step late": ({"late": 1}, "measurements that arrive late"),
    "measurements 3 steps late": ({"late": 3}, "measurements that arrive late"),
    "a bias of 0.7 σ": ({"bias": 0.7}, "a bias"),
    "1 % of outliers": ({"outliers": 0.01}, "outliers"),
    "headings in degrees": ({"degrees": True}, ""),
}


def kept(world, what):
    """1 where P is kept, 0 where it is dropped."""
    n = len(world.mean)
    blocks = {"": [range(n)], "blocks": world.blocks, "states": [[i] for i in range(n)]}[what]
    mask = np.zeros((n, n))
    for block in blocks:
        mask[np.ix_(block, block)] = 1.0
    return mask


def simulate(world, rng, Q=1.0, R=1.0, P0=1.0, keep="", logged="", late=0, bias=0.0, outliers=0.0, degrees=False):
    """What the log of a filter holds, whose Q, R and P0 are the true ones times these: estimate, truth, P, ν, S."""
    n, m = len(world.mean), len(world.R)
    truth = world.mean + rng.standard_normal((RUNS, n)) @ np.sqrt(world.P0)
    x, P = np.tile(world.mean, (RUNS, 1)), np.tile(P0 * world.P0, (RUNS, 1, 1))
    root_Q = np.linalg.cholesky(world.Q)
    mask, log_mask = kept(world, keep), kept(world, logged)
    seen, rows = [], []
    for k in range(STEPS):
        v = rng.standard_normal((RUNS, len(world.Q))) @ root_Q.T
        truth = turned(world.angles, world.f(truth, k) + np.einsum("rij,rj->ri", world.G(truth), v))
        F, G = derivative(lambda y, k=k: world.f(y, k), x, world.angles), world.G(x)
        x = turned(world.angles, world.f(x, k))
        P = F @ P @ F.swapaxes(1, 2) + G @ (Q * world.Q) @ G.swapaxes(1, 2)
        noise = rng.standard_normal((RUNS, m)) * np.where(rng.random((RUNS, 1)) < outliers, 12.0, 1.0)
        noise[:, 0] += bias
        seen.append(world.h(truth))
        z = seen[max(0, k - late)] + noise @ np.sqrt(world.R)
        H = derivative(world.h, x, world.measured_angles)
        S = H @ P @ H.swapaxes(1, 2) + R * world.R
        nu = turned(world.measured_angles, z - world.h(x))
        K = np.linalg.solve(S, H @ P).swapaxes(1, 2)
        x = turned(world.angles, x + np.einsum("rij,rj->ri", K, nu))
        A = np.eye(n) - K @ H
        P = (A @ P @ A.swapaxes(1, 2) + K @ (R * world.R) @ K.swapaxes(1, 2)) * mask
        P = 0.5 * (P + P.swapaxes(1, 2))
        rows.append([x, truth, P * log_mask, nu, 0.5 * (S + S.swapaxes(1, 2))])
    estimate, truth, P, nu, S = (np.stack(column, 1) for column in zip(*rows))
    if degrees:
        estimate[..., list(world.angles)] *= 180 / np.pi
        truth[..., list(world.angles)] *= 180 / np.pi
    return estimate, truth, P, nu, S


def write(world, study, path):
    estimate, truth, P, nu, S = study
    of_P, of_S = np.triu_indices(P.shape[-1]), np.triu_indices(S.shape[-1])
    head = ["run", "step", *(f"estimate.{s}" for s in world.names)]
    head += [f"truth.{s.split(':')[0]}" for s in world.names]
    head += [f"P.{i + 1}.{j + 1}" for i, j in zip(*of_P)]
    head += [f"innovation.{i + 1}{':angle' if i in world.measured_angles else ''}" for i in range(nu.shape[-1])]
    head += [f"S.{i + 1}.{j + 1}" for i, j in zip(*of_S)] + ["nonlinear"]
    run, step = np.meshgrid(np.arange(RUNS), np.arange(1, STEPS + 1), indexing="ij")
    flag = np.full((RUNS, STEPS, 1), float(world.nonlinear))
    parts = [run[..., None], step[..., None], estimate, truth]
    parts += [P[..., of_P[0], of_P[1]], nu, S[..., of_S[0], of_S[1]], flag]
    rows = np.concatenate(parts, -1).reshape(RUNS * STEPS, -1)
    line = ",".join(["%d", "%d", *["%.12g"] * (rows.shape[1] - 3), "%d"]) + "\n"
    path.write_text(",".join(head) + "\n" + "".join(line % tuple(row) for row in rows.tolist()))


def causes_of(credence, world, fault, rng, folder):
    log = pathlib.Path(folder) / "log.csv"
    write(world, simulate(world, rng, **fault), log)
    out = subprocess.run([credence, "check", log, "--format", "json", "--quiet"], capture_output=True, text=True)
    if out.returncode != 0:
        raise SystemExit(f"credence check failed:\n{out.stderr}")
    return [cause["cause"] for cause in json.loads(out.stdout)["battery"]["causes"]]


def main(credence, studies, seed="1", *worlds):
    failed = False
    for name, (fault, right) in FAULTS.items():
        first, by_world, all_named = collections.Counter(), [], 0
        for at in worlds or WORLDS:
            world = WORLDS[at]()
            if "degrees" in fault and not world.angles:
                continue
            named = 0
            for study in range(int(studies)):
                rng = np.random.default_rng([int(seed), study, *at.encode(), *name.encode()])
                with tempfile.TemporaryDirectory() as folder:
                    causes = causes_of(credence, world, fault, rng, folder)
                named += causes[0].startswith(right) if causes and right else not causes and not right
                first[causes[0] if causes else "none"] += 1
            by_world.append(f"{at} {named}")
            all_named += named
        failed = failed or 2 * all_named < sum(first.values())
        print(f"| {name} | {', '.join(by_world)} | {dict(first.most_common())} |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) > 2 else __doc__)
