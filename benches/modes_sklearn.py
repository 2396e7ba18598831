"""Modes of 200 random shapes beside scikit-learn's PCA of the same coefficients.

    cargo build --release
    python3 -m venv venv && . venv/bin/activate && pip install scikit-learn
    python benches/modes_sklearn.py [target/release/harmolux]

Draws the shapes, puts their files into one table in the layout of `fit --table`, and prints the
largest differences of mean, components, scores and explained variance; all must be below 1e-10.
"""

import csv
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from common import parser
from sklearn.decomposition import PCA

COUNT, DEGREE = 200, 6


def main():
    tool = parser(__doc__).parse_args().tool
    with tempfile.TemporaryDirectory() as folder:

        def run(*words):
            done = subprocess.run([tool, *words], cwd=folder, check=True, capture_output=True)
            return done.stdout

        law = ["--power-law", "rms=0.1,exponent=2", "-l", str(DEGREE), "--seed", "1"]
        run("random", *law, "--count", str(COUNT), "-o", "shapes")
        files = sorted(Path(folder, "shapes").iterdir(), key=lambda file: int(file.stem))
        names, rows = table(files)
        with open(Path(folder, "shapes.csv"), "w", newline="") as file:
            csv.writer(file).writerows([names, *rows])
        found = json.loads(run("modes", "shapes.csv", "--modes", "1000", "-o", "modes", "--json"))
        data = np.array([row[3:] for row in rows], float)
        pca = PCA(svd_solver="full").fit(data)
        compare(found, Path(folder, "modes"), data, pca)


def table(files):
    """Returns header and rows of a table of shapes."""
    columns = [f"{cs}{l}_{m}_m" for l, m, cs in places()]
    rows = [[file.stem, "4pi", "1", *coefficients(file)] for file in files]
    return ["name", "normalisation", "csphase", *columns], rows


def places():
    every = [(l, m, cs) for l in range(DEGREE + 1) for m in range(l + 1) for cs in "CS"]
    return [(l, m, cs) for l, m, cs in every if not (m == 0 and cs == "S")]


def coefficients(file):
    """Reads the coefficients of a text, as written, in the order of the places."""
    read = {}
    for line in file.read_text().splitlines():
        if not line.startswith("#"):
            l, m, c, s = line.split(", ")
            read[int(l), int(m), "C"], read[int(l), int(m), "S"] = c, s
    return [read[place] for place in places()]


def compare(found, folder, data, pca):
    modes = found["modes"]
    deviations = np.array([mode["deviation"] for mode in modes])
    scores = np.array([mode["scores"] for mode in modes]).T
    mode = lambda k: np.array(coefficients(folder / f"mode{k + 1}.txt"), float)
    components = np.array([mode(k) / deviations[k] for k in range(len(modes))])
    theirs = pca.components_[: len(modes)]
    # The sign of a component is free.
    sign = np.sign(np.sum(components * theirs, axis=1))
    variance = pca.explained_variance_[: len(modes)]
    mean = np.array(coefficients(folder / "mean.txt"), float)
    differences = {
        "mean, m": np.abs(mean - pca.mean_),
        "components": np.abs(components - sign[:, None] * theirs),
        "scores, m": np.abs(scores - sign * pca.transform(data)[:, : len(modes)]),
        "explained variance, relative": np.abs(deviations**2 / variance - 1),
        "explained share": np.abs(
            np.array([mode["explained"] for mode in modes])
            - pca.explained_variance_ratio_[: len(modes)]
        ),
    }
    print(f"{len(data)} shapes of degree {DEGREE}, {len(modes)} modes")
    for name, difference in differences.items():
        print(f"{name:<30} {difference.max():.1e}")
        assert difference.max() <= 1e-10, name


if __name__ == "__main__":
    main()
