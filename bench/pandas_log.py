"""How much faster `credence check` judges a CSV log than a script with pandas tells its NEES, NIS, bounds, lags and bias.

python3 bench/pandas_log.py [PROGRAM [TIMES]] (build/release/credence, 9)

A log of 20 runs of 5,000 rows, 14 MB, is written, and both programs are started in turn, as a user starts them: the
wall time counts, interpreter, imports and all.
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

STATES, STATE_PAIRS = ["x", "y", "theta"], [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
INNOVATION_PAIRS = [(0, 0), (0, 1), (1, 1)]


def write_log(file, runs=20, steps=5000):
    """A consistent filter whose P comes and goes by a factor of four."""
    import numpy as np

    numbers = np.random.default_rng(1)
    P = np.array([[0.04, 0.01, 0.0], [0.01, 0.09, 0.0], [0.0, 0.0, 0.0004]])
    S = np.array([[0.5, 0.1], [0.1, 0.3]])
    scale = (1 + 0.3 * np.sin(np.arange(steps) / 100))[None, :, None]
    error = numbers.standard_normal((runs, steps, 3)) @ np.linalg.cholesky(P).T * scale
    innovation = numbers.standard_normal((runs, steps, 2)) @ np.linalg.cholesky(S).T
    claimed = np.array([P[pair] for pair in STATE_PAIRS]) * scale**2 + np.zeros((runs, 1, 1))
    columns = [np.repeat(np.arange(runs), steps), np.tile(0.1 * np.arange(steps), runs),
               *error.reshape(-1, 3).T, *claimed.reshape(-1, 6).T, *innovation.reshape(-1, 2).T,
               *np.tile([S[pair] for pair in INNOVATION_PAIRS], (runs * steps, 1)).T]
    names = ["run", "time", *(f"error.{state}" for state in STATES), *(f"P.{i}.{j}" for i, j in STATE_PAIRS),
             "innovation.0", "innovation.1", *(f"S.{i}.{j}" for i, j in INNOVATION_PAIRS)]
    np.savetxt(file, np.stack(columns, 1), "%.9g", ",", header=",".join(names), comments="")


def tell(file):
    """The script that is compared with: what is told of a filter without a tool, each number once."""
    import numpy as np
    import pandas as pd
    from scipy.stats import chi2

    rows = pd.read_csv(file)

    def matrices(name, size, pairs):
        all_rows = np.empty((len(rows), size, size))
        for i, j in pairs:
            all_rows[:, i, j] = all_rows[:, j, i] = rows[f"{name}.{i}.{j}"]
        return all_rows

    def normalised(vectors, covariances):
        return np.einsum("ki,ki->k", vectors, np.linalg.solve(covariances, vectors[:, :, None])[:, :, 0])

    error, P = rows[[f"error.{state}" for state in STATES]].to_numpy(), matrices("P", 3, STATE_PAIRS)
    innovation, S = rows[["innovation.0", "innovation.1"]].to_numpy(), matrices("S", 2, INNOVATION_PAIRS)
    rows["nees"], rows["nis"] = normalised(error, P), normalised(innovation, S)
    runs = rows.run.nunique()
    anees = rows.groupby(rows.groupby("run").cumcount()).nees.mean()
    low, high = chi2.ppf([0.025, 0.975], 3 * runs) / runs
    print("steps within their bounds", ((anees > low) & (anees < high)).mean())
    for name, dof in [("nees", 3), ("nis", 2)]:
        total, all_dof = rows[name].sum(), dof * len(rows)
        print(name, rows[name].mean(), "p", 2 * min(chi2.cdf(total, all_dof), chi2.sf(total, all_dof)))
    for component in innovation.T:
        lags = pd.Series(component).groupby(rows.run).apply(lambda run: [run.autocorr(lag) for lag in range(1, 11)])
        print("autocorrelation", np.mean(lags.tolist(), axis=0))
    scores = error / np.sqrt(np.einsum("kii->ki", P))
    print("bias", scores.mean(0) * np.sqrt(len(scores)), "within two sigma", (abs(scores) < 2).mean(0))


def seconds(command):
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - begin


def main():
    program, times = [*sys.argv[1:], *["build/release/credence", "9"][len(sys.argv) - 1:]]
    with tempfile.TemporaryDirectory() as folder:
        log = pathlib.Path(folder, "log.csv")
        write_log(log)
        commands = {"credence check": [program, "check", log],
                    "with --threads 1": [program, "check", log, "--threads", "1"],
                    "script with pandas": [sys.executable, __file__, "--tell", log]}
        taken = {name: [] for name in commands}
        for _ in range(int(times)):  # interleaved, as the machine may be busy
            for name, command in commands.items():
                taken[name].append(seconds(command))
        script = taken["script with pandas"]
        for name, values in taken.items():
            print(f"{name}: {statistics.median(values):.3f} s, of the script's time 1/"
                  f"{statistics.median(script) / statistics.median(values):.1f} (medians), "
                  f"1/{min(script) / min(values):.1f} (least)")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--tell"]:
        tell(sys.argv[2])
    else:
        main()
