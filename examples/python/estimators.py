"""Two estimators written in Python, for `slammot run`, `compare` and studies:

    slammot compare --scenario helix --estimator ekf --estimator python:examples/python/estimators.py:KnownPoints
"""
import numpy as np
import slammot
from slammot import so3


class DeadReckoning(slammot.Estimator):
    """The camera's motion model alone: constant velocities, white noise of both accelerations."""
    description = "the motion model alone, in Python"

    def __init__(self, setup):
        self.setup = setup
        self.x = setup.initial
        self.x.timestamp = None

    def process(self, frame):
        if self.x.timestamp is not None:
            self.predict(frame.timestamp - self.x.timestamp)
        self.x.timestamp = frame.timestamp
        return self.x, slammot.FrameReport(state_size=12)

    def predict(self, dt):
        turn = self.x.angular_velocity * dt
        F = np.eye(12)
        F[0:3, 6:9] = dt * np.eye(3)
        F[3:6, 3:6] = so3.matrix(so3.exp(turn)).T
        F[3:6, 9:12] = dt * so3.right_jacobian(turn)
        sigmas = np.repeat([self.setup.acceleration, self.setup.angular_acceleration], 3)
        Q = np.kron([[dt**2 / 3, dt / 2], [dt / 2, 1.0]], np.diag((sigmas * dt) ** 2))
        self.x.covariance = F @ self.x.covariance @ F.T + Q
        self.x.position = self.x.position + dt * self.x.velocity
        self.x.orientation = so3.multiply(self.x.orientation, so3.exp(turn))


class KnownPoints(DeadReckoning):
    """An EKF of the camera alone, which uses the landmarks that are known beforehand. Pinhole cameras only."""
    description = "EKF on the known landmarks, in Python"

    def __init__(self, setup, probability=None):
        super().__init__(setup)
        probability = probability or float(setup.configuration["gate.probability"])
        self.gate = -2.0 * np.log(1.0 - probability)  # quantile of chi-square(2)
        self.known = {track: (position, sigma) for track, position, sigma in
                      zip(setup.known.tracks, setup.known.positions, setup.known.sigmas)}

    def process(self, frame):
        _, report = super().process(frame)
        measured = zip(frame.tracks, frame.pixels, self.setup.pixel_sigma * frame.relative_sigmas)
        nis = [self.update(pixel, pixel_sigma, *self.known[track]) for track, pixel, pixel_sigma in measured
               if track in self.known]
        accepted = [value for value in nis if value <= self.gate]
        report.accepted, report.rejected, report.nis = len(accepted), len(nis) - len(accepted), np.array(accepted)
        return self.x, report

    def update(self, pixel, pixel_sigma, point, sigma):
        """One measurement of one known point; returns its NIS and uses it if it is within the gate."""
        camera, x = self.setup.camera, self.x
        R = so3.matrix(x.orientation)
        ray = R.T @ (point - x.position)
        if ray[2] <= 0.0:
            return np.inf
        predicted = camera.matrix[:2] @ (ray / ray[2])
        J_pixel_ray = np.array([[camera.fx, 0.0, -camera.fx * ray[0] / ray[2]],
                                [0.0, camera.fy, -camera.fy * ray[1] / ray[2]]]) / ray[2]
        H = np.hstack([-J_pixel_ray @ R.T, J_pixel_ray @ so3.hat(ray), np.zeros((2, 6))])
        S = H @ x.covariance @ H.T + pixel_sigma**2 * np.eye(2)
        S += sigma**2 * J_pixel_ray @ J_pixel_ray.T
        innovation = pixel - predicted
        nis = innovation @ np.linalg.solve(S, innovation)
        if nis <= self.gate:
            self.correct(np.linalg.solve(S, H @ x.covariance).T, innovation, H)
        return nis

    def correct(self, K, innovation, H):
        x = self.x
        d = K @ innovation
        x.position = x.position + d[0:3]
        x.orientation = so3.multiply(x.orientation, so3.exp(d[3:6]))
        x.velocity = x.velocity + d[6:9]
        x.angular_velocity = x.angular_velocity + d[9:12]
        P = x.covariance - K @ H @ x.covariance
        x.covariance = 0.5 * (P + P.T)
