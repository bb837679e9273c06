"""The pictures that `slammot compare --pictures` leaves in a run's folder, carried inside the page."""
import base64


def of_runs(output, runs):
    """[(run, [(frame, data URI), ...])] of the runs that have pictures."""
    found = []
    for run in runs:
        files = sorted((output / run.label / "pictures" / "slider").glob("*.jpg"))
        if files:
            found.append((run, [(int(file.stem), carried(file)) for file in files]))
    return found


def carried(file):
    return "data:image/jpeg;base64," + base64.b64encode(file.read_bytes()).decode("ascii")
