"""Names of files that USD cannot refer to are refused in a line."""

import pytest

from mtex_usd.errors import InputError
from mtex_usd.usd.arguments import as_file_path


@pytest.mark.parametrize("name", ["new\nline.usda", "tab\t.usda", "bad\udcff.usda"])
def test_names_usd_cannot_refer_to_are_refused(name):
    with pytest.raises(InputError, match="without control characters, in UTF-8"):
        as_file_path(name, "stage")


@pytest.mark.parametrize("name", ["日本 語.usda", "</script>.usda", "a b'\"%20#.usda"])
def test_other_names_are_taken_as_they_are(name):
    assert str(as_file_path(name, "stage")) == name
