"""Edits whose settings are not right are refused by name, and before anything is done."""

from typing import Any

import pytest

from mtex_usd import edit
from mtex_usd.edit.stack.operations import OPERATIONS, check_edit
from mtex_usd.errors import InputError
from tests.edit_stack_cases import ARMS, FRAMES, POINTS, RAISED, make_clips, make_edit, run
from tests.synthetic import walk

BAD: list[tuple[str, dict[str, Any], int, str]] = [
    ("smooth", {}, 0, r"there is no such operation; expected one of lowpass, .*, reduceKeys; found 'smooth'"),
    ("lowpass", {}, 0, r"frequencies is not said; expected frequencies"),
    ("warpTime", {"from": (1.0,)}, 0, r"to is not said; expected from, to"),
    ("lowpass", {"frequencies": (1.0,), "factor": 2.0}, 0, r"it takes no factor; expected only frequencies, channels"),
    ("mirror", {"start": 2.0}, 0, r"it takes no start; expected only plane"),
    ("mirror", {}, 1, r"with does not fit; expected 0 other motions; found 1"),
    ("blend", {"weights": (1.0,)}, 0, r"with does not fit; expected 1 or more other motions; found 0"),
    ("align", {}, 2, r"with does not fit; expected 1 other motions; found 2"),
    ("join", {}, 2, r"with does not fit; expected 0 to 1 other motions; found 2"),
    ("lowpass", {"frequencies": (1.0, 2.0)}, 0, r"frequencies do not fit; expected one frequency, Hz; found \[1.0, 2"),
    ("bandpass", {"frequencies": (1.0,)}, 0, r"frequencies do not fit; expected the lower and the upper frequency"),
    ("lowpass", {"frequencies": (-1.0,)}, 0, r"bad frequency of the filter; expected above 0 Hz; found -1 Hz"),
    ("lowpass", {"frequencies": (1.0,), "channels": ("Tail",)}, 0, r"Tail"),
    (
        "lowpass",
        {"frequencies": (1.0,), "start": 70.0},
        0,
        r"there is no frame in its span; .*0 to 59; found 70 to inf",
    ),
    ("median", {"window": 0.2, "start": 30.0, "end": 20.0}, 0, r"there is no frame in its span; .*found 30 to 20"),
    ("waveshape", {"channels": ("LeftArm",)}, 0, r"no curve or two; expected either points or limits"),
    (
        "waveshape",
        {"channels": ("LeftArm",), "points": POINTS, "limits": (0.0, 1.0)},
        0,
        r"no curve or two; expected either points or limits",
    ),
    (
        "waveshape",
        {"channels": ("LeftArm",), "points": POINTS, "softness": 2.0},
        0,
        r"softness says nothing beside points",
    ),
    (
        "waveshape",
        {"channels": ("LeftArm",), "limits": (0.0, 90.0), "about": "rest"},
        0,
        r"about says nothing beside limits",
    ),
    ("shiftTime", {"from": (1.0, 2.0), "to": (1.0,)}, 0, r"from and to do not fit; .*; found 2 and 1 time codes"),
    (
        "scaleTime",
        {"end": 10.5},
        0,
        r"end is not at a frame of the motion; expected time codes from 0, 1 apart; found 10.5",
    ),
    ("scaleTime", {"end": -1.0}, 0, r"end is not at a frame of the motion; .*found -1"),
    ("scaleTime", {"ends": "loop"}, 0, r"nothing follows the motion, for there is no end\. Give end"),
    ("warpTime", {"from": (1.0, 2.0), "to": (1.0,)}, 0, r"from and to do not fit; .*in pairs; found 2 and 1"),
    ("warpTime", {"from": (), "to": ()}, 0, r"from and to do not fit"),
    ("warpTime", {"from": (0.0, 30.0), "to": (0.0, -1.0)}, 0, r"pairs of a time warp cross or coincide"),
    (
        "blend",
        {"weights": (1.0, 2.0)},
        1,
        r"weights do not fit; expected one for each of 1 other motions; found 2 weights",
    ),
    ("blend", {"weights": (1.0,), "keys": (1.0, 5.0)}, 1, r"weights do not fit; .*at each of 2 keys; found 1 weights"),
    ("blend", {"weights": (1.0, 0.0), "keys": (5.0, 5.0)}, 1, r"keys are not in order; expected time codes that rise"),
    (
        "join",
        {"from": (40.5,)},
        1,
        r"from is not at a frame of the motion; expected time codes from 0 to 59, 1 apart; found 40.5",
    ),
    ("join", {"to": (60.0,)}, 1, r"to is not at a frame of the motion; .*found 60"),
    ("join", {"from": (1.0, 2.0)}, 1, r"from and to do not fit; expected at most one time code each"),
    ("join", {"from": (40.0,), "start": 2.0}, 1, r"start and end say where to look, and from says it already"),
    (
        "displace",
        {"keys": (5.0,), "channels": ("LeftArm",)},
        0,
        r"no change, or two; expected either with, or rotations",
    ),
    (
        "displace",
        {"keys": (5.0,), "rotations": ((0.0, 0.0, 9.0),)},
        0,
        r"no joint is named; expected joints in channels",
    ),
    (
        "displace",
        {"keys": (5.0,), "channels": ARMS, "rotations": ((0.0, 0.0, 9.0),)},
        0,
        r"rotations do not fit; expected 2 for each of 1 keys, those of the first key first; found 1",
    ),
    ("displace", {"keys": (5.0,), "rotations": ((0.0, 0.0, 9.0),)}, 1, r"no change, or two"),
    (
        "displace",
        {"keys": (5.0,), "channels": ("LeftArm", "LeftArm"), "rotations": RAISED[:2]},
        0,
        r"a joint is named twice; expected every joint of channels once; found LeftArm, LeftArm",
    ),
    ("displace", {"keys": (5.0,), "channels": ("Tail",), "rotations": RAISED[:1]}, 0, r"Tail"),
    (
        "displace",
        {"keys": (5.0,), "channels": ("LeftArm",), "rotations": ((0.0, 0.0, 1e300),)},
        0,
        r"bad change of LeftArm at frame 5; expected three finite numbers, none beyond 1e\+09; found .*1e\+300",
    ),
    (
        "lowpass",
        {"frequencies": (1.0,), "end": 30.0, "ramp": 1e300},
        0,
        r"the fade is longer than the motion can fill; expected at most 5 s, twice the length of the motion; found 1e",
    ),
    ("displace", {"keys": (5.5,)}, 1, r"keys is not at a frame of the motion; .*found 5.5"),
    ("displace", {"keys": (), "channels": ARMS, "rotations": ()}, 0, r"no key; expected time codes in keys"),
    ("reduceKeys", {"keys": (5.5,)}, 0, r"keys is not at a frame of the motion; .*found 5.5"),
    ("reduceKeys", {"keys": (60.0,)}, 0, r"keys is not at a frame of the motion; .*found 60"),
]


