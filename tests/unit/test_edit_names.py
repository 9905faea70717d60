"""What people import from mtex_usd.edit: loaded when used, documented, options by name only."""

import inspect

import pytest

from mtex_usd import edit
from tests.usd.schema_support import run_python


@pytest.mark.parametrize("name", edit.__all__)
def test_every_name_is_there_and_documented(name):
    found = getattr(edit, name)
    assert found.__name__ == name
    assert inspect.getdoc(found)
    assert name in dir(edit)


@pytest.mark.parametrize("name", [name for name in edit.__all__ if inspect.isfunction(getattr(edit, name))])
def test_options_have_names(name):
    for parameter in inspect.signature(getattr(edit, name)).parameters.values():
        is_option = parameter.default is not inspect.Parameter.empty
        assert not is_option or parameter.kind is inspect.Parameter.KEYWORD_ONLY, parameter


def test_all_is_sorted_and_unique():
    assert list(edit.__all__) == sorted(set(edit.__all__))


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match=r"module 'mtex_usd\.edit' has no attribute 'scale'"):
        edit.scale  # noqa: B018 - the access is the test


def test_importing_loads_nothing_heavy():
    code = "import sys, mtex_usd.edit; print([name for name in ('pxr', 'numpy', 'scipy') if name in sys.modules])"
    assert run_python(code) == "[]"
