"""Extended Kalman filters in numpy, written apart from the library: their runs, logs of them, and what `credence check`
says of these. For wrong_filters.py and wrong_causes.py."""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "analysis" / "laws"))
from linear_filters import root  # noqa: E402


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
    """x = f(x, k) + G(x) v, z = h(x) + w of the runs in rows, with names, mean, P0, Q and R."""

    angles, measured_angles, nonlinear = (), (), True

    def F(self, x, k):
        return derivative(lambda y: self.f(y, k), x, self.angles)

    def G(self, x):
        return np.broadcast_to(np.eye(len(self.mean)), (len(x), len(self.mean), len(self.mean)))

    def H(self, x):
        return derivative(self.h, x, self.measured_angles)


class Linear(World):
    """One of linear_filters."""

    nonlinear = False

    def __init__(self, names, model):
        self.names, self.model, self.mean = names, model, np.zeros(len(names))
        self.P0, self.Q, self.R = model["P0"], model["Q"], model["R"]

    def f(self, x, k):
        return x @ self.model["F"].T

    def h(self, x):
        return x @ self.model["H"].T

    def F(self, x, k):
        return np.broadcast_to(self.model["F"], (len(x), *self.model["F"].shape))

    def H(self, x):
        return np.broadcast_to(self.model["H"], (len(x), *self.model["H"].shape))


class Log:
    """Arrays of runs × steps: estimate, truth, P, and of each sensor innovation and S, NaN where it was silent."""

    def __init__(self, world, estimate, truth, P, sensors):
        self.world, self.estimate, self.truth, self.P, self.sensors = world, estimate, truth, P, sensors

    def write(self, path):
        world, (runs, steps, n) = self.world, self.estimate.shape
        upper = np.triu_indices(n)
        run, step = np.meshgrid(np.arange(runs), np.arange(1, steps + 1), indexing="ij")
        head = ["run", "step", *(f"estimate.{s}" for s in world.names)]
        head += [f"truth.{s.split(':')[0]}" for s in world.names]
        head += [f"P.{i + 1}.{j + 1}" for i, j in zip(*upper)]
        parts = [run[..., None], step[..., None], self.estimate, self.truth, self.P[..., upper[0], upper[1]]]
        for sensor, (nu, S) in self.sensors.items():
            of, m = f"{sensor}." if sensor else "", nu.shape[-1]
            of_S = np.triu_indices(m)
            head += [f"innovation.{of}{i + 1}{':angle' if i in world.measured_angles else ''}" for i in range(m)]
            head += [f"S.{of}{i + 1}.{j + 1}" for i, j in zip(*of_S)]
            parts += [nu, np.where(np.isnan(nu[..., :1]), np.nan, S[..., of_S[0], of_S[1]])]
        head.append("nonlinear")
        parts.append(np.full((runs, steps, 1), float(world.nonlinear)))
        rows = np.concatenate(parts, -1).reshape(runs * steps, -1)
        line = ",".join(["%d", "%d", *["%.12g"] * (rows.shape[1] - 3), "%d"]) + "\n"
        text = "".join(line % tuple(row) for row in rows.tolist()).replace("nan", "")
        path.write_text(",".join(head) + "\n" + text)


def simulate(world, runs, steps, rng, Q=1.0, R=1.0, P0=1.0, kept=1.0, late=0, bias=(), outliers=0.0, noise=None,
             sensors=1, gate=np.inf, rejected=False, jump=None):
    """The log of a filter whose Q, R and P0 are the true ones times these and that keeps P times `kept` (0 where it
    drops it). What it measures is `late` by steps, with a `bias` of the first components and a share of `outliers`, 12
    times as large, of a law noise(shape). `sensors` copies of it are taken one after the other, whose innovations are
    all written against the prior; those with NIS beyond `gate` are not used, and written if `rejected`. The noise of the
motion at step `jump` is 20 times as large."""
    n, m = len(world.mean), len(world.R)
    draw = noise or rng.standard_normal
    truth = world.mean + rng.standard_normal((runs, n)) @ root(world.P0).T
    x, P = np.tile(world.mean, (runs, 1)), np.tile(P0 * world.P0, (runs, 1, 1))
    root_Q, root_R, used = root(world.Q).T, root(world.R).T, np.ones(runs, bool)
    seen, rows = [], []
    for k in range(steps):
        v = rng.standard_normal((runs, len(world.Q))) @ root_Q * (20.0 if k + 1 == jump else 1.0)
        truth = turned(world.angles, world.f(truth, k) + np.einsum("rij,rj->ri", world.G(truth), v))
        seen.append(world.h(truth))
        F, G = world.F(x, k), world.G(x)
        x = turned(world.angles, world.f(x, k))
        P = F @ P @ F.swapaxes(1, 2) + G @ (Q * world.Q) @ G.swapaxes(1, 2)
        innovations = []
        for sensor in range(sensors):
            w = draw((runs, m))
            if outliers:
                w = w * np.where(rng.random((runs, 1)) < outliers, 12.0, 1.0)
            w[:, : len(bias)] += bias
            z = seen[max(0, k - late)] + w @ root_R
            H = world.H(x)
            S, nu = H @ P @ H.swapaxes(1, 2) + R * world.R, turned(world.measured_angles, z - world.h(x))
            if sensor == 0:
                prior, prior_S = x, 0.5 * (S + S.swapaxes(1, 2))
            if np.isfinite(gate):
                used = np.einsum("ri,ri->r", nu, np.linalg.solve(S, nu[..., None])[..., 0]) <= gate
            of_prior = turned(world.measured_angles, z - world.h(prior))
            innovations += [np.where(used[:, None] | rejected, of_prior, np.nan), prior_S]
            K = np.where(used[:, None, None], np.linalg.solve(S, H @ P).swapaxes(1, 2), 0.0)
            x = turned(world.angles, x + np.einsum("rij,rj->ri", K, nu))
            A = np.eye(n) - K @ H
            P = (A @ P @ A.swapaxes(1, 2) + K @ (R * world.R) @ K.swapaxes(1, 2)) * kept
            P = 0.5 * (P + P.swapaxes(1, 2))
        rows.append([x, truth, P, *innovations])
    estimate, truth, P, *innovations = (np.stack(column, 1) for column in zip(*rows))
    names = [""] if sensors == 1 else [f"sensor{s + 1}" for s in range(sensors)]
    return Log(world, estimate, truth, P, dict(zip(names, zip(innovations[::2], innovations[1::2]))))


def told(command):
    """The document that a command of the program prints."""
    out = subprocess.run([*command, "--format", "json", "--quiet"], capture_output=True, text=True)
    if out.returncode != 0:
        raise SystemExit(f"{command[0]} {command[1]} failed:\n{out.stderr}")
    return json.loads(out.stdout)


def check(credence, log):
    """What the program says of it."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "log.csv"
        log.write(path)
        return told([credence, "check", path])
