"""The wheel and the editable install, each in a fresh environment and used from outside the checkout."""

import os
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

pytestmark = pytest.mark.install

PROJECT = Path(__file__).resolve().parents[2]
PLUGIN_FILES = {
    "mtex_usd/_plugins/pxr_plugin/plugInfo.json",
    "mtex_usd/_plugins/schemas/generatedSchema.usda",
    "mtex_usd/_plugins/schemas/plugInfo.json",
    "mtex_usd/_plugins/schemas/schema.usda",
    *(
        f"mtex_usd/_plugins/pxr_plugin/usdview/{module.name}"
        for module in (PROJECT / "pxr_plugin" / "usdview").glob("*.py")
    ),
}
KNOWN = "from pxr import Usd; print(bool(Usd.SchemaRegistry().FindAppliedAPIPrimDefinition('MtexSketchAPI')))"


@dataclass(frozen=True)
class Installation:
    """A fresh environment with the package in it, and an empty folder to work in."""

    scripts: Path
    folder: Path

    def run(self, program: str, *arguments: str, **variables: str) -> str:
        """Run an installed program and give what it prints."""
        hidden = {"PYTHONPATH", "PXR_PLUGINPATH_NAME", "VIRTUAL_ENV"}
        environment = {name: value for name, value in os.environ.items() if name not in hidden} | variables
        return run_command(str(self.scripts / program), *arguments, folder=self.folder, environment=environment)


def run_command(*command: str, folder: Path = PROJECT, environment: dict[str, str] | None = None) -> str:
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout


def install(folder: Path, *requirement: str) -> Installation:
    """Make an environment the way the README does, which needs neither ensurepip nor pip inside it."""
    run_command(sys.executable, "-m", "venv", "--without-pip", str(folder / "env"))
    interpreter = str(folder / "env" / "bin" / "python")
    run_command(sys.executable, "-m", "pip", "--python", interpreter, "install", "--quiet", *requirement)
    (folder / "work").mkdir()
    return Installation(scripts=folder / "env" / "bin", folder=folder / "work")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run_command(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(PROJECT))
    (built,) = folder.glob("usdmtex-*.whl")
    return built


@pytest.fixture(scope="module")
def from_wheel(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installation:
    return install(tmp_path_factory.mktemp("from_wheel"), str(wheel))


@pytest.fixture(scope="module")
def editable(tmp_path_factory: pytest.TempPathFactory) -> Installation:
    return install(tmp_path_factory.mktemp("editable"), "--editable", str(PROJECT))


@pytest.fixture(params=["from_wheel", "editable"])
def installation(request: pytest.FixtureRequest) -> Installation:
    return request.getfixturevalue(request.param)


def test_wheel_carries_the_package_and_nothing_else(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {name for name in names if "/_plugins/" in name} == PLUGIN_FILES
    assert "mtex_usd/py.typed" in names
    strays = [name for name in names if not name.startswith("mtex_usd/") and ".dist-info/" not in name]
    assert strays == []
    assert not [name for name in names if "__pycache__" in name]


def test_printed_path_registers_the_schemas(installation: Installation) -> None:
    printed = installation.run("usdmtex", "--print-plugin-path").strip()
    assert (Path(printed) / "plugInfo.json").is_file()
    assert installation.run("python", "-c", KNOWN).strip() == "False"
    assert installation.run("python", "-c", KNOWN, PXR_PLUGINPATH_NAME=printed).strip() == "True"


def test_importing_registers_the_schemas(installation: Installation) -> None:
    code = "from mtex_usd.usd.plugin import registration_status; print(registration_status().registered)"
    assert installation.run("python", "-c", code).strip() == "True"


def test_wheel_does_not_reach_into_the_checkout(from_wheel: Installation) -> None:
    printed = from_wheel.run("usdmtex", "--print-plugin-path").strip()
    assert Path(printed).is_relative_to(from_wheel.scripts.parent)


def test_editable_install_uses_the_checkout(editable: Installation) -> None:
    assert Path(editable.run("usdmtex", "--print-plugin-path").strip()) == PROJECT / "pxr_plugin"


def test_the_usdview_plugin_is_where_usdview_looks_for_it(installation: Installation) -> None:
    printed = installation.run("usdmtex", "--print-plugin-path").strip()
    # Found by name, as usdview does; it is loaded there, where there is Qt.
    code = "import mtex_usd.usdview, importlib.util as u; print(u.find_spec('mtex_usd.usdview.container').origin)"
    assert Path(installation.run("python", "-c", code).strip()).parent == Path(printed) / "usdview"


PROGRAMS = ["usdmtex", "usdmtex-conform", "usdmtex-edit", "usdmtex-import", "usdmtex-suggest"]


@pytest.mark.parametrize("program", PROGRAMS)
def test_programs_explain_themselves(installation: Installation, program: str) -> None:
    assert f"usage: {program}" in installation.run(program, "--help").lower()
