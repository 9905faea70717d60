"""usdview finds the plugin, loads it and builds its menu, by the interface that is documented."""

import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Plug
from pxr.Usdviewq import plugin as double
from PySide6 import QtGui

from mtex_usd.plugin_path import plugin_path
from tests.usdview import documented

CONTAINER = "mtex_usd.usdview.container.MotionTextureContainer"
ENTRIES = [
    ("Next Path", "Ctrl+Alt+N"),
    ("Previous Path", "Ctrl+Alt+P"),
    ("Original", "Ctrl+Alt+O"),
    None,
    ("Paths...", ""),
    ("Show Fragments...", ""),
    None,
    ("Process This Animation...", ""),
    ("Edit Contact...", ""),
    None,
    ("Accept Path...", ""),
]
REPORT = """
import inspect, json, sys
from PySide6 import QtWidgets
app = QtWidgets.QApplication([])
from pxr.Usdviewq import plugin
window = QtWidgets.QMainWindow()
registry = plugin.loadPlugins(object(), window)
menus = {m.text(): [None if a.isSeparator() else [a.text(), a.shortcut().toString()] for a in m.menu().actions()]
         for m in window.menuBar().actions()}
signatures = {}
for name in json.loads(sys.argv[1]):
    owner, _, method = name.partition(".")
    signature = inspect.signature(getattr(getattr(plugin, owner), method))
    signatures[name] = str(signature.replace(parameters=list(signature.parameters.values())[1:]))
api = {}
try:
    from pxr.Usdviewq.usdviewApi import UsdviewApi
    api = {name: None if isinstance(each, property) else list(inspect.signature(each).parameters)[1:]
           for name, each in vars(UsdviewApi).items() if not name.startswith("_")}
except ImportError:
    pass
print(json.dumps({"menu": menus.get("Motion Texture"), "signatures": signatures, "api": api}))
"""


def read_menu(menu):
    return [None if a.isSeparator() else (a.text(), a.shortcut().toString()) for a in menu.actions()]


def test_the_menu_has_every_command(usdview):
    assert read_menu(usdview.menu) == ENTRIES
    assert all(action.toolTip() for action in usdview.menu.actions() if not action.isSeparator())
    for entry in filter(None, ENTRIES):
        shortcut = usdview.action(entry[0]).shortcut()
        assert not entry[1] or shortcut == QtGui.QKeySequence(entry[1])


def test_every_command_is_registered_under_the_containers_name(usdview):
    names = ("next_path", "previous_path", "show_original", "list_paths", "show_fragments")
    for name in (*names, "process_animation", "edit_contact", "accept_path"):
        assert usdview.registry.getCommandPlugin(f"MotionTextureContainer.{name}").displayName


def test_the_plugin_is_declared_as_usdview_looks_for_it():
    plugin = Plug.Registry().GetPluginWithName("mtex_usd.usdview.container")
    assert not plugin.isResource
    assert Path(plugin.path).resolve() == plugin_path().resolve()
    (declared,) = [each for each in double.PluginContainerTfType.GetAllDerivedTypes() if each.typeName == CONTAINER]
    assert Plug.Registry().GetPluginForType(declared) == plugin
    assert Plug.Registry().GetStringFromPluginMetaData(declared, "displayName") == "Motion Texture"


@pytest.mark.parametrize("name", sorted(documented.PLUGIN_METHODS))
def test_the_stand_in_has_the_documented_parameters(name):
    owner, _, method = name.partition(".")
    signature = inspect.signature(getattr(getattr(double, owner), method))
    without_self = signature.replace(parameters=list(signature.parameters.values())[1:])
    assert str(without_self) == documented.PLUGIN_METHODS[name]


def test_the_stand_in_refuses_what_is_not_documented(usdview):
    with pytest.raises(AssertionError, match="documents no UpdateView"):
        usdview.api.UpdateView()
    with pytest.raises(TypeError, match="too many positional"):
        usdview.api.UpdateGUI(1)
    with pytest.raises(AssertionError, match="does not let plugins set stage"):
        usdview.api.stage = None
    with pytest.raises(ValueError, match=r"Expected Usd\.TimeCode"):
        usdview.api.dataModel.currentFrame = 3.0


def run_python(code, *arguments, interpreter=sys.executable, **variables):
    hidden = {"PYTHONPATH", "PXR_PLUGINPATH_NAME"}
    environment = {key: value for key, value in os.environ.items() if key not in hidden} | variables
    command = [str(interpreter), "-c", code, *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_modules_import_without_qt_and_without_usdview():
    names = sorted(each.stem for each in (plugin_path() / "usdview").glob("*.py") if each.stem != "container")
    code = (
        "import importlib, sys; sys.modules['PySide6'] = sys.modules['pxr.Usdviewq'] = None\n"
        f"for name in {names}: importlib.import_module('mtex_usd.usdview.' + name)\n"
        "print(sorted(name for name in sys.modules if name.startswith('PySide')))"
    )
    assert "commands" in names
    assert run_python(code, PYTHONPATH=os.pathsep.join(filter(None, sys.path))).strip() == "['PySide6']"


def test_one_variable_is_enough_in_a_process_that_knows_nothing_of_us():
    """As usdview starts: our folder on PXR_PLUGINPATH_NAME, and the package where Python finds packages."""
    stand_in = Path(__file__).parent / "double"
    code = f"import pxr; pxr.__path__.append({str(stand_in)!r})\n{REPORT}"
    printed = run_python(
        code,
        json.dumps([]),
        PXR_PLUGINPATH_NAME=str(plugin_path()),
        PYTHONPATH=os.pathsep.join(filter(None, sys.path)),
        QT_QPA_PLATFORM="offscreen",
    )
    assert json.loads(printed)["menu"] == [entry and list(entry) for entry in ENTRIES]


def test_a_real_usdview_loads_the_plugin_and_is_as_documented():
    interpreter = os.environ.get("MTEX_USDVIEW_PYTHON")
    if not interpreter:
        pytest.skip("no usdview; set MTEX_USDVIEW_PYTHON to a Python that has pxr.Usdviewq")
    printed = run_python(
        REPORT,
        json.dumps(list(documented.PLUGIN_METHODS)),
        interpreter=interpreter,
        PXR_PLUGINPATH_NAME=str(plugin_path()),
        PYTHONPATH=str(Path(sys.modules["mtex_usd"].__file__).parents[1]),
        QT_QPA_PLATFORM="offscreen",
    )
    found = json.loads(printed)
    assert found["menu"] == [entry and list(entry) for entry in ENTRIES]
    assert found["signatures"] == documented.PLUGIN_METHODS
    if found["api"]:
        assert {name for name, kind in found["api"].items() if kind is None} >= documented.API_PROPERTIES
        assert {name: tuple(kind) for name, kind in found["api"].items() if kind is not None} == documented.API_METHODS
