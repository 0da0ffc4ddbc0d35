"""Writes small spaces, and the dots of their Vietoris-Rips filtrations by two other programs.

In: gudhi, ripser, numpy and scipy (`pip install gudhi ripser numpy scipy`).
Out: beside this file, for each space NAME.csv, what `hopes compute` reads, and NAME.json: its arguments, and all dots
as [birth, death] in radii, sorted; the death of a cycle that never dies is null.

The dots are those of GUDHI's Rips complex, which computes in doubles. Those with less persistence than 1e-9 of their
death are left out. Ripser, which computes in floats of four bytes, must have the same, or nothing is written: that is
up to 2e-5, without dots of less persistence than 1e-5 of their death.

Lengths are computed of what is written, not of what was rounded.
"""

import itertools
import json
import math
import warnings
from pathlib import Path

import gudhi
import numpy as np
import ripser
from scipy.sparse.csgraph import shortest_path
from scipy.spatial.distance import cdist, pdist, squareform

HERE = Path(__file__).parent
EARTH_RADIUS = 6_371_008.8
INFINITE = math.inf
CHANCE = np.random.default_rng(17)
TAU = 2 * np.pi


# Distances of points


def angular(points):
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    return 2 * np.arcsin(np.minimum(squareform(pdist(directions)) / 2, 1))


def haversine(points):
    longitude, latitude = np.radians(points).T
    half = lambda angles: np.sin((angles[:, None] - angles[None, :]) / 2) ** 2
    cosines = np.cos(latitude)[:, None] * np.cos(latitude)[None, :]
    return 2 * EARTH_RADIUS * np.arcsin(np.minimum(np.sqrt(half(latitude) + cosines * half(longitude)), 1))


METRICS = {
    "euclidean": lambda points: cdist(points, points),
    "manhattan": lambda points: cdist(points, points, "cityblock"),
    "chebyshev": lambda points: cdist(points, points, "chebyshev"),
    "angular": angular,
    "haversine": haversine,
}


# Other programs


def by_gudhi(distances):
    finite = distances[np.isfinite(distances)]
    rips = gudhi.RipsComplex(distance_matrix=distances, max_edge_length=float(finite.max(initial=0)))
    tree = rips.create_simplex_tree(max_dimension=2)
    tree.compute_persistence(homology_coeff_field=2, min_persistence=0, persistence_dim_max=True)
    return tree.persistence_intervals_in_dimension(1).reshape(-1, 2) / 2


def by_ripser(distances):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        dots = ripser.ripser(distances, maxdim=1, distance_matrix=True)["dgms"][1].reshape(-1, 2) / 2
    return dots[np.isfinite(dots[:, 0])]


def clear(dots, least):
    """Those beyond the diagonal, sorted."""
    return sorted((birth, death) for birth, death in dots.tolist() if math.isinf(death) or death - birth > least * death)


def checked(name, distances):
    exact = by_gudhi(distances)
    one, other = (np.array(clear(dots, 1e-5)).reshape(-1, 2) for dots in (exact, by_ripser(distances)))
    one = np.array(sorted(one.astype("f4").tolist())).reshape(-1, 2)
    if one.shape != other.shape or not np.allclose(one, other, rtol=2e-5, atol=0):
        raise SystemExit(f"{name}: GUDHI has {one.tolist()}, Ripser has {other.tolist()}")
    return [[birth, None if math.isinf(death) else death] for birth, death in clear(exact, 1e-9)]


# Files


def text(value):
    short = f"{value:g}"
    return short if float(short) == value else repr(float(value))


def write(name, arguments, rows, distances):
    (HERE / f"{name}.csv").write_text("".join(",".join(map(text, row)) + "\n" for row in rows))
    dots = checked(name, distances)
    answer = "{" + f'"arguments": {json.dumps(arguments)},\n"dots": {json.dumps(dots)}' + "}\n"
    (HERE / f"{name}.json").write_text(answer)
    print(f"{name}: {len(distances)} points, {len(dots)} dots")


