"""What people import: one canonical place per name, documented, and quick to come by."""

import inspect
import tomllib
from pathlib import Path

import pytest

import mtex_usd
from tests.usd.schema_support import run_python

SHOT = Path(__file__).resolve().parents[2] / "sample_stages" / "phrase.usda"


def test_all_is_sorted_and_unique() -> None:
    assert list(mtex_usd.__all__) == sorted(set(mtex_usd.__all__))


def test_all_is_what_the_design_promises() -> None:
    promised = {"process", "import_takes", "read_clip", "write_clip", "Clip", "Result", "InputError", "StageError"}
    assert promised <= set(mtex_usd.__all__)


@pytest.mark.parametrize("name", mtex_usd.__all__)
def test_every_name_is_there_and_documented(name: str) -> None:
    found = getattr(mtex_usd, name)
    assert found.__name__ == name
    assert inspect.getdoc(found)


@pytest.mark.parametrize("name", mtex_usd.__all__)
def test_every_name_is_listed_before_it_is_loaded(name: str) -> None:
    assert name in dir(mtex_usd)


@pytest.mark.parametrize("name", [name for name in mtex_usd.__all__ if inspect.isfunction(getattr(mtex_usd, name))])
def test_functions_are_annotated_and_their_options_have_names(name: str) -> None:
    signature = inspect.signature(getattr(mtex_usd, name))
    assert signature.return_annotation is not inspect.Signature.empty
    for parameter in signature.parameters.values():
        assert parameter.annotation is not inspect.Parameter.empty, parameter
        is_option = parameter.default is not inspect.Parameter.empty
        assert not is_option or parameter.kind is inspect.Parameter.KEYWORD_ONLY, parameter


def test_the_version_is_the_packages() -> None:
    project = Path(__file__).resolve().parents[2] / "pyproject.toml"
    assert tomllib.loads(project.read_text())["project"]["version"] == mtex_usd.__version__


def test_star_import_gives_all() -> None:
    names: dict[str, object] = {}
    exec("from mtex_usd import *", names)
    assert set(mtex_usd.__all__) <= names.keys()


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'mtex_usd' has no attribute 'proces'"):
        mtex_usd.proces  # noqa: B018 - the access is the test


def test_importing_loads_nothing_heavy() -> None:
    code = "import sys, mtex_usd; print([name for name in ('pxr', 'numpy', 'scipy', 'rich') if name in sys.modules])"
    assert run_python(code) == "[]"


def test_opening_a_stage_and_processing_after_the_import(tmp_path: Path) -> None:
    """The order a pipeline has them in; nothing is to be said about a late registration."""
    code = (
        "import mtex_usd\nfrom pxr import Usd\n"
        f"stage = Usd.Stage.Open({str(SHOT)!r}); prim = stage.GetPrimAtPath('/Humanoid/Sketch')\n"
        "print('mtex:paths' in prim.GetPropertyNames(), prim.GetAttribute('mtex:paths').Get())\n"
        f"(result,) = mtex_usd.process({str(SHOT)!r}, out={str(tmp_path / 'out.usd')!r}, paths=1)\n"
        "print(result.anim, len(result.variants), result.notes)"
    )
    assert run_python(code).splitlines() == ["True 5", "/Humanoid/Sketch 1 ()"]
