"""The schemas are known early, a late registration is told, and the plugin is found without USD."""

import os
from pathlib import Path

import pytest

import mtex_usd.plugin_path
from mtex_usd.errors import InputError
from mtex_usd.plugin_path import plugin_path
from mtex_usd.usd.plugin import Registration, register_plugin, registration_status
from tests.usd.schema_support import run_python

KNOWN = "bool(Usd.SchemaRegistry().FindAppliedAPIPrimDefinition('MtexSketchAPI'))"
STATUS = "from mtex_usd.usd.plugin import registration_status as s; print(s().registered, s().message)"


def test_importing_registers() -> None:
    assert run_python(STATUS) == "True"


def test_status_where_registered() -> None:
    assert registration_status() == Registration(registered=True, message="")


def test_late_registration_is_told() -> None:
    opened = "from pxr import Usd; Usd.Stage.CreateInMemory().DefinePrim('/A', 'Xform')\n"
    printed = run_python(opened + STATUS)
    assert printed.startswith("False ")
    assert "before opening the first stage" in printed
    assert f"PXR_PLUGINPATH_NAME={plugin_path()}" in printed


def test_one_path_in_the_environment_is_enough(tmp_path: Path) -> None:
    code = f"from pxr import Usd; print({KNOWN})"
    assert run_python(code, folder=tmp_path) == "False"
    assert run_python(code, folder=tmp_path, plugin_folder=plugin_path()) == "True"


def test_environment_mends_a_late_import() -> None:
    opened = "from pxr import Usd; Usd.Stage.CreateInMemory().DefinePrim('/A', 'Xform')\n"
    assert run_python(opened + STATUS, plugin_folder=plugin_path()) == "True"


def test_registering_again_changes_nothing() -> None:
    register_plugin()
    assert registration_status().registered


def opened(imports: str) -> str:
    return f"{imports}\nfrom pxr import Usd; Usd.Stage.CreateInMemory().DefinePrim('/A', 'Xform'); print({KNOWN})"


@pytest.mark.parametrize("imports", ["import mtex_usd", "from pxr import Usd; import mtex_usd"])
def test_importing_the_package_is_enough_before_usd_or_after(imports: str, tmp_path: Path) -> None:
    assert run_python(opened(""), folder=tmp_path, package=True) == "False"
    assert run_python(opened(imports), folder=tmp_path, package=True) == "True"


def test_importing_the_package_after_the_first_stage_is_told() -> None:
    first = "from pxr import Usd; Usd.Stage.CreateInMemory().DefinePrim('/A', 'Xform')\nimport mtex_usd\n"
    assert "Import mtex_usd before opening the first stage" in run_python(first + STATUS)


def test_the_environment_keeps_what_stood_there(tmp_path: Path) -> None:
    code = "import mtex_usd, os; print(os.environ['PXR_PLUGINPATH_NAME'])"
    assert run_python(code, plugin_folder=tmp_path) == os.pathsep.join([str(tmp_path), str(plugin_path())])
    assert run_python(code, plugin_folder=plugin_path()) == str(plugin_path())


def test_an_incomplete_installation_can_be_imported() -> None:
    """What says where the plugin should be must still run."""
    code = (
        "import mtex_usd.plugin_path as p, os, pathlib, sys; p._PLACES = (pathlib.Path('/nowhere'),)\n"
        "del sys.modules['mtex_usd'], os.environ['PXR_PLUGINPATH_NAME']\n"
        "import mtex_usd; print(mtex_usd.InputError.exit_code)\n"
        "try: import mtex_usd.usd\nexcept mtex_usd.InputError as error: print(error)"
    )
    printed = run_python(code).splitlines()
    assert printed[0] == "2"
    assert printed[1].startswith("the installation of usdmtex is incomplete")


def test_plugin_path_loads_neither_usd_nor_numpy() -> None:
    code = (
        "import sys; from mtex_usd.plugin_path import plugin_path; print(plugin_path());"
        "print(sorted({'pxr', 'numpy', 'scipy'} & set(sys.modules)))"
    )
    assert run_python(code).splitlines() == [str(plugin_path()), "[]"]


def test_plugin_path_is_absolute() -> None:
    assert plugin_path().is_absolute()
    assert (plugin_path() / "plugInfo.json").is_file()


def test_incomplete_installation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mtex_usd.plugin_path, "_PLACES", (tmp_path / "pxr_plugin",))
    with pytest.raises(InputError, match=r"installation of usdmtex is incomplete.*Install usdmtex again") as error:
        plugin_path()
    assert str(tmp_path) in error.value.expected
