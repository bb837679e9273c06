"""An estimator written in Python: derive from Estimator, and name it to the program as `python:FILE.py:Class`.

Poses are T_WC. The error of a pose is [dr (W), dtheta (C, right: R_true = R_estimated Exp(dtheta))], as everywhere.
"""
from dataclasses import dataclass, field

import numpy as np


class Diverged(Exception):
    """The estimate is of no use any more. The run ends and keeps what was done."""


@dataclass(frozen=True)
class Camera:
    """`model` is one of those of docs/formats.md; the centre of the top-left pixel is (0, 0)."""
    model: str
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: np.ndarray

    position: np.ndarray = (0.0, 0.0, 0.0)          # in camera 0 [m]
    orientation: np.ndarray = (0.0, 0.0, 0.0, 1.0)  # to camera 0, quaternion x, y, z, w

    @property
    def matrix(self):
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class KnownLandmarks:
    """Known beforehand; they fix the scale. `sigmas` are of each axis [m]."""
    tracks: np.ndarray
    positions: np.ndarray
    sigmas: np.ndarray


@dataclass(frozen=True)
class Setup:
    """What an estimator may know before the first frame: never the truth."""
    camera: Camera
    pixel_sigma: float
    acceleration: float          # noise of the camera [m/s^2]
    angular_acceleration: float  # [rad/s^2]
    prior: dict                  # of landmarks: inverse_depth, inverse_depth_sigma, max_speed, ...
    initial: "CameraEstimate"    # before the first frame, covariance 12x12
    known: KnownLandmarks
    configuration: dict          # every configuration key and its value, as text
    other_cameras: tuple = ()    # Camera 1 and on of a rig; poses are those of camera 0
    p_static: dict = field(default_factory=dict)  # probability of rest from outside, by track; of others nothing is said


@dataclass(frozen=True)
class OtherViews:
    """Of the other cameras of a rig, by track and camera."""
    tracks: np.ndarray   # n numbers
    cameras: np.ndarray  # n numbers, from 1
    pixels: np.ndarray   # n x 2


@dataclass(frozen=True)
class Frame:
    index: int
    timestamp: float    # [s]
    tracks: np.ndarray  # n numbers, increasing
    pixels: np.ndarray  # n x 2
    relative_sigmas: np.ndarray  # n: the noise of a pixel is Setup.pixel_sigma times this
    depths: np.ndarray = None    # n x 2: depth along the optical axis and its sigma [m], 0 where none is measured
    other_views: OtherViews = None


@dataclass
class CameraEstimate:
    """`covariance` is 6x6 of the pose, 12x12 with both velocities, or None where it is not known."""
    position: np.ndarray
    orientation: np.ndarray = (0.0, 0.0, 0.0, 1.0)  # quaternion x, y, z, w
    covariance: np.ndarray = None
    velocity: np.ndarray = (0.0, 0.0, 0.0)          # W [m/s]
    angular_velocity: np.ndarray = (0.0, 0.0, 0.0)  # C [rad/s]
    timestamp: float = None                         # of the frame, if not given


@dataclass
class LandmarkEstimate:
    """After the newest frame. `last_frame` is that of its newest measurement."""
    track: int
    position: np.ndarray
    label: str = "unknown"  # or static, moving
    position_covariance: np.ndarray = None
    velocity: np.ndarray = None
    velocity_covariance: np.ndarray = None
    first_frame: int = 0
    last_frame: int = 0
    decision_frame: int = None
    observations: int = 0


@dataclass
class FrameReport:
    """What happened in a frame; `nis` are those of the accepted measurements, each on its own, `joint_nis` that of all of
    them together. Of what is None the run does not warn."""
    accepted: int = 0
    accepted_static: int = None  # of them those of static landmarks
    rejected: int = 0
    admitted: int = 0
    state_size: int = 0
    nis: np.ndarray = field(default_factory=lambda: np.zeros(0))
    joint_nis: float = None


class Estimator:
    kind = "filter"   # or smoother
    description = ""  # for tables

    def __init__(self, setup, **options):
        """`options` come from the configuration key python.options, as JSON."""
        raise NotImplementedError

    def process(self, frame):
        """The CameraEstimate after this Frame; or that and a FrameReport."""
        raise NotImplementedError

    def landmarks(self):
        """A LandmarkEstimate of every landmark in the state."""
        return []

    def smoothed(self):
        """A CameraEstimate of every frame, with its timestamp, after the last frame; of a smoother."""
        return []