def points(name, metric, array, digits=5):
    """Points, rounded unless `digits` is None."""
    array = np.asarray(array, dtype=float)
    if digits is not None:
        array = np.array([[float(f"{value:.{digits}g}") for value in row] for row in array])
    write(name, f"--metric {metric}", array, METRICS[metric](array))


def matrix(name, form, distances, digits=4):
    """Distances, rounded unless `digits` is None."""
    distances = np.array(distances, dtype=float)
    if digits is not None:
        distances = np.array([[float(f"{value:.{digits}g}") for value in row] for row in distances])
    assert (distances == distances.T).all() and (distances.diagonal() == 0).all()
    count = len(distances)
    if form == "sparse":
        pairs = itertools.combinations(range(count), 2)
        rows = [(i, j, distances[i, j]) for i, j in pairs if np.isfinite(distances[i, j])]
    elif form == "lower":
        rows = [distances[i, :i] for i in range(1, count)]
    else:
        rows = distances
    write(name, f"--metric matrix --distances {form}", rows, distances)


# Spaces


def ring(count, noise):
    angle, radius = CHANCE.uniform(0, TAU, count), 1 + CHANCE.uniform(-noise, noise, count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def polygon(count):
    angle = TAU * np.arange(count) / count
    return np.column_stack([np.cos(angle), np.sin(angle)])


def grid(side, dimension):
    return np.array(list(itertools.product(range(side), repeat=dimension)), dtype=float)


def trefoil(count):
    t = CHANCE.uniform(0, TAU, count)
    knot = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    return knot + CHANCE.uniform(-0.1, 0.1, knot.shape)


def torus(count):
    u, v = CHANCE.uniform(0, TAU, (2, count))
    radius = 1 + 0.4 * np.cos(v)
    return np.column_stack([radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v)])


def linked_rings(count):
    flat = np.column_stack([ring(count, 0.05), CHANCE.uniform(-0.05, 0.05, count)])
    return np.vstack([flat, flat[:, [0, 2, 1]] + [1, 0, 0]])


def euclidean():
    uniform = CHANCE.random
    points("ring", "euclidean", ring(100, 0.1))
    points("square_uniform", "euclidean", uniform((150, 2)))
    points("cube_uniform", "euclidean", uniform((120, 3)))
    points("cube5", "euclidean", uniform((100, 5)), 4)
    points("gauss20", "euclidean", CHANCE.normal(size=(60, 20)), 3)
    points("trefoil", "euclidean", trefoil(140))
    points("torus", "euclidean", torus(150))
    sphere = CHANCE.normal(size=(100, 3))
    points("sphere", "euclidean", sphere / np.linalg.norm(sphere, axis=1, keepdims=True))
    points("linked_rings", "euclidean", linked_rings(60))
    points("one_dimension", "euclidean", uniform((80, 1)))
    points("line_in_space", "euclidean", np.outer(CHANCE.integers(0, 99, 60), [1, 2, 3]), None)
    points("lattice2", "euclidean", grid(12, 2), None)
    points("lattice3", "euclidean", grid(5, 3), None)
    points("lattice4_tenths", "euclidean", grid(3, 4) / 10, None)
    points("triangular_lattice", "euclidean", grid(10, 2) @ [[1, 0], [0.5, math.sqrt(0.75)]], None)
    points("polygon60", "euclidean", polygon(60), None)
    points("polygon21_and_centre", "euclidean", np.vstack([polygon(21), np.zeros((1, 2))]), None)
    points("duplicates", "euclidean", np.vstack([half := ring(50, 0.1), half]))
    points("one_position", "euclidean", np.ones((20, 3)))
    points("integers3", "euclidean", CHANCE.integers(0, 7, (120, 3)), None)
    points("cross_polytope10", "euclidean", np.vstack([np.eye(10), -np.eye(10)]), None)
    points("simplex20", "euclidean", np.eye(20), None)
    points("tiny_far", "euclidean", np.column_stack([ring(60, 0.1), uniform(60)]) * 1e-3 + 1e6, 12)
    points("scales", "euclidean", ring(100, 0.2) * 10.0 ** -CHANCE.integers(0, 5, (100, 1)))


