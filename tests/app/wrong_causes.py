"""Extended Kalman filters in numpy with one fault each, and the causes that `credence check` names for their logs.

usage: wrong_causes.py CREDENCE STUDIES [SEED [WORLD ...]]

Writes the table of docs/statistics.md, "Which cause": of each fault and world in how many studies the first cause was
right/left open/wrong, or how many there were where all are right. Fails where more than a quarter of the studies of a
fault are wrong.
"""

import collections
import sys

import numpy as np
from filter_logs import World, check, simulate, told, wrap

RUNS, STEPS = 50, 100


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


class Navigation(World):
    """Position, velocity, attitude and the biases of accelerometers and gyros, all errors of a body that weaves and climbs
    under gravity, in steps of a second; the position and the velocity are measured. Linear."""

    blocks, nonlinear = [list(range(3 * i, 3 * i + 3)) for i in range(5)], False
    names = [f"{block}.{axis}" for block in ("position", "velocity", "attitude", "accelerometer", "gyro") for axis in "xyz"]
    slow = slice(6, 12)
    mean, P0 = np.zeros(15), np.diag(np.repeat([4.0, 0.25, 4e-4, 4e-4, 1e-6], 3))
    Q, R = np.diag(np.repeat([1e-3, 1e-6, 4e-7, 1e-9], 3)), np.diag(np.repeat([2.25, 0.01], 3))

    def accelerated(self, k):
        return np.array([0.8 * np.cos(k / 5), 1.2 * np.sin(k / 8), 0.3 * np.sin(k / 13)])

    def transition(self, k):
        F, (a, b, c) = np.eye(15), self.accelerated(k) + [0.0, 0.0, 9.81]
        F[:3, 3:6], F[:3, 9:12], F[3:6, 9:12], F[6:9, 12:] = np.eye(3), 0.5 * np.eye(3), np.eye(3), np.eye(3)
        F[3:6, 6:9] = [[0.0, c, -b], [-c, 0.0, a], [b, -a, 0.0]]
        F[:3, 6:9] = 0.5 * F[3:6, 6:9]
        return F

    def f(self, x, k):
        a = self.accelerated(k)
        return x @ self.transition(k).T + np.concatenate([0.5 * a, a, np.zeros(9)])

    def F(self, x, k):
        return np.broadcast_to(self.transition(k), (len(x), 15, 15))

    def G(self, x):
        return np.broadcast_to(np.eye(15)[:, 3:], (len(x), 15, 12))

    def h(self, x):
        return x[:, :6]

    def H(self, x):
        return np.broadcast_to(np.eye(6, 15), (len(x), 6, 15))


WORLDS = {world.__name__.lower(): world
          for world in (Inertial, Targets, Pendulum, Unicycle, Beacons, Turning, Navigation)}
WORLDS |= {name: name for name in ("planar_loop", "huang_ring", "zhang_3d", "tracking_radar", "planar_table")}
SETTINGS = {"Q": "filter.process_scale", "R": "filter.measurement_scale", "late": "noise.measurement_delay"}
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
    "a diagonal P, in the log": ({"logged": "states"}, "cross-covariances"),
    "Q of the biases × 0.01": ({"slow": 0.01}, "process noise Q assumed too small"),
    "a gate of 95 %, what it rejects logged": ({"gated": True}, "innovations that had to pass a gate"),
    "measurements 1 step late": ({"late": 1}, "measurements that arrive late"),
    "measurements 3 steps late": ({"late": 3}, "measurements that arrive late"),
    "a bias of 0.7 σ": ({"bias": (0.7,)}, "a bias"),
    "1 % of outliers": ({"outliers": 0.01}, "outliers"),
    "a motion of 20 σ at step 12": ({"jump": 12}, "what happens at one step"),
    "a motion of 20 σ at step 60": ({"jump": 60}, "what happens at one step"),
    "headings in degrees": ({"degrees": True}, ""),
}
NOISE, SCALE = "process or measurement noise", "the scale of the covariance"
START, MOTION = "the initial covariance or process noise", "process noise Q assumed too small, or the linearisation"
BEGIN = "the initial covariance, or the linearisation"
OPEN = {  # of what is right, the causes that leave it open: they name it and another, or nothing but a factor
    "": ("the filter's linearisation", "the linearisation", BEGIN, MOTION),  # an extended Kalman filter is never quite right
    "process noise Q assumed too small": (NOISE, MOTION, START, SCALE),
    "process noise Q assumed too large": (NOISE, START, SCALE),
    "measurement noise R assumed too small": (NOISE, SCALE),
    "measurement noise R assumed too large": (NOISE, SCALE),
    "the initial covariance": (START, BEGIN, SCALE),
}


