"""Where runs failed, marked in figures against time."""


def failure_frame(run):
    """The frame at which the run failed or diverged, and what it did."""
    if run.divergence is not None:
        return run.divergence["frame"], "diverged"
    return run.failed_at, "failed"


def failure_time(run):
    """The time of this frame; of one without a pose, that of the last pose."""
    times, frame = run.series.get("timestamp", []), failure_frame(run)[0]
    if frame is None or not times:
        return None
    frames = run.series.get("frame", [])
    return next((t for t, f in zip(times, frames) if f >= frame), times[-1])


def failures(runs, start):
    """Layout of a figure against time: a cross of the run's colour upon the time axis, whatever the scale hides of its line."""
    marks, shapes = [], []
    for run in runs:
        time = failure_time(run)
        if time is None:
            continue
        frame, what = failure_frame(run)
        # Runs that failed at one time stand above each other.
        height = 13 * sum(mark["x"] == time - start for mark in marks)
        marks.append({"x": time - start, "y": 0, "yref": "paper", "text": "<b>✕</b>", "showarrow": False, "yanchor": "middle", "yshift": height,
                      "font": {"color": run.colour, "size": 17}, "hovertext": f"{run.name} {what} at frame {frame}"})
        shapes.append({"type": "line", "xref": "x", "yref": "paper", "x0": time - start, "x1": time - start, "y0": 0, "y1": 1,
                       "line": {"color": run.colour, "width": 1, "dash": "dot"}, "opacity": 0.5})
    return {"annotations": marks, "shapes": shapes} if marks else {}
