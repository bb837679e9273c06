"""python3 -m slammot.report frame FRAME.json: FRAME.pdf, the picture of a frame fit for a paper: the image with where landmarks were expected
and measured, the map from above and from the side in metres. All but the image are vectors, fonts are embedded.

Silent on success; one line on stderr and exit 2 for bad input, 1 for a missing package or a file that cannot be written.
"""
import pathlib
import sys
from dataclasses import dataclass

from .comparison import BadInput, NotMade, read_json
from .page import aside, made, one_line
from .study_axes import pyplot

FORMAT = "slammot-frame-1"
WIDTH = 7.16       # inches, two columns of a paper
TWO_SIGMA = 2.0
REGION_95 = 5.991464547107979 ** 0.5  # chi-square, two dimensions
LARGEST = 0.25     # half an axis in parts of the axes: a depth that is not known yet would cover them

# Okabe and Ito's, as frontend/rendering/marks.h.
NOT_FOUND, REJECTED, GREY, PALE = "#56B4E9", "#E69F00", "#969696", "#e1e1e1"


@dataclass
class Mark:
    colour: str
    marker: str
    filled: bool
    text: str


LABELS = {"static": Mark("#0072B2", "o", True, "static"), "unknown": Mark("#CC79A7", "s", False, "unknown"),
          "moving": Mark("#D55E00", "D", True, "moving, one second of it")}
MEASURED = {"accepted": ("+", "black", "measured"), "rejected": ("x", REJECTED, "measured, rejected"),
            "-": ("+", GREY, "measured, new")}
AXES = ("right [m]", "forward [m]", "up [m]")
VIEWS = {"from above": (0, 1), "from the side": (1, 2)}  # which axis is horizontal, which vertical


def mark(axis, points, label, colour=None, **more):
    style = LABELS[label]
    colour = colour or style.colour
    axis.plot([p[0] for p in points], [p[1] for p in points], style.marker, color=colour, markersize=2.6,
              markerfacecolor=colour if style.filled else "none", markeredgewidth=0.7, **more)


def cross(axis, points, measured):
    """Dark on light, so that it is seen on any image; it sticks out from under the mark of its landmark."""
    marker, colour, _ = MEASURED[measured]
    for stroke, width in (("white", 1.7), (colour, 0.7)):
        axis.plot([p[0] for p in points], [p[1] for p in points], marker, color=stroke, markersize=5.5, markeredgewidth=width)


def ellipse(axis, centre, covariance, scale, colour, largest):
    """x' C^-1 x = scale^2 around the centre; nothing where it is no ellipse, or too large."""
    import numpy as np
    from matplotlib.patches import Ellipse
    if any(v is None for row in covariance for v in row):
        return
    variances, directions = np.linalg.eigh(covariance)
    half = scale * np.sqrt(np.maximum(variances, 0.0))
    if half[1] < largest:
        angle = np.degrees(np.arctan2(directions[1, 1], directions[0, 1]))
        axis.add_patch(Ellipse(centre, 2 * half[1], 2 * half[0], angle=angle, fill=False, edgecolor=colour, linewidth=0.7))


def show_image(axis, file):
    import matplotlib.image
    if file is None:
        axis.set_facecolor(PALE)
        return
    try:
        image = matplotlib.image.imread(file)
    except (OSError, ValueError) as error:
        raise BadInput(f"{file}: {error}") from error
    axis.imshow(image, cmap="gray", vmin=0, vmax=255 if image.dtype.kind == "u" else 1, interpolation="nearest")


def draw_image(axis, frame, camera):
    """`camera`: one of those of the frame, or the frame itself for camera 0."""
    show_image(axis, camera["image"])
    for measured in MEASURED:
        cross(axis, [z["pixel"] for z in camera["measurements"] if z["measured"] == measured], measured)
    for p in camera["predictions"]:
        colour = NOT_FOUND if p["measured"] == "-" else LABELS[p["label"]].colour
        ellipse(axis, p["pixel"], p["S"], TWO_SIGMA, colour, LARGEST * frame["width"])
        mark(axis, [p["pixel"]], p["label"], colour)
    predicted = {p["track"] for p in camera["predictions"]}
    labels = {landmark["track"]: landmark["label"] for landmark in frame["landmarks"]}
    for z in camera["measurements"]:
        if z["track"] not in predicted and z["track"] in labels:
            mark(axis, [z["pixel"]], labels[z["track"]])
    axis.set(xlim=(-0.5, frame["width"] - 0.5), ylim=(frame["height"] - 0.5, -0.5), xticks=[], yticks=[], aspect="equal")
    axis.grid(False)
    for spine in axis.spines.values():
        spine.set_visible(False)