def mask(world, what):
    """1 where P is kept, 0 where it is dropped."""
    n = len(world.mean)
    blocks = {"": [range(n)], "blocks": world.blocks, "states": [[i] for i in range(n)]}[what]
    kept = np.zeros((n, n))
    for block in blocks:
        kept[np.ix_(block, block)] = 1.0
    return kept


def quantile95(m):
    """Of χ²(m), nearly [Wilson 1931]."""
    return m * (1 - 2 / (9 * m) + 1.6449 * np.sqrt(2 / (9 * m))) ** 3


def faulty(world, rng, keep="", logged="", degrees=False, gated=False, slow=1.0, **faults):
    """The log of a filter that keeps, and writes, P of these parts of the state alone, or angles in degrees, that does
    not use what lies beyond a gate of 95 %, or whose Q of what is slow is wrong by a factor."""
    if gated:
        faults |= {"gate": quantile95(len(world.R)), "rejected": True}
    if slow != 1.0:
        faults["Q"] = np.ones(len(world.Q))
        faults["Q"][world.slow] = slow
    log = simulate(world, RUNS, STEPS, rng, kept=mask(world, keep), **faults)
    log.P = log.P * mask(world, logged)
    if degrees:
        for values in (log.estimate, log.truth):
            values[..., list(world.angles)] *= 180 / np.pi
    return log


def studied(credence, scenario, rng, **faults):
    """The document of a scenario that comes with the program; none where it has no such fault."""
    if not set(faults) <= set(SETTINGS):
        return None
    settings = [f"--set={SETTINGS[key]}={value}" for key, value in faults.items()]
    seed = str(rng.integers(2**31))
    return told([credence, "run", scenario, "--runs", str(RUNS), "--steps", str(STEPS), "--seed", seed, *settings])


def first_causes(credence, at, name, studies, seed):
    """The first cause of each study of a fault in a world, "" for none; no studies where a world has no such fault."""
    world, (fault, _) = WORLDS[at], FAULTS[name]
    for study in range(studies):
        rng = np.random.default_rng([seed, study, *at.encode(), *name.encode()])
        if isinstance(world, str):
            document = studied(credence, world, rng, **fault)
        elif ("degrees" in fault and not world.angles) or ("slow" in fault and not hasattr(world, "slow")):
            document = None
        else:
            document = check(credence, faulty(world(), rng, **fault))
        if document is None:
            return
        yield next((cause["cause"] for cause in document["battery"]["causes"]), "")


def judged(first, right):
    if first and first.startswith(OPEN.get(right, ())):
        return "open"
    return "right" if (first.startswith(right) if right else not first) else "wrong"


def cell(counts):
    if not counts:
        return "–"
    all_right = counts["right"] == counts.total()
    return str(counts.total()) if all_right else "/".join(str(counts[k]) for k in ("right", "open", "wrong"))


def main(credence, studies, seed="1", *worlds):
    worlds, failed = worlds or tuple(WORLDS), False
    print(f"| fault | {' | '.join(worlds)} | named instead |\n|{'---|' * (2 + len(worlds))}")
    for name, (_, right) in FAULTS.items():
        cells, instead, all_counts = [], collections.Counter(), collections.Counter()
        for at in worlds:
            counts = collections.Counter()
            for first in first_causes(credence, at, name, int(studies), int(seed)):
                counts[judged(first, right)] += 1
                instead[first or "none"] += judged(first, right) != "right"
            cells.append(cell(counts))
            all_counts += counts
        failed = failed or 4 * all_counts["wrong"] > all_counts.total()
        told_instead = ", ".join(f"{cause} {n}" for cause, n in instead.most_common() if n)
        print(f"| {name} | {' | '.join(cells)} | {told_instead} |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) > 2 else __doc__)