@pytest.mark.parametrize(("op", "settings", "others", "message"), BAD)
def test_refusals_name_the_edit(op: str, settings: dict[str, Any], others: int, message: str) -> None:
    clip, *_ = make_clips()
    motions = [walk(FRAMES, seed=seed) for seed in range(2, 2 + others)]
    with pytest.raises(InputError, match=message) as caught:
        run(clip, op, *motions, **settings)
    assert str(caught.value).startswith(f"edit it ({op}): ")
    assert str(caught.value).count("edit it") == 1


def test_the_whole_stack_is_checked_before_anything_is_done() -> None:
    clip, _ = make_clips()
    edits = [make_edit("reduceKeys", name="few"), make_edit("lowpass", name="calm")]
    asked: list[tuple[object, ...]] = []

    def find(*said: object) -> tuple[int, ...]:
        asked.append(said)
        return ()

    with pytest.raises(InputError, match=r"edit calm \(lowpass\): frequencies is not said"):
        edit.run_stack(clip, edits, find_contacts=find)
    assert not asked


@pytest.mark.parametrize("op", OPERATIONS)
def test_every_setting_needed_is_missed(op: str) -> None:
    others = (make_clips()[1],) if OPERATIONS[op].others[0] else ()
    complete = dict.fromkeys(OPERATIONS[op].needs, ())
    check_edit(edit.Edit(name="e", op=op, settings=complete, others=others))
    for missing in complete:
        said = {name: value for name, value in complete.items() if name != missing}
        with pytest.raises(InputError, match=rf"edit e \({op}\): {missing} is not said"):
            check_edit(edit.Edit(name="e", op=op, settings=said, others=others))
