"""Images of a ROS 1 bag (a file) or a ROS 2 bag (its folder, SQLite or MCAP) as a folder that `slammot track` reads, with
their times (TUM's layout).

usage: bag_images.py BAG TOPIC FOLDER    then: slammot track FOLDER --camera CALIBRATION.yaml --output SEQUENCE

Asks for rosbags and OpenCV, which slammot does not: python3 -m pip install rosbags opencv-python
"""
import pathlib
import sys

import cv2
import numpy
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

CHANNELS = {"mono8": 1, "8UC1": 1, "mono16": 1, "16UC1": 1, "bgr8": 3, "rgb8": 3, "8UC3": 3, "bgra8": 4, "rgba8": 4}


def decoded(message):
    """The picture of a sensor_msgs/Image or CompressedImage, blue first."""
    if hasattr(message, "format"):
        return cv2.imdecode(message.data, cv2.IMREAD_UNCHANGED)
    if message.encoding not in CHANNELS:
        sys.exit(f"encoding {message.encoding} is none of {', '.join(CHANNELS)}")
    channels = CHANNELS[message.encoding]
    kind = numpy.dtype("u2" if "16" in message.encoding else "u1").newbyteorder(">" if message.is_bigendian else "<")
    rows = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)  # rows may be padded
    used = rows[:, :message.width * channels * kind.itemsize].copy().view(kind)
    picture = used.astype(kind.newbyteorder("=")).reshape(message.height, message.width, channels)
    return numpy.ascontiguousarray(picture[..., [2, 1, 0]]) if message.encoding.startswith("rgb") else picture


def of_topic(reader, topic):
    """Its connections; it may be mistyped, or of something else."""
    pictured = [c for c in reader.connections if c.msgtype.endswith(("/Image", "/CompressedImage"))]
    found = [c for c in pictured if c.topic == topic]
    return found or sys.exit(f"no images in {topic}; there are some in {', '.join(sorted({c.topic for c in pictured})) or 'no topic'}")


def write_images(reader, topic, folder):
    connections, times = of_topic(reader, topic), {}  # [ns] of the camera's clock: a bag is ordered by when messages came
    (folder / "rgb").mkdir(parents=True)
    for connection, _, data in reader.messages(connections=connections):
        message = reader.deserialize(data, connection.msgtype)
        stamp = message.header.stamp
        name = f"rgb/{len(times):06}.png"
        cv2.imwrite(str(folder / name), decoded(message))
        times[name] = stamp.sec * 10**9 + stamp.nanosec
    lines = [f"{t // 10**9}.{t % 10**9:09} {name}\n" for name, t in sorted(times.items(), key=lambda item: item[1])]
    (folder / "rgb.txt").write_text("".join(lines), encoding="utf-8")


def main(bag, topic, folder):
    try:
        with AnyReader([pathlib.Path(bag)], default_typestore=get_typestore(Stores.LATEST)) as reader:
            write_images(reader, topic, pathlib.Path(folder))
    except (OSError, AnyReaderError) as error:  # no bag, or a folder that is there
        sys.exit(f"bag_images.py: {error}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
