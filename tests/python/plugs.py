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
