"""Curves of error over time: runs in turns, the time to an error, and their plot."""

import time

import numpy as np


def rest():
    """To be called before each timed run: threads of a library keep spinning for some milliseconds
    after a call, which then go off the next program's time."""
    time.sleep(0.3)


def time_to(curve, target):
    """The time to an error, between the measured ones by powers; the flag tells whether it is
    outside of them."""
    seconds, error = np.array([point[:2] for point in curve], float).T
    order = np.argsort(-error)
    at = np.exp(np.interp(-np.log(target), -np.log(error[order]), np.log(seconds[order])))
    return at, not error.min() <= target <= error.max()


def plot(curves, title, path, quantity, factor, target):
    """Draws all curves, as SVG or PNG by the name of the file; the same numbers give the same
    bytes."""
    import matplotlib

    matplotlib.use("svg" if path.endswith(".svg") else "agg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.hashsalt"] = "harmolux"
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    for (name, curve), marker in zip(curves.items(), "os^vDPX"):
        seconds, error = np.array([point[:2] for point in curve], float).T
        axes.loglog(seconds, factor * error, marker=marker, markersize=4, label=name)
    if target is not None:
        axes.axhline(factor * target, color="grey", linewidth=0.8, linestyle=":")
    axes.set(xlabel="time, s (start and compilation apart)", ylabel=quantity, title=title)
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None} if path.endswith(".svg") else None)
