"""The process of an estimator written in Python, started by the program: worker.py FILE.py CLASS. A JSON object a line,
over the socket that is the standard input; eval/python/python_messages.h has the messages."""
import importlib.util
import json
import os
import pathlib
import sys
import traceback

if __name__ == "__main__":  # the script's own folder, as if it had been started itself, and not this one
    sys.path[0] = str(pathlib.Path(sys.argv[1]).absolute().parent)

import numpy as np  # noqa: E402

from slammot import estimator as api  # noqa: E402


class NotAnEstimator(Exception):
    pass


def load(file, name):
    spec = importlib.util.spec_from_file_location("slammot_script", file)
    if spec is None:
        raise NotAnEstimator("is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses of the script look themselves up
    spec.loader.exec_module(module)
    found = getattr(module, name, None)
    if not (isinstance(found, type) and issubclass(found, api.Estimator)):
        raise NotAnEstimator(f"has no class {name} that derives from slammot.Estimator")
    if found.kind not in ("filter", "smoother"):
        raise NotAnEstimator(f"{name}.kind is filter or smoother, not {found.kind!r}")
    return found


def numbers(values, size, what):
    """A list of `size` numbers, None where one is not finite."""
    array = np.asarray(values, float).ravel()
    if array.size not in (size if isinstance(size, tuple) else (size,)):
        raise ValueError(f"{what} has {array.size} numbers, not {size}")
    listed = array.tolist()
    return listed if np.isfinite(array).all() else [x if np.isfinite(x) else None for x in listed]


def unless_none(values, size, what):
    return None if values is None else numbers(values, size, what)


def camera_of(message):
    mounted = {key: np.array(value) for key, value in message.get("T_C0_C", {}).items()}
    lens = {key: value for key, value in message.items() if key != "T_C0_C"}
    return api.Camera(**dict(lens, distortion=np.array(lens["distortion"], float)), **mounted)


def setup_of(message):
    initial = {key: np.array(value) for key, value in message["initial"].items()}
    sigmas = initial.pop("sigmas")
    known = message["known"]
    return api.Setup(camera=camera_of(message["camera"]), pixel_sigma=message["pixel_sigma"],
                     acceleration=message["acceleration"], angular_acceleration=message["angular_acceleration"],
                     prior=message["prior"], initial=api.CameraEstimate(covariance=np.diag(sigmas ** 2), **initial),
                     known=api.KnownLandmarks(np.array(known["tracks"], int),
                                              np.array(known["positions"], float).reshape(-1, 3),
                                              np.array(known["sigmas"], float)),
                     configuration=message["configuration"],
                     other_cameras=tuple(camera_of(other) for other in message["other_cameras"]),
                     p_static=dict(zip(message["p_static"]["tracks"], message["p_static"]["values"])))


def frame_of(message):
    others = message["other_views"]
    return api.Frame(message["frame"], message["timestamp"], np.array(message["tracks"], int),
                     np.array(message["pixels"], float).reshape(-1, 2), np.array(message["relative_sigmas"], float),
                     np.array(message["depths"], float).reshape(-1, 2),
                     api.OtherViews(np.array(others["tracks"], int), np.array(others["cameras"], int),
                                    np.array(others["pixels"], float).reshape(-1, 2)))


def camera_json(camera, timestamp):
    if not isinstance(camera, api.CameraEstimate):
        raise TypeError(f"a slammot.CameraEstimate is expected, not {type(camera).__name__}")
    orientation = numbers(camera.orientation, 4, "orientation")
    if not any(orientation):
        raise ValueError("orientation is a quaternion, not zero")
    return {"timestamp": timestamp if camera.timestamp is None else float(camera.timestamp),
            "position": numbers(camera.position, 3, "position"), "orientation": orientation,
            "velocity": numbers(camera.velocity, 3, "velocity"),
            "angular_velocity": numbers(camera.angular_velocity, 3, "angular_velocity"),
            "covariance": unless_none(camera.covariance, (36, 144), "covariance")}


def landmark_json(landmark):
    decision = landmark.decision_frame
    return {"track": int(landmark.track), "label": landmark.label, "first_frame": int(landmark.first_frame),
            "last_frame": int(landmark.last_frame), "decision_frame": None if decision is None else int(decision),
            "observations": int(landmark.observations), "position": numbers(landmark.position, 3, "position"),
            "position_covariance": unless_none(landmark.position_covariance, 9, "position_covariance"),
            "velocity": unless_none(landmark.velocity, 3, "velocity"),
            "velocity_covariance": unless_none(landmark.velocity_covariance, 9, "velocity_covariance")}


def report_json(report):
    return {"accepted": int(report.accepted), "rejected": int(report.rejected), "admitted": int(report.admitted),
            "state_size": int(report.state_size), "nis_sum": float(np.sum(report.nis)),
            "accepted_static": None if report.accepted_static is None else int(report.accepted_static),
            "joint_nis": None if report.joint_nis is None else float(report.joint_nis)}


class Session:
    def __init__(self, cls):
        self.cls = cls
        self.estimator = None
        self.timestamp = None

    def answer(self, message):
        if "setup" in message:
            self.estimator = self.cls(setup_of(message["setup"]), **message["options"])
            return {}
        if "frame" in message:
            return self.process(frame_of(message))
        if message["ask"] == "landmarks":
            return {"landmarks": [landmark_json(landmark) for landmark in self.estimator.landmarks()]}
        return {"cameras": [camera_json(camera, self.timestamp) for camera in self.estimator.smoothed()]}

    def process(self, frame):
        self.timestamp = frame.timestamp
        estimate = self.estimator.process(frame)
        camera, report = estimate if isinstance(estimate, tuple) else (estimate, None)
        measured = [landmark for landmark in self.estimator.landmarks() if landmark.last_frame == frame.index]
        return {"camera": camera_json(camera, frame.timestamp), "report": None if report is None else report_json(report),
                "landmarks": [landmark_json(landmark) for landmark in measured]}


def fault(error, file):
    """One line: file, line where the script stands, reason."""
    if isinstance(error, NotAnEstimator):
        return f"{file}: {error}"
    if isinstance(error, SyntaxError):
        return f"{error.filename}:{error.lineno}: {error.msg}"
    stands = [entry.lineno for entry in traceback.extract_tb(error.__traceback__)
              if os.path.abspath(entry.filename) == os.path.abspath(file)]
    place = f"{file}:{stands[-1]}" if stands else file
    return " ".join(f"{place}: {type(error).__name__}: {error}".split())


def main(file, name):
    socket = os.dup(0)  # before the script can read or print
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    lines, out = os.fdopen(socket, "rb"), os.fdopen(os.dup(socket), "wb", buffering=0)

    def say(json_object):
        out.write(json.dumps(json_object, separators=(",", ":")).encode() + b"\n")

    try:
        cls = load(file, name)
        say({"kind": cls.kind, "description": str(cls.description)})
        session = Session(cls)
    except BaseException as error:  # pylint: disable=broad-except
        say({"error": fault(error, file)})
        return
    for line in lines:
        try:
            say(session.answer(json.loads(line)))
        except api.Diverged as error:
            say({"diverged": " ".join(str(error).split())})
        except Exception as error:  # pylint: disable=broad-except
            say({"error": fault(error, file)})


if __name__ == "__main__":
    main(*sys.argv[1:])
