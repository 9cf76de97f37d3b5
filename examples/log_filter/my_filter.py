"""A Kalman filter that writes logs for `credence check`. python3 my_filter.py && credence check logs"""

import pathlib
import random

DT, Q, R = 0.5, 0.04, 0.25  # s; process noise, measurement noise (m^2)
COLUMNS = "step,truth.position,truth.velocity,estimate.position,estimate.velocity,P.1.1,P.1.2,P.2.2,innovation.1,S.1.1"


def rows(noise, steps=100):
    """One run: a target with position and velocity, whose position is measured."""
    x, v = noise.gauss(0.0, 1.0), noise.gauss(0.0, 0.7)
    px, pv = 0.0, 0.0  # the estimate, and its covariance
    a, b, c = 1.0, 0.0, 0.49
    for k in range(1, steps + 1):
        x, v = x + DT * v, v + noise.gauss(0.0, Q**0.5)
        z = x + noise.gauss(0.0, R**0.5)
        px = px + DT * pv
        a, b, c = a + 2 * DT * b + DT * DT * c, b + DT * c, c + 0.5 * Q  # it thinks that the target is steadier
        nu, s = z - px, a + R
        px, pv = px + a / s * nu, pv + b / s * nu
        a, b, c = a - a * a / s, b - a * b / s, c - b * b / s
        yield k, x, v, px, pv, a, b, c, nu, s


if __name__ == "__main__":
    folder = pathlib.Path("logs")
    folder.mkdir(exist_ok=True)
    for run in range(200):
        lines = [",".join(repr(value) for value in row) for row in rows(random.Random(run))]
        (folder / f"run{run:03}.csv").write_text("\n".join([COLUMNS, *lines, ""]))