def draw_landmarks(axis, frame, flat, largest):
    import numpy as np
    resting = [flat(landmark["position"]) for landmark in frame["landmarks"]
               if not landmark["measured"] and landmark["label"] == "static"]
    axis.plot([p[0] for p in resting], [p[1] for p in resting], ".", color=GREY, markersize=2)
    for landmark in frame["landmarks"]:
        if not landmark["measured"]:
            continue  # of what may move nobody knows where it is now
        colour, at = LABELS[landmark["label"]].colour, flat(landmark["position"])
        covariance = [flat(row) for row in flat(landmark["covariance"])]
        ellipse(axis, at, covariance, REGION_95, colour, largest)
        mark(axis, [at], landmark["label"])
        if landmark["label"] == "moving" and None not in landmark["velocity"]:
            axis.plot(*zip(at, np.add(at, flat(landmark["velocity"]))), color=colour, linewidth=0.7)


def draw_camera(axis, frame, flat, largest):
    import numpy as np
    for name, colour in (("truth", GREY), ("path", "black")):
        if frame[name]:
            axis.plot(*zip(*map(flat, frame[name])), color=colour, linewidth=0.9)
    camera = frame["camera"]
    rotation, position = np.array(camera["rotation"]), np.array(camera["position"])
    for side in (-0.5, 0.5):  # a wedge that opens to where it looks
        corner = position + rotation @ (0.12 * largest * np.array([side, side, 1.0]))
        axis.plot(*zip(flat(position), flat(corner)), color="black", linewidth=1.2)
    ellipse(axis, flat(camera["position"]), [flat(row) for row in flat(camera["covariance"])], REGION_95, "black", largest)


def draw_map(axis, frame, view):
    across, upwards = VIEWS[view]
    lower, upper = frame["shown"]["lower"], frame["shown"]["upper"]

    def flat(three):
        return three[across], three[upwards]

    largest = LARGEST * max(u - l for l, u in zip(flat(lower), flat(upper)))
    draw_landmarks(axis, frame, flat, largest)
    draw_camera(axis, frame, flat, largest)
    axis.set(title=view, xlabel=AXES[across], ylabel=AXES[upwards], xlim=(lower[across], upper[across]),
             ylim=(lower[upwards], upper[upwards]), aspect="equal")


def legend_entries():
    """(handle, text) of all that is drawn, whether or not this frame has one."""
    from matplotlib.lines import Line2D

    def of_mark(marker, colour, filled=True, size=4, width=0.8):
        return Line2D([], [], linestyle="", marker=marker, color=colour, markersize=size, markeredgewidth=width,
                      markerfacecolor=colour if filled else "none")

    entries = [(of_mark(m.marker, m.colour, m.filled), m.text) for m in LABELS.values()]
    entries.append((of_mark("o", NOT_FOUND), "predicted, not measured"))
    entries += [(of_mark(marker, colour, size=5.5, width=1.0), text) for marker, colour, text in MEASURED.values()]
    entries.append((of_mark(".", GREY), "static, not measured now"))
    entries += [(Line2D([], [], color=c), text) for c, text in (("black", "camera"), (GREY, "true camera"))]
    entries.append((of_mark("o", LABELS["static"].colour, False, size=7.5), "2σ; on the map 95%"))
    return entries


@dataclass
class Layout:
    """In inches, from the lower left: where the image, the two maps and the legend stand. Both maps have one scale."""
    size: tuple
    boxes: dict  # name to (left, bottom, width, height)
    columns: int  # of the legend


LABEL, TITLE = 0.42, 0.24  # beside and below a map; above it
GAP = 0.04                 # between images


