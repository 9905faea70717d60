"""Nonsense given to mtex_usd.edit, its clean-up and retarget: one clear InputError, soon, never a crash."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

from mtex_usd import constraints, edit
from mtex_usd.edit import cleaning
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import MOST_FRAMES
from tests.synthetic import walk

CLIP = walk(40)
OTHER = walk(40, seed=1)
KEY = edit.PoseChange(frame=10, rotations={"LeftArm": (0, 0, 30)})
LAYER = edit.Displacement(keys=[KEY], scope=5)
NAN, INF, HUGE = math.nan, math.inf, 10**5000


class Strange:
    """An object of no use."""


NOTHING = (None, Strange(), {}, {1, 2})
NUMBERS = (*NOTHING, "2", b"2", True, [1.0], np.ones(3), 1j, NAN)
WHOLE = (*NUMBERS, 2.5, -3, 10**9, HUGE)
WORDS = (*NOTHING, "bounce", 3, NAN, ["hold"], np.array(["hold", "loop"]))
TOKENS = (*NOTHING, "LeftArm", 5, ["Tail"], [3], [None], b"LeftArm", NAN, [["LeftArm"]])
ROWS = (*NOTHING, "x", 5, "12", [1], [[1, 2], [3]], [(0, 0, 0)], [("a", "b")], [(0, NAN), (1, 1)], [(0, 0), (1, None)])
CLIPS = (*NOTHING, "walk", 5, np.zeros((2, 3)), CLIP.skeleton)
TIMES = (*NUMBERS, INF, -INF, HUGE)
COMMON = {"clip": CLIPS, "channels": TOKENS, "ends": WORDS, "frame_count": tuple(v for v in WHOLE if v is not None)}

# By function: what works, and what does not for the parameters that are not common.
CASES = {
    edit.lowpass: ({"clip": CLIP, "frequency": 3.0}, {"frequency": (*NUMBERS, 0, -1), "order": (*WHOLE, 0, 17)}),
    edit.highpass: ({"clip": CLIP, "frequency": 3.0}, {"frequency": (*NUMBERS, -1, 12, INF), "order": (*WHOLE, 0)}),
    edit.bandpass: (
        {"clip": CLIP, "frequencies": (1.0, 3.0)},
        {"frequencies": (*NUMBERS, (3, 1), (1,), (NAN, 3), (1, NAN), "13", ("1", "3"), (-1, 2)), "order": (*WHOLE, 0)},
    ),
    edit.equalize: (
        {"clip": CLIP, "gains": [3.0]},
        {
            "gains": (*NOTHING, 3, "3", [NAN], [INF], ["3"], [[1.0]], [1e6], [1] * 50, [None]),
            "residual_gain": (*TIMES[:-2], HUGE, 1e6),
        },
    ),
    edit.median: ({"clip": CLIP, "window_s": 0.2}, {"window_s": (*TIMES, 0, -1, 1e300)}),
    edit.robust_mean: (
        {"clip": CLIP, "window_s": 0.2},
        {"window_s": (*TIMES, 0, -1, 1e300), "discard": (*TIMES, -0.1, 0.6)},
    ),
    edit.waveshape: (
        {"clip": CLIP, "points": [(0, 0), (1, 2)], "channels": ["LeftArm"]},
        {
            "points": (*ROWS, [(0, 0), (1e300, 1)], [(0, 0), (INF, 1)], [(0, 0)]),
            "about": WORDS,
            "channels": (*TOKENS, []),
        },
    ),
    edit.make_soft_limits: (
        {"lower": -10.0, "upper": 30.0, "softness": 5.0},
        {"lower": (*NUMBERS, 30, 25, INF), "upper": (*NUMBERS, -10, -INF), "softness": (*TIMES, 0, -1, 21)},
    ),
    edit.shift_time: ({"clip": CLIP, "shift_s": 0.2}, {"shift_s": (*TIMES, 1e300)}),
    edit.scale_time: ({"clip": CLIP, "factor": 1.5}, {"factor": (*TIMES, 0, -1, 1e9, 1e300, 5e-324)}),
    edit.warp_time: (
        {"clip": CLIP, "pairs": [(0, 0), (20, 30)]},
        {
            "pairs": (
                *ROWS,
                [],
                [(0, 0), (1, 10**9)],
                [(0, 0), (1e300, 1e300)],
                [(0, 10**8)],
                [(0, 0), (2, 0)],
                [(0, 0), (1e-300, 1)],
                [(-(10**9), 0), (10**9, 1)],
                [(0, 0), (INF, INF)],
            )
        },
    ),
    edit.align: (
        {"clip": CLIP, "reference": OTHER},
        {"reference": CLIPS, "max_slope": (*WHOLE, 0), "band_s": (*TIMES, 0, -1), "free_s": (*TIMES, -1, 5)},
    ),
    edit.blend: (
        {"clip": CLIP, "others": OTHER, "weights": 0.5},
        {
            "others": (*CLIPS, [], ["walk"], [None], [[OTHER]]),
            "weights": (*NOTHING, "a", "1", True, [True], [NAN], [0.1, 0.2], ["1"], INF, 1e300, HUGE, [[[1]]]),
            "place": WORDS,
        },
    ),
    edit.find_transition: (
        {"clip": CLIP, "other": OTHER},
        {
            "other": CLIPS,
            "window_s": (*TIMES, 0, -1, 1e5, 10),
            "frames": (*NOTHING[1:], 5, "03", (-5, 1000), (0, 40), (0.5, 20), (1, 2, 3), (30, 10), (None, 3)),
            "other_frames": ((-5, 1000), 5, ("0", "9"), (True, 20)),
        },
    ),
    edit.join: (
        {"clip": CLIP, "other": OTHER},
        {
            "other": CLIPS,
            "transition": (*NOTHING[1:], 5, (3, 4), edit.Transition(frame=99, other_frame=0, distance=0.0)),
            "blend_s": (*TIMES, 0, -1, 1e5, 1e300),
            "method": WORDS,
        },
    ),
    edit.displace: (
        {"clip": CLIP, "layers": LAYER},
        {
            "layers": (
                *(value for value in NOTHING if value != {}),
                5,
                "x",
                KEY,
                [KEY],
                [None],
                *(edit.Displacement(keys=keys) for keys in (None, 5, [5], "x", KEY)),
                *(edit.Displacement(keys=[KEY], scope=s) for s in ((1, 2, 3), "5", 0, NAN, INF, (5, -1), {}, [(1, 2)])),
                *(edit.Displacement(keys=[replace(KEY, frame=f)]) for f in (None, "3", NAN, INF, True, [3], 1e300)),
                *(
                    edit.Displacement(keys=[replace(KEY, rotations=r)])
                    for r in (None, 5, "x", [("LeftArm", (0, 0, 1))], {3: (0, 0, 1)}, {"Tail": (0, 0, 1)})
                ),
                *(
                    edit.Displacement(keys=[replace(KEY, rotations={"LeftArm": vector})])
                    for vector in (None, 5, "123", (1, 2), (1, 2, NAN), (1, 2, INF), (1, 2, 1e300), ("1", "2", "3"))
                ),
            )
        },
    ),
    edit.mirror: ({"clip": CLIP}, {"plane": WORDS}),
    edit.TimeWarp: ({"pairs": [(0, 0)]}, {"pairs": ROWS}),
    edit.PoseChange.to_pose: (
        {"clip": CLIP, "frame": 3, "rotations": CLIP.rotations[0], "translations": CLIP.translations[0]},
        {
            "frame": WHOLE,
            "rotations": (*ROWS, CLIP.rotations, CLIP.rotations[0] * NAN),
            "translations": (*ROWS[1:], CLIP.rotations[0]),
        },
    ),
    edit.PoseChange.to_clip: (
        {"clip": CLIP, "target": OTHER, "frame": 3},
        {"target": CLIPS, "frame": WHOLE, "target_frame": tuple(value for value in WHOLE if value is not None)},
    ),
    constraints.retarget: (
        {"clip": CLIP, "onto": OTHER},
        {
            "onto": CLIPS[:-1],
            "pairs": (
                *(v for v in NOTHING if v != {}),
                5,
                "ab",
                ["ab"],
                [5],
                ["a", "b"],
                [("Hips",)],
                [("a", "b", "c")],
                [("Hips", None)],
                [(1, 2)],
                {"Hips": "Hips"},
                [("Tail", "Hips")],
            ),
        },
    ),
    cleaning.clean_clip: (
        {"clip": CLIP, "steps": ["flips"]},
        {"steps": (*NOTHING[:3], "flips", 5, ["bounce"], [3]), "floor_height": ()},
    ),
    cleaning.fill_gaps: (
        {"clip": CLIP},
        {"longest_s": (*TIMES, -1), "fewest_held": (*WHOLE[:-2], 0), "least_deg": (*TIMES, -1)},
    ),
    cleaning.repair_flips: ({"clip": CLIP}, {"jump_deg": (*TIMES, 0), "longest_s": (*TIMES, -1)}),
    cleaning.repair_spikes: (
        {"clip": CLIP},
        {
            "least_deg": (*TIMES, -1),
            "least_size": (*TIMES, -1),
            "window_s": (*TIMES, 0, 1e9),
            "spike_filter": WORDS,
        },
    ),
    cleaning.report_floor: ({"clip": CLIP}, {"height": TIMES, "least_size": (*TIMES, -1)}),
    cleaning.report_jumps: ({"clip": CLIP}, {"least_size": (*TIMES, -1), "least_deg": (*TIMES, -1)}),
    cleaning.smooth_noise: ({"clip": CLIP}, {"cutoff_hz": (*NUMBERS, 0, -1), "keep_s": (*TIMES, -1, 1e9)}),
    cleaning.trim_leading: ({"clip": CLIP}, {"least_deg": (*TIMES, -1), "times_usual": (*TIMES, -1)}),
}
OPTIONAL = {"frames", "other_frames", "transition", "frame_count", "target_frame", "translations"}


def list_wrong():
    """Every function with everything right but one value."""
    for function, (good, bad) in CASES.items():
        common = {name: values for name, values in COMMON.items() if name in good or name in _options(function)}
        for name, values in (common | bad).items():
            for number, value in enumerate(values):
                if value is None and name in OPTIONAL:
                    continue
                yield pytest.param(function, {**good, name: value}, id=f"{function.__name__}-{name}-{number}")


def _options(function):
    return function.__init__.__kwdefaults__ or {} if isinstance(function, type) else function.__kwdefaults__ or {}


@pytest.mark.parametrize(("function", "given"), list(list_wrong()))
def test_nonsense_is_refused_with_a_reason(function, given):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError) as caught:
            function(**given)
    assert caught.value.message
    assert caught.value.expected or caught.value.found or caught.value.fix
    assert len(str(caught.value)) < 700


@pytest.mark.parametrize("function", CASES, ids=lambda function: function.__name__)
def test_what_makes_sense_is_not_refused(function):
    assert function(**CASES[function][0]) is not None


@pytest.mark.parametrize("function", [edit.lowpass, edit.blend, edit.join, edit.mirror, edit.displace, edit.shift_time])
def test_gaps_are_refused_with_what_to_do(function):
    rotations = np.array(CLIP.rotations)
    rotations[3, 2] = np.nan
    with pytest.raises(InputError, match=r"/Take has gaps; expected finite numbers.*Fill them first"):
        function(**{**CASES[function][0], "clip": replace(CLIP, rotations=rotations)})


@pytest.mark.parametrize("ends", ["hold", "loop", "extrapolate"])
@pytest.mark.parametrize("shift_s", [1e6, -1e6, 123456.789])
def test_a_shift_of_days_takes_no_more_memory_than_a_short_one(ends, shift_s):
    shifted = edit.shift_time(CLIP, shift_s=shift_s, ends=ends)
    assert shifted.frame_count == CLIP.frame_count
    assert np.isfinite(shifted.rotations).all()
    assert np.isfinite(shifted.translations).all()


def test_numbers_of_numpy_and_tuples_are_as_good_as_lists():
    plain = edit.scale_time(CLIP, factor=2, frame_count=50, channels=["LeftArm"][:0])
    numpy = edit.scale_time(CLIP, factor=np.float32(2), frame_count=np.int64(50), channels=())
    np.testing.assert_array_equal(plain.rotations, numpy.rotations)
    gains = edit.equalize(CLIP, gains=np.array([3, 0]), channels=iter(["LeftArm"]))
    np.testing.assert_array_equal(gains.rotations, edit.equalize(CLIP, gains=(3.0,), channels=["LeftArm"]).rotations)


def test_as_many_frames_as_there_may_be():
    short = walk(2)
    assert edit.scale_time(short, factor=0.5, frame_count=MOST_FRAMES).frame_count == MOST_FRAMES
    with pytest.raises(InputError, match=f"bad frame count.*at most {MOST_FRAMES}; found {MOST_FRAMES + 1}"):
        edit.scale_time(short, factor=0.5, frame_count=MOST_FRAMES + 1)
    with pytest.raises(
        InputError, match=r"too many frames; expected at most 200000 frames in the result; found 3.9e\+10"
    ):
        edit.scale_time(CLIP, factor=1e9)
