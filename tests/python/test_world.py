"""Filters in another language: what ``credence world`` tells, answered to ``credence check -``."""

import csv
import io
import json
import os
import pathlib
import subprocess

import numpy as np
import pytest

CREDENCE = os.environ.get("CREDENCE", "credence")
SCENARIOS = pathlib.Path(__file__).resolve().parents[2] / "scenarios"


def told(scenario, *settings):
    """The lines ahead, and the rows with the names of the columns."""
    command = [CREDENCE, "world", str(SCENARIOS / f"{scenario}.toml"), *settings]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    ahead = [line for line in text.splitlines() if line.startswith("#")]
    rows = csv.DictReader(io.StringIO("\n".join(line for line in text.splitlines() if not line.startswith("#"))))
    return ahead, list(rows)


def numbers(row, kind):
    return np.array([float(value) for name, value in row.items() if name.startswith(kind) and value != ""])


def located(rows, dt, control_std, initial_std, position_std):
    """A plain EKF of place and heading; z is the place."""
    upper = np.triu_indices(3)
    yield [
        *("run", "step", "estimate.x", "estimate.y", "estimate.heading:angle", "truth.x", "truth.y", "truth.heading"),
        *(f"P.{i + 1}.{j + 1}" for i, j in zip(*upper)),
        *("innovation.1", "innovation.2", "S.1.1", "S.1.2", "S.2.2"),
    ]
    H = np.eye(2, 3)
    for row in rows:
        if row["step"] == "0":
            x, P = numbers(row, "prior."), np.diag(np.square(initial_std))
            continue
        u = numbers(row, "input.")
        c, s = np.cos(x[2]), np.sin(x[2])
        R = np.array([[c, -s], [s, c]])
        F, G = np.eye(3), dt * np.eye(3)
        F[:2, 2] = dt * R @ [-u[1], u[0]]
        G[:2, :2] = dt * R
        x = x + G @ u
        P = F @ P @ F.T + G @ np.diag(np.square(control_std)) @ G.T
        z, shown = numbers(row, "measurement."), [""] * 5
        if z.size:
            nu, S = z - x[:2], P[:2, :2] + position_std**2 * np.eye(2)
            K = P @ H.T @ np.linalg.inv(S)
            x, P = x + K @ nu, (np.eye(3) - K @ H) @ P
            shown = [*nu, S[0, 0], S[0, 1], S[1, 1]]
        yield [row["run"], row["step"], *x, *numbers(row, "truth."), *P[upper], *shown]


def test_a_filter_of_a_vehicle_has_the_verdict_of_the_built_in_one():
    settings = ["--runs", "16", "--steps", "60"]
    for key in ("world.aiding_interval=5", "initial.heading_std_deg=20", "initial.position_std=0.5",
                "filter.chart=componentwise"):
        settings += ["--set", key]
    ahead, rows = told("localisation", *settings)
    assert any(line.startswith("# state = SE(2)") for line in ahead)
    answers = "".join(
        ",".join(map(str, row)) + "\n"
        for row in located(rows, 0.01, [0.01, 0.01, np.pi / 180], [0.5, 0.5, np.radians(20)], 1.0)
    )
    judged = json.loads(subprocess.run([CREDENCE, "check", "-", "--format", "json"], input=answers, text=True,
                                       capture_output=True, check=True).stdout)
    built_in = json.loads(subprocess.run([CREDENCE, "run", str(SCENARIOS / "localisation.toml"), *settings,
                                          "--format", "json"], capture_output=True, check=True, text=True).stdout)
    for of in ("nees", "nis"):
        assert judged[of]["verdict"] == built_in[of]["verdict"]
        assert judged[of]["mean"] == pytest.approx(built_in[of]["mean"], rel=1e-9)
        assert judged[of]["p_value"] == pytest.approx(built_in[of]["p_value"], rel=1e-6)


@pytest.mark.parametrize(
    "scenario, settings, columns, ahead",
    [
        ("inertial", [], 2 + 15 + 15 + 6 + 6, "# state = SE_2(3) x R^6"),
        ("inertial_landmarks", [], 2 + 15 + 15 + 6 + 9, "# landmark3 = "),
        ("huang_ring", [], None, "# landmark1 = "),
        ("zhang_3d", ["--set", "world.landmarks=40"], 2 + 6 + 6 + 6 + 3 * 40, "# state = SE(3)"),
    ],
)
def test_every_world_that_measures_tells(scenario, settings, columns, ahead):
    lines, rows = told(scenario, "--runs", "2", "--steps", "200", *settings)
    assert any(line.startswith(ahead) for line in lines)
    assert len(rows) == 2 * 201
    if columns is not None:
        assert len(rows[0]) == columns
    assert numbers(rows[0], "prior.").size == numbers(rows[1], "truth.").size
    assert numbers(rows[0], "input.").size == 0 and numbers(rows[1], "input.").size >= 2
    assert any(numbers(row, "measurement.").size for row in rows[1:201])
    assert rows[1] != rows[202]  # another run, other noise


def turned(phi):
    """Exp of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(phi)
    K = np.array([[0, -phi[2], phi[1]], [phi[2], 0, -phi[0]], [-phi[1], phi[0], 0]]) / max(angle, 1e-300)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def test_the_world_in_space_tells_what_its_scenario_says():
    lines, rows = told("zhang_3d", "--runs", "1", "--steps", "40")
    landmarks = [np.array([float(v) for v in line.split("=")[1].split(",")]) for line in lines if "landmark" in line
                 and line.split("=")[1].count(",") == 2]
    truth = [numbers(row, "truth.") for row in rows]
    steps, observations = [], []
    for before, now, row in zip(truth[:-1], truth[1:], rows[1:]):
        R, next_R, u = turned(before[3:]), turned(now[3:]), numbers(row, "input.")
        v = R.T @ (now[:3] - before[:3])
        steps.append((u[:3] - v) / np.linalg.norm(v))
        assert np.allclose(turned(u[3:]), R.T @ next_R, atol=0.02)
        for i, landmark in enumerate(landmarks):
            seen = [row[f"measurement.landmark{i + 1}.{axis}"] for axis in "xyz"]
            if seen[0] == "":
                continue
            z = next_R.T @ (landmark - now[:3])
            observations.append((np.array([float(s) for s in seen]) - z) / np.linalg.norm(z))
    for off, share in ((np.array(steps), 0.01), (np.array(observations), 0.01)):
        deviation = np.sqrt(np.mean(off**2)) / share
        assert abs(deviation - 1) < 5 / np.sqrt(2 * off.size), deviation
