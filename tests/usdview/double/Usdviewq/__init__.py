"""A stand-in for ``pxr.Usdviewq``, which no package on PyPI has: its documented plugin interface and nothing else.

Put beside the real ``pxr`` by ``tests/usdview/conftest.py``. The interface is the one tabled in ``documented.py``.
"""

# ruff: noqa: N999 (the names are those of usdview)
