"""The version of this package.

In: nothing. Out: `VERSION`.
Invariant: it is written nowhere else.
"""

VERSION = "0.1.0"
