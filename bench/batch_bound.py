"""What the O(N) bound of a whole batch gives beside that of scalars in turn (docs/theory.md, section 4).

Six landmarks about a circle of 63 m, seen within 12 m, Jacobians at the truth, ten loops: scenarios/map_solutions.toml.
After a batch of m scalars the map is D - L L^T. `batch_bound.py` prints for every solution the mean of tr P over the
first and the tenth loop, before and after the map is decorrelated, sweeps a step, and the share of steps whose map improved.
"""

import sys

import numpy as np

RADIUS, LANDMARKS, LOOP = 10.026761, 6, 63
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
Q = np.diag([0.01, 0.0004])
R = np.diag([0.01, np.deg2rad(1.0) ** 2])


def pose_at(s):
    a = s / RADIUS
    return np.array([RADIUS * np.cos(a), RADIUS * np.sin(a), a + np.pi / 2])


def landmark_places():
    places = []
    for i in range(LANDMARKS):
        p = pose_at(2 * np.pi * RADIUS * (i + 0.5) / LANDMARKS)
        side = (0.3 if i % 2 == 0 else -0.3) * RADIUS
        places.append(p[:2] + side * np.array([-np.sin(p[2]), np.cos(p[2])]))
    return places


def root(A):
    w, U = np.linalg.eigh(0.5 * (A + A.T))
    return (U * np.sqrt(np.maximum(w, 0.0))) @ U.T


def total(blocks):
    return sum(np.trace(b) for b in blocks)


def scalar_bound(D, l):
    """The least trace for one column."""
    parts = l.reshape(-1, 2)
    a = np.linalg.norm(parts, axis=1)
    i = a.argmax()
    others = a.sum() - a[i]
    if a[i] <= others:
        return D
    excess = a[i] - others
    share = [others / a[i] - 1.0 if j == i else excess / a[j] if a[j] > 0 else 0.0 for j in range(len(a))]
    return [d + s * np.outer(x, x) for d, s, x in zip(D, share, parts)]


def rotated_bound(D, L, rows):
    """Columns rotated so that L of the landmarks measured is symmetric, then in turn."""
    U, _, Wt = np.linalg.svd(L[rows])
    turned = L @ Wt.T @ U.T
    for column in turned.T:
        D = scalar_bound(D, column)
    return D


def batch_bound(D, L, most_sweeps, counts, hopeless=1e-6):
    """min |sum V_j L_j|^2 over isometries V_j, E_j = (G_j^T G_j)^(1/2), repaired by a scale; D where that is no gain.

    For any V the trace can fall by no more than |sum V_j L_j|^2: where that is nothing the batch is dropped."""
    parts = list(L.reshape(-1, 2, L.shape[1]))
    V = []
    first = np.argmax([np.linalg.norm(x) for x in parts])
    for j, x in enumerate(parts):
        U, _, Wt = np.linalg.svd(x.T, full_matrices=False)
        V.append(U @ Wt if j == first else -(U @ Wt))
    M = sum(v @ x for v, x in zip(V, parts))
    for _ in range(most_sweeps):
        before = np.sum(M * M)
        if before <= hopeless * total(D):
            return D
        counts["sweeps"] += 1
        for j, x in enumerate(parts):
            rest = M - V[j] @ x
            U, _, Wt = np.linalg.svd(rest @ x.T, full_matrices=False)
            V[j] = -(U @ Wt)
            M = rest + V[j] @ x
        if before - np.sum(M * M) <= 1e-4 * np.sum(M * M):
            break
    E = []
    for v, x in zip(V, parts):
        G = (M - v @ x) @ x.T
        E.append(root(G.T @ G))
    off = L @ L.T
    for j in range(len(D)):
        off[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] = 0.0

    def valid(scale):
        Y = off.copy()
        for j, e in enumerate(E):
            Y[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] = scale * e
        return np.linalg.eigvalsh(Y).min() >= -1e-13 * np.sum(L * L)

    scale, step = 1.0, 1e-4
    while not valid(scale) and scale < 4.0:
        scale, step = 1.0 + step, 2.0 * step
    new = [d - x @ x.T + scale * e for d, x, e in zip(D, parts, E)]
    if scale >= 4.0 or total(new) >= total(D):
        return D
    counts["lowered"] += 1
    return new


