"""Rotations: quaternions x, y, z, w; the perturbation stands on the right, R Exp(dtheta). As models/so3.h."""
import numpy as np


def hat(a):
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def exp(theta):
    """The quaternion of a rotation vector [rad]."""
    half = 0.5 * np.linalg.norm(theta)
    return np.append(0.5 * np.sinc(half / np.pi) * np.asarray(theta), np.cos(half))


def log(q):
    """The rotation vector [rad] of a unit quaternion, of length at most pi."""
    q = np.asarray(q) if q[3] >= 0 else -np.asarray(q)
    norm = np.linalg.norm(q[:3])
    return q[:3] * (2.0 * np.arctan2(norm, q[3]) / norm if norm > 0.0 else 2.0)


def multiply(p, q):
    """p q, of unit length."""
    product = np.append(p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3]), p[3] * q[3] - np.dot(p[:3], q[:3]))
    return product / np.linalg.norm(product)


def conjugate(q):
    return np.asarray(q) * [-1.0, -1.0, -1.0, 1.0]


def matrix(q):
    v = hat(q[:3])
    return np.eye(3) + 2.0 * q[3] * v + 2.0 * v @ v


def right_jacobian(theta):
    """J with Exp(theta + d) = Exp(theta) Exp(J d) to first order."""
    t = np.linalg.norm(theta)
    w = hat(theta)
    if t < 1e-4:
        return np.eye(3) - 0.5 * w + w @ w / 6.0
    return np.eye(3) - 2.0 * (np.sin(t / 2) / t) ** 2 * w + (t - np.sin(t)) / t ** 3 * w @ w
