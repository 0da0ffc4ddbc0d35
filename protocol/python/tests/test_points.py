"""What containers mark as missing: masks, nulls, None, NA and NaT are never sent as numbers.

In: lists, and numpy arrays and tables of pandas and pyarrow where these are installed. Out: the doubles that are sent.
"""

from __future__ import annotations

import importlib
import math
import struct
import unittest
from array import array
from typing import Any

from hopes_client.codec import Packed
from hopes_client.points import list_tags, pack_numbers, pack_points

NAN = math.nan
#: 2020-01-01, in seconds since 1970.
YEAR_2020 = 1577836800.0


class Missing(unittest.TestCase):
    """A test that needs modules, and compares doubles; NaN equals NaN."""

    def need(self, *names: str) -> Any:
        try:
            found = [importlib.import_module(name) for name in names]
        except ImportError as error:
            self.skipTest(str(error))
        return found[0] if len(found) == 1 else found

    def assert_sent(self, packed: Packed, *expected: float) -> None:
        sent = struct.unpack(f"<{len(packed.data) // 8}d", packed.data)
        self.assertEqual(list(map(repr, sent)), [repr(float(number)) for number in expected])


class Lists(Missing):
    def test_none_is_missing(self) -> None:
        self.assert_sent(pack_points([(1, None), (2.5, 3)]), 1, NAN, 2.5, 3)
        self.assert_sent(pack_numbers([None, 7]), NAN, 7)
        self.assert_sent(pack_numbers(array("d", [1.0, NAN])), 1, NAN)
        self.assert_sent(pack_points(iter([(None, None)])), NAN, NAN)

    def test_other_things_are_named_with_their_place(self) -> None:
        for points, says in [([(1, 2), ("3", 4)], r"point 1 has the text '3'"), ([(1, {})], r"point 0 has {}")]:
            with self.assertRaisesRegex(TypeError, says):
                pack_points(points)
        with self.assertRaisesRegex(TypeError, "point 1 has the text 'x'"):
            pack_numbers([1.0, "x"])

    def test_tags_are_whole_numbers(self) -> None:
        self.assertEqual(list_tags([1, 2.0, True]), [1, 2, 1])
        with self.assertRaisesRegex(ValueError, "tag 1 is missing"):
            list_tags([1, None])
        with self.assertRaisesRegex(ValueError, r"tag 0 is 1\.5, not a whole number"):
            list_tags([1.5])


class Arrays(Missing):
    def setUp(self) -> None:
        self.numpy = self.need("numpy")

    def test_masked_numbers_are_missing(self) -> None:
        ma = self.numpy.ma
        for dtype in ("f8", "f4", "i8", "u1", ">i4", object):
            points = ma.array([[1, 2], [3, 4], [5, 6]], mask=[[0, 1], [1, 1], [0, 0]], dtype=dtype)
            self.assert_sent(pack_points(points), 1, NAN, NAN, NAN, 5, 6)
        self.assert_sent(pack_points(ma.masked_invalid([[1, math.inf], [2, 3]])), 1, NAN, 2, 3)
        self.assert_sent(pack_points(ma.array([[1, 2]])), 1, 2)
        self.assert_sent(pack_points(ma.array([[1, 2]], mask=True)), NAN, NAN)
        self.assert_sent(pack_numbers(ma.array([1, 2, 3], mask=[0, 1, 0])), 1, NAN, 3)
        self.assert_sent(pack_points([(ma.masked, 1), (2, 3)]), NAN, 1, 2, 3)
        with self.assertRaisesRegex(ValueError, "tag 1 is missing"):
            list_tags(ma.array([1, 2], mask=[0, 1]))

    def test_the_value_under_a_mask_is_not_looked_at(self) -> None:
        values = self.numpy.array([[1, "two"], [3, 4]], dtype=object)
        points = self.numpy.ma.array(values, mask=[[0, 1], [0, 0]])
        self.assert_sent(pack_points(points), 1, NAN, 3, 4)

    def test_objects(self) -> None:
        self.assert_sent(pack_points(self.numpy.array([[1, None], [NAN, 4]], dtype=object)), 1, NAN, NAN, 4)
        with self.assertRaisesRegex(TypeError, "point 1 has the text 'x'"):
            pack_points(self.numpy.array([[1, 2], [3, "x"]], dtype=object))

    def test_what_is_no_number(self) -> None:
        for values, says in [([[1, 2j]], "complex128"), ([["1", "2"]], "not of numbers")]:
            with self.assertRaisesRegex(TypeError, says):
                pack_points(self.numpy.array(values))

    def test_fields_are_taken_by_their_names(self) -> None:
        for x, y in [("x", "y"), ("X", "Y"), ("lon", "lat"), ("Longitude", "Latitude"), ("easting", "northing")]:
            for fields in ([(x, "f8"), (y, "i4")], [(y, "i4"), (x, "f8")]):
                points = self.numpy.zeros(2, dtype=fields)
                points[x], points[y] = [1.5, 2.5], [3, 4]
                self.assert_sent(pack_points(points), 1.5, 3, 2.5, 4)
                masked = self.numpy.ma.array(points, mask=[(0, 0), (1, 1)])
                self.assert_sent(pack_points(masked), 1.5, 3, NAN, NAN)
        for fields in ([("x", "f8"), ("y", "f8"), ("t", "f8")], [("a", "f8"), ("b", "f8")]):
            with self.assertRaisesRegex(ValueError, "has the fields"):
                pack_points(self.numpy.zeros(2, dtype=fields))

    def test_instants_are_seconds(self) -> None:
        for unit in ("D", "s", "ms", "ns"):
            times = self.numpy.array(["2020-01-01", "NaT"], dtype=f"M8[{unit}]")
            self.assert_sent(pack_numbers(times), YEAR_2020, NAN)
        self.assert_sent(pack_numbers(self.numpy.array([1500, "NaT"], dtype="m8[ms]")), 1.5, NAN)
        self.assert_sent(pack_numbers(self.numpy.ma.array(times, mask=[1, 0])), NAN, NAN)


