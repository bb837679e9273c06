"""What moved, by the true poses: the residual of the one point at rest that explains a track best.

A point at rest is seen within the noise; what no such point explains has moved, or the track has jumped. What moves so that some
point at rest looks the same (a car ahead at constant speed) cannot be told, with true poses neither.
"""
import csv

import numpy
import yaml
from scipy.optimize import least_squares


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def rotation(x, y, z, w):
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class TrueCameras:
    """Poses by frame, and the pixel that each has of a point (W). Lenses: pinhole and radtan."""

    def __init__(self, sequence):
        camera = yaml.safe_load((sequence / "sequence.yaml").read_text(encoding="utf-8"))["camera"]
        if camera["model"] not in ("pinhole", "radtan"):
            raise ValueError(f"{sequence}: the lens {camera['model']} is not known here")
        self.focal = numpy.array([camera["fx"], camera["fy"]])
        self.centre = numpy.array([camera["cx"], camera["cy"]])
        self.lens = [*camera["distortion"], 0.0, 0.0, 0.0, 0.0, 0.0][:5]
        truth = [line.split() for line in (sequence / "groundtruth.tum").read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        by_time = {round(float(row[0]), 6): [float(v) for v in row[1:]] for row in truth}
        self.poses = {}
        for row in rows_of(sequence / "frames.csv"):
            pose = by_time.get(round(float(row["timestamp"]), 6))
            if pose:
                self.poses[int(row["frame"])] = (rotation(*pose[3:]), numpy.array(pose[:3]))

    def pixel(self, frame, point):
        R, t = self.poses[frame]
        x, y, z = R.T @ (point - t)
        x, y = numpy.array([x, y]) / max(z, 1e-3)  # what is behind the camera explains nothing, in finite numbers
        k1, k2, p1, p2, k3 = self.lens
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        bent = numpy.array([x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y])
        return self.focal * bent + self.centre

    def ray(self, frame, pixel):
        """Without the lens: only where a search begins."""
        return self.poses[frame][0] @ numpy.append((pixel - self.centre) / self.focal, 1.0)

    def residual(self, track):
        """[px], root mean square of both coordinates over a track of (frame, pixel)."""
        frame, pixel = track[0]

        def differences(point):
            return numpy.concatenate([self.pixel(f, point) - z for f, z in track])

        fits = [least_squares(differences, self.poses[frame][1] + depth * self.ray(frame, pixel)) for depth in (0.3, 1.0, 5.0, 30.0)]
        return (2.0 * min(fit.cost for fit in fits) / len(track) / 2.0) ** 0.5


def residuals(sequence, last_frame, shortest):
    """track: residual [px], of those measured at least so often up to the last frame."""
    cameras = TrueCameras(sequence)
    tracks = {}
    for z in rows_of(sequence / "observations.csv"):
        frame = int(z["frame"])
        if frame <= last_frame and frame in cameras.poses:
            tracks.setdefault(z["track"], []).append((frame, numpy.array([float(z["u"]), float(z["v"])])))
    return {name: cameras.residual(track) for name, track in tracks.items() if len(track) >= shortest}
