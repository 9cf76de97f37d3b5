"""A world and filters over batches of runs, in a module so that other processes can import them."""

import numpy as np

from filters import F, H, P0, Q, R


class World:
    def prior(self):
        return np.array([0.0, 1.0]), P0

    def initial(self, noise):
        return np.array([0.0, 1.0]) + noise(2) @ np.sqrt(P0)

    def step(self, x, k, noise):
        return x @ F.T + noise(2) @ np.sqrt(Q)

    def measure(self, x, k, noise):
        return x @ H.T + noise(1) @ np.sqrt(R)


class Filter:
    """Serves a batch and, as matrix products do, a single run."""

    believed_Q = Q

    def reset(self, mean, P):
        self.state, self.covariance = mean, P

    def predict(self):
        self.state = self.state @ F.T
        self.covariance = F @ self.covariance @ F.T + self.believed_Q

    def update(self, z):
        self.innovation = z - self.state @ H.T
        self.S = H @ self.covariance @ H.T + R
        K = self.covariance @ H.T / self.S
        self.state = self.state + np.squeeze(K @ self.innovation[..., np.newaxis], axis=-1)
        P = self.covariance - K @ self.S @ np.swapaxes(K, -1, -2)
        self.covariance = 0.5 * (P + np.swapaxes(P, -1, -2))


class Optimistic(Filter):
    believed_Q = 0.1 * Q


class Fragile(Filter):
    """Throws where the state is far out, and becomes NaN where it is farther."""

    def update(self, z):
        if (np.abs(z) > 25.0).any():
            raise RuntimeError("lost")
        super().update(z)


class TimedWorld(World):
    dt = 0.5


class TimedFilter(Filter):
    def predict(self, dt):
        assert dt <= 0.5
        super().predict()
        self.covariance = self.covariance + (dt / 0.5 - 1.0) * Q


class UntimedNoise(Filter):
    """Adds the whole Q however short the step is."""

    def predict(self, dt):
        super().predict()


LATE = 5  # the step from which on the third state is measured


class MapWorld(World):
    """A third state that nothing changes: a landmark, first seen at step LATE."""

    def initial(self, noise):
        return np.concatenate([super().initial(noise), 3.0 * noise(1)], axis=-1)

    def step(self, x, k, noise):
        return np.concatenate([super().step(x[..., :2], k, noise), x[..., 2:]], axis=-1)

    def measure(self, x, k, noise):
        z = super().measure(x[..., :2], k, noise)
        seen = x[..., 2:] + 0.5 * noise(1)
        return z, seen if k >= LATE else None


class MapFilter(Filter):
    def reset(self, mean, P):
        super().reset(mean, P)
        self.place = self.variance = None

    def update(self, z):
        z, seen = z
        super().update(z)
        if seen is None:
            return
        if self.place is None:
            self.place, self.variance = seen, 0.25
        else:
            K = self.variance / (self.variance + 0.25)
            self.place, self.variance = self.place + K * (seen - self.place), (1.0 - K) * self.variance


class Growing:
    """Shows what MapFilter has."""

    masks, claimed = False, 1.0

    def __init__(self):
        self.filter = MapFilter()

    def reset(self, mean, P):
        self.filter.reset(mean, P)

    def predict(self):
        self.filter.predict()

    def update(self, z):
        self.filter.update(z)

    def states(self):
        n = 2 if self.filter.place is None else 3
        return np.arange(3) < n if self.masks else np.arange(n)

    @property
    def state(self):
        f = self.filter
        if f.place is None:
            return np.concatenate([f.state, f.state[..., :1]], axis=-1) if self.masks else f.state
        return np.concatenate([f.state, f.place], axis=-1)

    @property
    def covariance(self):
        f = self.filter
        if f.place is None and not self.masks:
            return f.covariance
        P = np.zeros((*f.covariance.shape[:-2], 3, 3))
        P[..., :2, :2] = f.covariance
        P[..., 2, 2] = np.nan if f.place is None else self.claimed * f.variance
        return P