def other_metrics():
    uniform = CHANCE.random
    points("manhattan_lattice", "manhattan", grid(10, 2), None)
    points("manhattan_uniform", "manhattan", uniform((100, 3)))
    points("manhattan_integers", "manhattan", CHANCE.integers(0, 5, (100, 4)), None)
    points("chebyshev_lattice", "chebyshev", grid(4, 3), None)
    points("chebyshev_uniform", "chebyshev", uniform((120, 2)))
    points("chebyshev_integers", "chebyshev", CHANCE.integers(0, 12, (100, 5)), None)
    points("angular_gauss3", "angular", CHANCE.normal(size=(100, 3)))
    points("angular_gauss20", "angular", CHANCE.normal(size=(40, 20)), 3)
    vectors = CHANCE.integers(-2, 3, (90, 3))
    points("angular_multiples", "angular", vectors[np.any(vectors != 0, axis=1)], None)
    latitude = np.degrees(np.arcsin(CHANCE.uniform(-1, 1, 120)))
    points("haversine_world", "haversine", np.column_stack([CHANCE.uniform(-180, 180, 120), latitude]))
    polar = np.column_stack([CHANCE.uniform(-180, 540, 60), CHANCE.uniform(80, 85, 60)])
    points("haversine_pole", "haversine", polar)
    city = ring(80, 0.1) * [0.02, 0.01] + [179.99, 48.2]
    points("haversine_city", "haversine", city, 8)


def graph(count, reach):
    lengths = squareform(pdist(ring(count, 0.3)))
    return np.where(lengths < reach, lengths, 0)


def symmetric(distances):
    upper = np.triu(distances, 1)
    return upper + upper.T


def matrices():
    matrix("no_triangle_inequality", "full", symmetric(CHANCE.uniform(0, 1, (50, 50))), 3)
    matrix("small_integers", "full", symmetric(CHANCE.integers(1, 6, (50, 50))), None)
    matrix("all_equal", "full", symmetric(np.ones((30, 30))), None)
    zeros = symmetric(CHANCE.integers(0, 4, (40, 40)))
    matrix("zeros", "full", zeros, None)
    twins = np.repeat(np.repeat(symmetric(CHANCE.integers(1, 9, (25, 25))), 2, axis=0), 2, axis=1)
    matrix("twins", "lower", twins, None)
    strings = grid(2, 6)
    matrix("hamming_cube6", "lower", cdist(strings, strings, "cityblock"), None)
    strings = CHANCE.integers(0, 2, (80, 16))
    matrix("hamming16", "lower", cdist(strings, strings, "cityblock"), None)
    hops = shortest_path(graph(90, 0.45), directed=False, unweighted=True)
    matrix("hops", "lower", hops, None)
    roads = shortest_path(graph(60, 0.5), directed=False)
    matrix("roads", "full", np.minimum(roads, roads.T))
    apart = symmetric(CHANCE.uniform(1, 2, (48, 48)))
    apart[:24, 24:] = apart[24:, :24] = INFINITE
    matrix("never_joined", "full", apart)
    sometimes = symmetric(np.where(CHANCE.random((50, 50)) < 0.3, INFINITE, CHANCE.uniform(0, 1, (50, 50))))
    matrix("some_infinite", "lower", sometimes, 3)
    lengths = squareform(pdist(ring(70, 0.3)))
    matrix("sparse_ring", "sparse", np.where(lengths < 0.5, lengths, INFINITE))
    tour = np.abs(np.subtract.outer(np.arange(24), np.arange(24)))
    cycle = np.where(np.isin(tour, (1, 23)), 1, INFINITE)
    np.fill_diagonal(cycle, 0)
    matrix("sparse_cycle", "sparse", cycle, None)
    crossing = symmetric(np.where(CHANCE.random((40, 40)) < 0.15, CHANCE.integers(1, 4, (40, 40)), INFINITE))
    np.fill_diagonal(crossing, 0)
    matrix("sparse_random", "sparse", crossing, None)
    wrapped = np.abs(grid(9, 2)[:, None] - grid(9, 2)[None, :])
    matrix("flat_torus", "lower", np.minimum(wrapped, 9 - wrapped).sum(axis=2), None)


if __name__ == "__main__":
    euclidean()
    other_metrics()
    matrices()