def drive(solution, sweeps, loops=10):
    places, known = landmark_places(), []
    P = np.diag([0.05**2, 0.05**2, np.deg2rad(1.0) ** 2])
    before, after = [], []
    counts = {"sweeps": 0, "lowered": 0}
    for k in range(1, LOOP * loops + 1):
        x0, x = pose_at(k - 1.0), pose_at(float(k))
        n = len(P)
        F = np.eye(n)
        F[:2, 2] = TURN @ (x[:2] - x0[:2])
        P = F @ P @ F.T
        G = np.array([[np.cos(x0[2]), 0.0], [np.sin(x0[2]), 0.0], [0.0, 1.0]])
        P[:3, :3] += G @ Q @ G.T
        seen = [i for i in range(LANDMARKS) if 1.0 <= np.linalg.norm(places[i] - x[:2]) <= 12.0]
        batch = [i for i in seen if i in known]
        rows, H = [], np.zeros((2 * len(batch), n))
        for r, i in enumerate(batch):
            d = places[i] - x[:2]
            q = np.linalg.norm(d)
            own = np.array([d / q, [-d[1] / q**2, d[0] / q**2]])
            at = 3 + 2 * known.index(i)
            rows += [at - 3, at - 2]
            H[2 * r : 2 * r + 2, :2] = -own
            H[2 * r + 1, 2] = -1.0
            H[2 * r : 2 * r + 2, at : at + 2] = own
        D = [P[3 + 2 * j : 5 + 2 * j, 3 + 2 * j : 5 + 2 * j].copy() for j in range(len(known))]
        if solution == "sequential":
            for h, r in zip(H, np.tile(np.diag(R), len(batch))):
                l = P @ h / np.sqrt(h @ P @ h + r)
                P = P - np.outer(l, l)
                D = scalar_bound(D, l[3:])
                P[3:, 3:] = 0.0
                for j, d in enumerate(D):
                    P[3 + 2 * j : 5 + 2 * j, 3 + 2 * j : 5 + 2 * j] = d
            before.append(np.trace(P))
        else:
            if batch:
                S = H @ P @ H.T + np.kron(np.eye(len(batch)), R)
                W = np.linalg.solve(np.linalg.cholesky(S), H @ P).T
                P = P - W @ W.T
            before.append(np.trace(P))
            if batch:
                D = rotated_bound(D, W[3:], rows) if solution == "rotated" else batch_bound(D, W[3:], sweeps, counts)
            P[3:, 3:] = 0.0
            for j, d in enumerate(D):
                P[3 + 2 * j : 5 + 2 * j, 3 + 2 * j : 5 + 2 * j] = d
        for i in (i for i in seen if i not in known):
            d, n = places[i] - x[:2], len(P)
            q, b = np.linalg.norm(d), np.arctan2(d[1], d[0])
            J_r = np.hstack([np.eye(2), (TURN @ d)[:, None]])
            J_z = np.array([[np.cos(b), -q * np.sin(b)], [np.sin(b), q * np.cos(b)]])
            grown = np.zeros((n + 2, n + 2))
            grown[:n, :n] = P
            grown[n:, :n] = J_r @ P[:3]
            grown[:n, n:] = grown[n:, :n].T
            grown[n:, n:] = J_r @ P[:3, :3] @ J_r.T + J_z @ R @ J_z.T
            P = grown
            for j in range(len(known)):  # a star: in turn is the least trace
                C = P[n:, 3 + 2 * j : 5 + 2 * j].copy()
                P[n:, n:] += root(C @ C.T)
                P[3 + 2 * j : 5 + 2 * j, 3 + 2 * j : 5 + 2 * j] += root(C.T @ C)
                P[n:, 3 + 2 * j : 5 + 2 * j] = 0.0
                P[3 + 2 * j : 5 + 2 * j, n:] = 0.0
            known.append(i)
        after.append(np.trace(P))
    steps = LOOP * loops
    first, last = slice(0, LOOP), slice(steps - LOOP, steps)
    print(
        f"{solution:12s} sweeps <= {sweeps}: before {np.mean(before[first]):.3g}, {np.mean(before[last]):.3g}; "
        f"after {np.mean(after[first]):.3g}, {np.mean(after[last]):.3g}; "
        f"{counts['sweeps'] / steps:.2f} sweeps a step, improved in {100 * counts['lowered'] / steps:.1f} %"
    )


def main():
    loops = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    for solution, sweeps in [("sequential", 0), ("rotated", 0), ("batch", 1), ("batch", 2), ("batch", 5), ("batch", 50)]:
        drive(solution, sweeps, loops)


main()