class Tables(Missing):
    def test_pandas(self) -> None:
        _, pandas = self.need("numpy", "pandas")
        nullable = {"x": pandas.array([1, None], dtype="Int64"), "y": pandas.array([None, 2.5], dtype="Float64")}
        self.assert_sent(pack_points(pandas.DataFrame(nullable)), 1, NAN, NAN, 2.5)
        self.assert_sent(pack_points(pandas.DataFrame({"y": [1.0], "x": [2.0]})), 2, 1)
        self.assert_sent(pack_points(pandas.DataFrame({"lat": [1.0], "lon": [2.0]}, index=[7])), 2, 1)
        objects = pandas.DataFrame({"a": [1, None], "b": [pandas.NA, 2]}, dtype=object)
        self.assert_sent(pack_points(objects), 1, NAN, NAN, 2)
        self.assert_sent(pack_points([(1, pandas.NA)]), 1, NAN)
        for dtype in ("Int64", "Float64", "float64"):
            self.assert_sent(pack_numbers(pandas.Series([1, None], dtype=dtype)), 1, NAN)
        for utc in (False, True):
            times = pandas.to_datetime(["2020-01-01", None], utc=utc)
            self.assert_sent(pack_numbers(times), YEAR_2020, NAN)
            self.assert_sent(pack_numbers(pandas.Series(times)), YEAR_2020, NAN)
        with self.assertRaisesRegex(ValueError, r"shape \(1, 3\)"):
            pack_points(pandas.DataFrame({"t": [0.0], "x": [1.0], "y": [2.0]}))
        with self.assertRaisesRegex(ValueError, "tag 1 is missing"):
            list_tags(pandas.Series([1, None], dtype="Int64"))

    def test_pyarrow(self) -> None:
        _, arrow = self.need("numpy", "pyarrow")
        self.assert_sent(pack_points(arrow.table({"x": [1, None], "y": [None, 2.5]})), 1, NAN, NAN, 2.5)
        self.assert_sent(pack_points(arrow.table({"y": [1, None], "x": [None, 2.5]})), NAN, 1, 2.5, NAN)
        self.assert_sent(pack_numbers(arrow.array([1, None])), 1, NAN)
        self.assert_sent(pack_numbers(arrow.chunked_array([[1.5, None], [3.0]])), 1.5, NAN, 3)
        times = arrow.array([10**9, None], arrow.timestamp("ns"))
        self.assert_sent(pack_numbers(times), 1, NAN)


if __name__ == "__main__":
    unittest.main()
