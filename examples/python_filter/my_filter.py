"""A Kalman filter over batches of runs, judged. python3 my_filter.py"""

import credence
import numpy as np

F, H = np.array([[1.0, 0.5], [0.0, 1.0]]), np.array([[1.0, 0.0]])
Q, R, P0 = np.diag([0.01, 0.04]), np.array([[0.25]]), np.diag([1.0, 0.5])


class World:
    def prior(self):
        return np.zeros(2), P0

    def initial(self, noise):
        return noise(2) @ np.sqrt(P0)

    def step(self, x, k, noise):
        return x @ F.T + noise(2) @ np.sqrt(Q)

    def measure(self, x, k, noise):
        return x @ H.T + noise(1) @ np.sqrt(R)


class Filter:
    def reset(self, mean, P):
        self.state, self.covariance = mean, P

    def predict(self):
        self.state = self.state @ F.T
        self.covariance = F @ self.covariance @ F.T + 0.5 * Q  # it thinks that the target is steadier than it is

    def update(self, z):
        self.innovation, self.S = z - self.state @ H.T, H @ self.covariance @ H.T + R
        K = self.covariance @ H.T / self.S
        self.state = self.state + (K @ self.innovation[..., None])[..., 0]
        self.covariance = self.covariance - K @ self.S @ K.transpose(0, 2, 1)


if __name__ == "__main__":
    result = credence.study(World(), Filter, runs=500, steps=50, names=["position", "velocity"])
    print(result)
    print("The report is", result.report("out"))