def beside(aspect, right, forward, up):
    """Maps above each other, beside the image and the legend."""
    image, width = 4.15, WIDTH - 4.15 - 0.1 - LABEL - 0.1
    scale = min(width / max(right, forward), 3.4 / (forward + up))
    legend = 0.95
    height = max(image * aspect + 0.1 + legend, (forward + up) * scale + 2 * (LABEL + TITLE))
    left = image + 0.1 + LABEL
    above = height - TITLE - forward * scale
    return Layout((WIDTH, height), {
        "image": (0.0, height - image * aspect, image, image * aspect),
        "from above": (left, above, right * scale, forward * scale),
        "from the side": (left, above - LABEL - TITLE - up * scale, forward * scale, up * scale),
        "legend": (0.0, height - image * aspect - 0.1 - legend, image, legend)}, 3)


def below(aspect, right, forward, up):
    """Maps beside each other, between a wide image and the legend."""
    scale = min((WIDTH - 2 * LABEL - 0.2) / (right + forward), 3.0 / max(forward, up))
    image, legend, tallest = WIDTH * aspect, 0.75, max(forward, up) * scale
    height = image + TITLE + tallest + LABEL + legend
    foot = height - image - TITLE - tallest
    return Layout((WIDTH, height), {
        "image": (0.0, height - image, WIDTH, image),
        "from above": (LABEL, foot, right * scale, forward * scale),
        "from the side": (2 * LABEL + right * scale + 0.1, foot, forward * scale, up * scale),
        "legend": (0.0, 0.0, WIDTH, legend)}, 4)


def cameras_of(frame):
    """Camera 0 is the frame itself; earlier builds wrote no others."""
    return [frame, *frame.get("other_cameras", ())]


def layout(frame):
    """Images of several cameras are side by side, wide ones below each other."""
    extent = [u - l for l, u in zip(frame["shown"]["lower"], frame["shown"]["upper"])]
    aspect, count = frame["height"] / frame["width"], len(cameras_of(frame))
    across, down = (1, count) if aspect < 0.5 else (count, 1)
    aspect *= down / across
    placed = (below if aspect < 0.5 or count > 1 else beside)(aspect, *extent)
    left, foot, width, height = placed.boxes.pop("image")
    wide, tall = (width - GAP * (across - 1)) / across, (height - GAP * (down - 1)) / down
    for k in range(count):
        column, row = (k, 0) if down == 1 else (0, down - 1 - k)
        placed.boxes[k] = (left + column * (wide + GAP), foot + row * (tall + GAP), wide, tall)
    return placed


def draw(plt, frame):
    plt.rcParams.update({"font.size": 7, "axes.titlesize": 8, "axes.linewidth": 0.6, "grid.linewidth": 0.4})
    placed = layout(frame)
    figure = plt.figure(figsize=placed.size)
    width, height = placed.size
    axes = {name: figure.add_axes((x / width, y / height, w / width, h / height))
            for name, (x, y, w, h) in placed.boxes.items()}
    cameras = cameras_of(frame)
    for k, camera in enumerate(cameras):
        draw_image(axes[k], frame, camera)
        if len(cameras) > 1:
            axes[k].annotate(f"camera {k}" + ("" if camera["image"] else ": no image"), (0, 1), (3, -3), xycoords="axes fraction",
                             textcoords="offset points", va="top", fontsize=6.5, bbox={"facecolor": "white", "edgecolor": "none", "pad": 2})
    for view in VIEWS:
        draw_map(axes[view], frame, view)
    handles, texts = zip(*legend_entries())
    axes["legend"].axis("off")
    axes["legend"].legend(handles, texts, loc="upper left", ncol=placed.columns, borderaxespad=0.0, fontsize=6.5,
                          columnspacing=0.8, handlelength=1.3, handletextpad=0.6)
    return figure


def figure_of(folder, name):
    plt = pyplot()
    figure = draw(plt, read_json(folder / name, FORMAT))
    file = (folder / name).with_suffix(".pdf")
    with aside(file) as unfinished:
        figure.savefig(unfinished, dpi=300, metadata={"CreationDate": None})
    plt.close(figure)


def main():
    if len(sys.argv) != 2:
        print("usage: frame_figure FRAME.json", file=sys.stderr)
        return 2
    data = pathlib.Path(sys.argv[1])
    try:
        made(lambda folder: figure_of(folder, data.name), data.parent, data.name)
    except (BadInput, NotMade, OSError) as error:
        print(f"frame_figure: {one_line(error)}", file=sys.stderr)
        return 2 if isinstance(error, BadInput) else 1
    return 0
