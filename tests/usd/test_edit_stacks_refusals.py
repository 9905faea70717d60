"""Stacks of edits that are not right are refused in words, before anything is written."""

from pathlib import Path

import pytest

import mtex_usd
from mtex_usd.errors import InputError, StageError
from tests.usd.edit_support import ANIMATION, NAMES, OTHER, STACKS, write_shot


@pytest.mark.parametrize(
    ("body", "error", "message"),
    [
        (
            STACKS.replace('"lowpass"', '"smooth"'),
            InputError,
            r"/Hero/Walk\.mtex:edit:calm:op is not allowed; .*found smooth",
        ),
        (
            STACKS + "uniform double mtex:edit:calm:factor = 2",
            InputError,
            r"/Hero/Walk: edit calm \(lowpass\): it takes no factor; expected only frequencies, channels, order",
        ),
        (
            STACKS.replace("uniform double[] mtex:edit:calm:frequencies = [1.5]", ""),
            InputError,
            r"/Hero/Walk: edit calm \(lowpass\): frequencies is not said",
        ),
        (
            STACKS.replace("</Takes/Other>", "[]"),
            InputError,
            r"edit half \(blend\): with does not fit; expected 1 or more",
        ),
        (
            STACKS.replace("</Takes/Other>", "</Hero/Rig>"),
            StageError,
            r"edit:half:with names no animation; .*/Hero/Rig, Skel",
        ),
        (STACKS.replace('["*Arm"]', '["Tail"]'), InputError, r"/Hero/Walk: edit calm \(lowpass\): .*Tail"),
        (
            STACKS.replace('"calm", "raise"', '"calm", "gone"'),
            InputError,
            r"names an edit that is not there.*found gone",
        ),
        (STACKS.replace("mtex:edits:other", "mtex:edits:original"), InputError, r"cannot be the name of a stack"),
        (STACKS.replace("= [30]", "= [nan]"), InputError, r"mtex:edit:raise:keys is not allowed; expected finite time"),
        (STACKS.replace("factor = 1.5", "factor = 1e9"), InputError, r"edit slow \(scaleTime\): .*too many frames"),
        ("uniform token[] mtex:edits = []", StageError, r"no animation to edit; .*found /Hero/Walk, /Takes/Other"),
    ],
)
def test_refusals(tmp_path: Path, body: str, error: type[Exception], message: str) -> None:
    shot = write_shot(tmp_path, body, NAMES)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(error, match=message):
        mtex_usd.apply_edits(shot)
    assert sorted(tmp_path.iterdir()) == before


def test_the_last_of_several_animations_is_checked_before_anything_is_written(tmp_path: Path) -> None:
    shot = write_shot(tmp_path, STACKS, NAMES)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(StageError, match=r"/Takes/Other has no stack of edits; expected MtexEditStackAPI"):
        mtex_usd.apply_edits(shot, anim=[ANIMATION, OTHER])
    assert sorted(tmp_path.iterdir()) == before
