"""Qt without a screen, usdview's stand-in beside ``pxr``, shots on disk."""

import os
from pathlib import Path

import pxr
import pytest
from pxr import Usd

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
pxr.__path__.append(str(Path(__file__).parent / "double"))

try:
    from PySide6 import QtWidgets
except ImportError as error:
    QtWidgets, NO_QT = None, f"no Qt ({error}); pip install PySide6-Essentials"
else:
    NO_QT = ""


class _Skipped(pytest.Module):
    """A module of tests that is skipped before it is imported."""

    def collect(self):
        pytest.skip(NO_QT, allow_module_level=True)


def pytest_pycollect_makemodule(module_path, parent):
    """Skip all of this folder, and say why, where there is no Qt to run it with."""
    return _Skipped.from_parent(parent, path=module_path) if NO_QT else None


@pytest.fixture(scope="session", autouse=True)
def application():
    """Give the one application that Qt allows."""
    return QtWidgets.QApplication.instance() or QtWidgets.QApplication([])


@pytest.fixture(autouse=True)
def no_windows_left():
    """Close what a test left open, so that the next begins anew."""
    yield
    from mtex_usd.usdview import window

    for name in list(window._open):
        window.close_window(name)


@pytest.fixture
def boxes(monkeypatch):
    """Give the texts of message boxes, which would otherwise wait for a click."""
    shown = []
    monkeypatch.setattr(QtWidgets.QMessageBox, "warning", lambda *arguments: shown.append(arguments[2]))
    return shown


@pytest.fixture(scope="session")
def processed(tmp_path_factory):
    """Give the thin root of two characters who walked, one with two sketches, processed once for all tests."""
    from tests.usdview.shots import write_processed

    return write_processed(tmp_path_factory.mktemp("processed"))


@pytest.fixture
def usdview(processed, boxes):
    """Give a usdview with that shot open."""
    from tests.usdview.usdview import Usdview

    # A stage of its own: the session layer is what tests write into.
    return Usdview(Usd.Stage.Open(str(processed))).load()


@pytest.fixture(scope="session")
def walk(tmp_path_factory):
    """Give the thin root of the sample walk, two paths of it."""
    from tests.usdview.walk import process_walk

    return process_walk(tmp_path_factory.mktemp("walk"))


@pytest.fixture(scope="session")
def prepared(walk):
    """Give what the walk's character plays, ready for its steps to be moved."""
    from mtex_usd.constraints.planting.steps import prepare_steps
    from tests.usdview.walk import MESH, read_one

    motion = read_one(Usd.Stage.Open(str(walk)), MESH)
    return motion, prepare_steps(motion.clip, motion.holds, limits=motion.limits)
