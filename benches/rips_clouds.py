"""The clouds of rips.py, seeded: which there are, and how they are made.

In: for `write_cloud` numpy and scipy, which the virtual environment of rips.py has.
Out: files under target/rips/clouds: points as NPY, the lower triangle of their distances in Ripser's binary form, and
the whole matrix as NPY, in floats of four bytes.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from peers import ROOT

WORK = ROOT / "target" / "rips"
FAR = 1e6  # the distance of places without a road between them


@dataclass(frozen=True)
class Cloud:
    shape: str
    points: int

    @property
    def name(self) -> str:
        return f"{self.shape.replace(':', '')}-{self.points}"

    @property
    def is_alone(self) -> bool:
        """Too large for a matrix."""
        return self.points > 4096

    @property
    def is_matrix(self) -> bool:
        return self.shape.partition(":")[0] in MATRICES

    @property
    def ours(self) -> Path:
        return self.lower if self.is_matrix else WORK / "clouds" / f"{self.name}.npy"

    @property
    def lower(self) -> Path:
        return WORK / "clouds" / f"{self.name}.bin"

    @property
    def square(self) -> Path:
        return WORK / "clouds" / f"{self.name}.square.npy"


CLOUDS = (
    *(Cloud("circle", n) for n in (500, 1000)),
    *(Cloud("wheel3", n) for n in (1000, 2000)),
    Cloud("trefoil", 1000),
    Cloud("sphere", 2000),
    *(Cloud("torus", n) for n in (1000, 2000)),
    *(Cloud(f"cube:{d}", n) for d in (2, 3) for n in (500, 1000, 2000)),
    *(Cloud(f"cube:{d}", 1000) for d in (20, 100)),
    *(Cloud(shape, 1000) for shape in ("delay:20", "hops", "roads", "lattice:3", "hamming:16")),
    Cloud("random", 200),
    Cloud("cube:3", 16000),
)
QUICK = (Cloud("circle", 500), Cloud("cube:3", 500), Cloud("hamming:16", 300), Cloud("random", 100))


def circle(chance: Any, n: int, _: int) -> Any:
    """Radius 1, radial noise of up to 0.1."""
    import numpy as np

    angle, radius = chance.uniform(0, math.tau, n), 1 + chance.uniform(-0.1, 0.1, n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def wheel3(chance: Any, n: int, _: int) -> Any:
    """A wheel of seven spokes, bent into space, with noise."""
    import numpy as np

    pick = chance.uniform(0, math.tau + 7, n)
    spoke, along = np.divmod(pick - math.tau, 1)
    on_rim = pick < math.tau
    angle, radius = np.where(on_rim, pick, math.tau * spoke / 7), np.where(on_rim, 1, along)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return np.column_stack([x, y, 0.5 * x * x - 0.3 * y]) + chance.uniform(-0.05, 0.05, (n, 3))


def trefoil(chance: Any, n: int, _: int) -> Any:
    """A knot with noise."""
    import numpy as np

    t = chance.uniform(0, math.tau, n)
    knot = [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)]
    return np.column_stack(knot) + chance.uniform(-0.1, 0.1, (n, 3))


def sphere(chance: Any, n: int, _: int) -> Any:
    import numpy as np

    points = chance.normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def torus(chance: Any, n: int, _: int) -> Any:
    """Radii 1 and 0.4, uniform by area."""
    import numpy as np

    u, v = chance.uniform(0, math.tau, (2, 4 * n))
    kept = chance.uniform(0, 1.4, 4 * n) < 1 + 0.4 * np.cos(v)
    u, v = u[kept][:n], v[kept][:n]
    radius = 1 + 0.4 * np.cos(v)
    return np.column_stack([radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v)])


def cube(chance: Any, n: int, dimension: int) -> Any:
    return chance.random((n, dimension))


def delay(chance: Any, n: int, dimension: int) -> Any:
    """Delay vectors of two incommensurate waves with noise, three samples apart."""
    import numpy as np

    t = 0.05 * np.arange(n + 3 * dimension)
    series = np.sin(t) + 0.6 * np.sin(math.sqrt(2) * t + 0.3) + 0.05 * chance.normal(size=t.size)
    return np.column_stack([series[3 * k : 3 * k + n] for k in range(dimension)])


def lattice(_: Any, n: int, dimension: int) -> Any:
    """All points of a cubic grid, as many as fit."""
    import numpy as np

    side = round(n ** (1 / dimension))
    return np.stack(np.meshgrid(*[np.arange(float(side))] * dimension), axis=-1).reshape(-1, dimension)


def random_lengths(chance: Any, n: int, _: int) -> Any:
    """Distances of 1 to 2, each by itself: a metric without shape."""
    import numpy as np

    upper = np.triu(1 + chance.random((n, n)), 1)
    return upper + upper.T


def hamming(chance: Any, n: int, bits: int) -> Any:
    """Hamming distances of random strings."""
    import numpy as np
    from scipy.spatial.distance import pdist, squareform

    strings = chance.integers(0, 2, (n, bits))
    return np.rint(bits * squareform(pdist(strings, "hamming")))


def paths(chance: Any, n: int, unweighted: bool) -> Any:
    """Shortest paths in a graph of points in a ring, of which near ones are joined."""
    import numpy as np
    from scipy.sparse.csgraph import shortest_path
    from scipy.spatial.distance import pdist, squareform

    angle, radius = chance.uniform(0, math.tau, n), 1 + chance.uniform(-0.3, 0.3, n)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    lengths = squareform(pdist(points))
    lengths[lengths >= math.sqrt(14.4 / n)] = 0
    found = shortest_path(lengths, directed=False, unweighted=unweighted)
    found = np.minimum(found, found.T)  # both ways, summed in another order
    return np.where(np.isfinite(found), found, FAR)


POINTS: dict[str, Callable[[Any, int, int], Any]] = {
    "circle": circle,
    "wheel3": wheel3,
    "trefoil": trefoil,
    "sphere": sphere,
    "torus": torus,
    "cube": cube,
    "delay": delay,
    "lattice": lattice,
}
MATRICES: dict[str, Callable[[Any, int, int], Any]] = {
    "random": random_lengths,
    "hamming": hamming,
    "hops": lambda chance, n, _: paths(chance, n, True),
    "roads": lambda chance, n, _: paths(chance, n, False),
}


def write_cloud(cloud: Cloud) -> None:
    import numpy as np
    from scipy.spatial.distance import pdist, squareform

    kind, _, size = cloud.shape.partition(":")
    make = {**POINTS, **MATRICES}[kind]
    made = make(np.random.default_rng(zlib.crc32(cloud.name.encode())), cloud.points, int(size or 0))
    cloud.ours.parent.mkdir(parents=True, exist_ok=True)
    if cloud.is_matrix:
        square = made.astype("<f4")
    else:
        np.save(cloud.ours, made)
        if cloud.is_alone:
            return
        square = squareform(pdist(made)).astype("<f4")
    square[np.tril_indices(len(square), -1)].tofile(cloud.lower)
    np.save(cloud.square, square)  # last: its presence says that all are complete
