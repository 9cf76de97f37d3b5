#!/usr/bin/env python3
"""Reference values of the linear systems of this folder, with 50 digits (mpmath), written to linear_systems.txt.

Of each system: its name; the traces of P and of the true error covariance, E[NEES] and E[NIS] at steps 1, 10 and 50;
and the trace of the limit of P before the update, "unbounded" where it grows for ever, or "-" where the limit is not
reached at a geometric rate; of a periodic system the trace of the limit of P after the update at the end of a period. The
recursions are those of the textbook, with the error of a filter that believes in other
matrices found from the covariance of the state and the estimate together: nothing is shared with the program.
"""
import glob
import os
import tomllib

from mpmath import eigsy, eye, inverse, matrix, mp, mpf, nstr, zeros

mp.dps = 50
STEPS = (1, 10, 50)


def numbers(rows):
    return matrix([[mpf(str(x)) for x in row] for row in rows])


def trace(A):
    return sum(A[i, i] for i in range(A.rows))


def stack(blocks):
    """A matrix of 2 × 2 blocks."""
    (a, b), (c, d) = blocks
    result = zeros(a.rows + c.rows, a.cols + b.cols)
    for block, i0, j0 in ((a, 0, 0), (b, 0, a.cols), (c, a.rows, 0), (d, a.rows, a.cols)):
        for i in range(block.rows):
            for j in range(block.cols):
                result[i0 + i, j0 + j] = block[i, j]
    return result


def expected_square(P, Sigma):
    """tr(P⁺ Σ)."""
    values, vectors = eigsy(P)
    largest = max(abs(v) for v in values)
    total = mpf(0)
    for k in range(P.rows):
        if values[k] > largest * mpf(10) ** -35:
            v = vectors[:, k]
            total += (v.T * Sigma * v)[0] / values[k]
    return total


def system(file):
    with open(file, "rb") as stream:
        scenario = tomllib.load(stream)
    world, belief = scenario["world"], scenario.get("filter", {})
    n, m, period = len(world["F"][0]), len(world["R"][0]), world.get("period", 1)
    truth, assumed = [], []
    for k in range(period):

        def of_step(rows, size):
            """Matrices of a period stand one above the other."""
            return numbers(rows if len(rows) == size else rows[k * size : (k + 1) * size])

        sizes = {"F": n, "H": m, "Q": len(world["Q"][0]), "R": m, "P0": n}
        t = {key: of_step(world[key], sizes[key]) for key in sizes}
        t["G"] = of_step(world["G"], n) if "G" in world else eye(n)
        rows = {**sizes, "G": n, "Q": len(belief.get("Q", world["Q"])[0])}
        a = {key: of_step(belief[key], rows[key]) if key in belief else t[key] for key in t}
        a["Q"] = a["Q"] * mpf(str(belief.get("process_scale", 1)))
        a["R"] = a["R"] * mpf(str(belief.get("measurement_scale", 1)))
        truth.append(t)
        assumed.append(a)
    return n, truth, assumed


def update(model, P):
    F, H, R = model["F"], model["H"], model["R"]
    prior = F * P * F.T + model["G"] * model["Q"] * model["G"].T
    S = H * prior * H.T + R
    K = prior * H.T * inverse(S)
    A = eye(P.rows) - K * H
    return prior, S, K, A * prior * A.T + K * R * K.T


def limit(assumed):
    P, last = assumed[0]["P0"], mpf(0)
    for _ in range(4000):
        for model in assumed:
            prior, _, _, P = update(model, P)
        now = trace(prior if len(assumed) == 1 else P)
        if abs(now - last) < abs(now) * mpf(10) ** -40:
            return nstr(now, 20)
        last = now
    return "unbounded" if last > 1000 else "-"


def main():
    folder = os.path.dirname(os.path.abspath(__file__))
    lines = []
    for file in sorted(glob.glob(os.path.join(folder, "*.toml"))):
        n, truths, beliefs = system(file)
        P, C = beliefs[0]["P0"], stack(((truths[0]["P0"], zeros(n)), (zeros(n), zeros(n))))  # of [x; x̂], from x̂ = 0
        values = []
        for k in range(1, max(STEPS) + 1):
            truth, assumed = truths[(k - 1) % len(truths)], beliefs[(k - 1) % len(beliefs)]
            F, H, GQG = truth["F"], truth["H"], truth["G"] * truth["Q"] * truth["G"].T
            _, S, K, P = update(assumed, P)
            before = stack(((F, zeros(n)), (zeros(n), assumed["F"])))
            C = before * C * before.T + stack(((GQG, zeros(n)), (zeros(n), zeros(n))))
            see = zeros(H.rows, 2 * n)
            for i in range(H.rows):
                for j in range(n):
                    see[i, j], see[i, n + j] = H[i, j], -assumed["H"][i, j]
            nis = expected_square(S, see * C * see.T + truth["R"])
            lower = stack(((zeros(n), zeros(n)), (K * H, zeros(n) - K * assumed["H"])))
            A = eye(2 * n) + lower
            noise = stack(((zeros(n), zeros(n)), (zeros(n), K * truth["R"] * K.T)))
            C = A * C * A.T + noise
            error = zeros(n, 2 * n)
            for i in range(n):
                error[i, i], error[i, n + i] = 1, -1
            Sigma = error * C * error.T
            if k in STEPS:
                values += [trace(P), trace(Sigma), expected_square(P, Sigma), nis]
        name = os.path.splitext(os.path.basename(file))[0]
        lines.append(" ".join([name] + [nstr(v, 20) for v in values] + [limit(beliefs)]))
        print(lines[-1])
    with open(os.path.join(folder, "linear_systems.txt"), "w") as out:
        out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
