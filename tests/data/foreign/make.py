"""Writes a ring in the formats of other programs: 24 points on a circle of radius 10, so its one dot is (1.305, 10).

In: numpy, plyfile, geojson and python-lzf (`pip install numpy plyfile geojson python-lzf`), gzip.
Out: the files beside this one. None of them is written by hopes, and none by its tests.
"""

import gzip
import json
import struct
import subprocess
from pathlib import Path

import geojson
import lzf
import numpy
from plyfile import PlyData, PlyElement

HERE = Path(__file__).parent
ANGLES = numpy.arange(24) * numpy.pi / 12
RING = numpy.column_stack((10 * numpy.cos(ANGLES), 10 * numpy.sin(ANGLES)))
X, Y = RING.T
IDS = numpy.arange(100, 124)


def write_npy():
    numpy.save(HERE / "ring.npy", RING)
    numpy.save(HERE / "big_endian_f4.npy", numpy.column_stack((RING, IDS)).astype(">f4"))
    numpy.save(HERE / "fortran.npy", numpy.asfortranarray(numpy.column_stack((RING, IDS))))
    numpy.save(HERE / "integers.npy", numpy.rint(RING * 1000).astype("<i4"))
    records = numpy.zeros(24, [("id", "<u2"), ("name", "<U3"), ("y", ">f8"), ("rgb", "u1", 3), ("x", "<f4")])
    records["id"], records["x"], records["y"] = IDS, X, Y
    numpy.save(HERE / "records.npy", records)


def write_ply():
    vertices = numpy.zeros(24, [("intensity", "u1"), ("y", "f8"), ("x", "f4"), ("z", "f4")])
    vertices["x"], vertices["y"], vertices["z"] = X, Y, IDS
    faces = numpy.zeros(2, [("vertex_indices", "i4", (3,))])
    elements = [PlyElement.describe(vertices, "vertex"), PlyElement.describe(faces, "face")]
    PlyData(elements, text=True, comments=["a ring"]).write(HERE / "ascii.ply")
    PlyData(elements, byte_order="<").write(HERE / "little_endian.ply")
    # Lists before the vertices.
    PlyData(elements[::-1], byte_order=">").write(HERE / "big_endian.ply")


def pcd_header(data):
    return (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS normal y x time\nSIZE 4 4 8 8\nTYPE F F F U\n"
        f"COUNT 3 1 1 1\nWIDTH 24\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 24\nDATA {data}\n"
    ).encode()


def write_pcd():
    rows = numpy.zeros(24, [("normal", "<f4", 3), ("y", "<f4"), ("x", "<f8"), ("time", "<u8")])
    rows["x"], rows["y"], rows["time"] = X, Y, IDS
    lines = "".join(f"0 0 1 {y:.9g} {x:.17g} {stamp}\n" for x, y, stamp in zip(X, Y, IDS))
    (HERE / "ascii.pcd").write_bytes(pcd_header("ascii") + lines.encode())
    (HERE / "binary.pcd").write_bytes(pcd_header("binary") + rows.tobytes())
    columns = b"".join(rows[name].tobytes() for name in rows.dtype.names)
    compressed = lzf.compress(columns)
    lengths = struct.pack("<II", len(compressed), len(columns))
    (HERE / "compressed.pcd").write_bytes(pcd_header("binary_compressed") + lengths + compressed)


def write_geojson():
    half = [geojson.Feature(geometry=geojson.Point((x, y, 5)), properties={"coordinates": [9, 9]}) for x, y in RING[:8]]
    line = geojson.Feature(geometry=geojson.LineString(RING[8:16].tolist()))
    ring = [*RING[16:].tolist(), RING[16].tolist()]
    rest = geojson.Feature(geometry=geojson.GeometryCollection([geojson.Polygon([ring])]))
    (HERE / "ring.geojson").write_text(geojson.dumps(geojson.FeatureCollection([*half, line, rest]), indent=1))
    (HERE / "lines.geojsonl").write_text("".join(geojson.dumps(feature) + "\n" for feature in [*half, line, rest]))


def write_text():
    (HERE / "pretty.json").write_text(json.dumps([{"x": x, "y": y} for x, y in RING], indent=2))
    (HERE / "array.json").write_text(json.dumps(RING.tolist()))
    table = "".join(f"{x:.17g},{y:.17g}\n" for x, y in RING)
    (HERE / "utf16.csv").write_bytes(("x,y\n" + table).encode("utf-16"))
    # Two members, as `cat a.gz b.gz` makes them.
    halves = table.splitlines(keepends=True)
    (HERE / "ring.csv.gz").write_bytes(b"".join(gzip_by_program("".join(half)) for half in (halves[:12], halves[12:])))
    (HERE / "ring.npy.gz").write_bytes(gzip.compress((HERE / "ring.npy").read_bytes(), mtime=0))


def gzip_by_program(text):
    return subprocess.run(["gzip", "-n"], input=text.encode(), capture_output=True, check=True).stdout


write_npy()
write_ply()
write_pcd()
write_geojson()
write_text()
