"""Walks whose pelvis and upper body are synthesized and whose legs are textured, with their feet held.

``python -m tests.benchmarks.constraints.walks`` sketches CMU walks, makes the first variant, and prints what became of
the feet: as texturing leaves them, with the feet restored by inverse kinematics, by inverse kinematics frame by frame
followed by a spline fit of the change (Lee and Shin 1999), and by the whole-motion solve that the tool uses.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_lsq_spline

from mtex_usd.constraints.contacts import detect_contacts
from mtex_usd.constraints.ik import Goal, solve_ik
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.planting import Hold, JointRange, held_back, hold_motion, plan_contacts, restore_feet
from mtex_usd.constraints.spacetime import Displacement, measure_energy_above
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import to_skeleton_rotations
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe
from tests.benchmarks.quality.cases import HELD_OUT, WALK, Fold, load_folds

FloatArray = npt.NDArray[np.float64]

FREQUENCY = 6.0
JOIN_FRAMES = 10
LIMITS_FILE = Path(__file__).with_name("limits_07.json")
_ROUNDING = 1e-9  # radians


@dataclass(frozen=True, kw_only=True)
class Figures:
    """What became of the feet.

    Parameters
    ----------
    slide_mm
        Farthest that a held point gets from its mean place.
    off_floor_mm
        Farthest from the height it is to have.
    change_deg
        Root mean square of the joints' change outside contacts, over joints that change.
    above
        Share of the change's energy above the frequency.
    border
        Largest acceleration of a joint near the borders of contacts, in the capture's largest.
    excess_deg
        Farthest that a joint is beyond its limits, or beyond what the motion had before where that was farther.
    """

    slide_mm: float
    off_floor_mm: float
    change_deg: float
    above: float
    border: float
    excess_deg: float


def find_folds(data_dir: Path, names: Sequence[str]) -> list[Fold]:
    """The folds of some captures of 07 and 91."""
    walks_91 = next(case for case in HELD_OUT if case.folder == "91_from_amc")
    folds = [fold for case in (WALK, walks_91) for fold in load_folds(case, data_dir)]
    return [fold for fold in folds if fold.truth.name in names]


def make_variant(fold: Fold) -> tuple[Clip, tuple[Hold, ...]]:
    """The first variant with the pelvis synthesized, and what is to be held."""
    rig, sketch = fold.case.rig, fold.sketch
    root = sketch.joints[0]
    holds = plan_contacts(detect_contacts(sketch), sketch)
    recipe = Recipe(
        match=fold.case.match,
        texture=rig.legs,
        synthesize=(f"{root}.r", *rig.synthesized),
        match_band=fold.case.band,
        paths=1,
    )
    held = held_back(holds, sketch.skeleton, frame_count=sketch.frame_count, ramp_frames=JOIN_FRAMES)
    return texture_motion(sketch, fold.takes, recipe, held=held).variants[0].clip, holds


def solve_lee_shin(clip: Clip, holds: Sequence[Hold]) -> Clip:
    """Inverse kinematics frame by frame, then a spline of the change with knots for the frequency."""
    goals = [_goal(clip, hold) for hold in holds]
    solved = solve_ik(clip, goals).clip
    change = quaternion.log(quaternion.multiply(quaternion.conjugate(clip.rotations), solved.rotations))
    frames = np.arange(clip.frame_count, dtype=float)
    inner = np.arange(2.0, clip.frame_count - 3.0, clip.rate / (2.0 * FREQUENCY))
    knots = np.concatenate([[0.0] * 4, inner, [frames[-1]] * 4])
    smooth = make_lsq_spline(frames, change.reshape(len(frames), -1), knots)(frames).reshape(change.shape)
    return replace(clip, rotations=quaternion.multiply(clip.rotations, quaternion.exp(smooth)))


def _goal(clip: Clip, hold: Hold) -> Goal:
    places = _track(clip, hold)
    place = places.mean(axis=0)
    up = clip.skeleton.up
    place = place + ((hold.height or 0.0) - place @ up) * up
    active = np.zeros(clip.frame_count, dtype=np.bool_)
    active[hold.frames] = True
    return Goal(joint=hold.joint, offset=hold.offset, place=np.tile(place, (clip.frame_count, 1)), active=active)


def _track(clip: Clip, hold: Hold) -> FloatArray:
    frames = hold.frames
    offset = np.asarray(hold.offset)[None]
    return place_points(clip.skeleton, [hold.joint], offset, clip.rotations[frames], clip.translations[frames])[:, 0]


def measure(clip: Clip, base: Clip, truth: Clip, holds: Sequence[Hold]) -> Figures:
    """Measure one motion against the one it was made from and the capture."""
    millimetres = 1000.0 * clip.skeleton.meters_per_unit
    tracks = [_track(clip, hold) for hold in holds]
    slides = [np.linalg.norm(track - track.mean(axis=0), axis=1).max() for track in tracks]
    heights = [np.abs(track @ clip.skeleton.up - hold.height).max() for track, hold in zip(tracks, holds, strict=True)]
    change = quaternion.log(quaternion.multiply(quaternion.conjugate(base.rotations), clip.rotations))
    change[:, np.abs(change).max(axis=(0, 2)) < _ROUNDING] = 0.0
    free = np.ones(clip.frame_count, dtype=np.bool_)
    for hold in holds:
        free[hold.frames] = False
    moved = np.abs(change).max(axis=(0, 2)) > 0.0
    outside = change[free][:, moved] if free.any() and moved.any() else np.zeros((1, 1, 3))
    displacement = Displacement(rotations=change, translation=np.zeros((clip.frame_count, 3)), root=-1)
    return Figures(
        slide_mm=float(max(slides) * millimetres),
        off_floor_mm=float(max(heights) * millimetres),
        change_deg=float(np.degrees(np.sqrt(np.mean(np.sum(outside**2, axis=-1))))),
        above=measure_energy_above(displacement, clip.rate, FREQUENCY),
        border=_border_acceleration(clip, holds) / float(_accelerations(truth).max()),
        excess_deg=_excess(clip, base),
    )


def read_limits(clip: Clip) -> tuple[JointRange, ...]:
    """Ranges of the legs' joints from the data file, about the skeleton's axes."""
    table = json.loads(LIMITS_FILE.read_text())["degrees"]
    names = [joint.rpartition("/")[2] for joint in clip.joints]
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    return tuple(
        JointRange(joint=names.index(name), axes=upright, lower=np.array(lower), upper=np.array(upper))
        for name, (lower, upper) in table.items()
        if name in names
    )


def _excess(clip: Clip, base: Clip) -> float:
    """How far joints go beyond their limits, degrees; -inf where there are none."""
    excess = [-np.inf]
    before, after = (to_skeleton_rotations(c.rotations, c.skeleton) for c in (base, clip))
    for limit in read_limits(clip):
        own, angles = (quaternion.to_euler(turns[:, limit.joint], "ZYX") for turns in (before, after))
        lower, upper = np.minimum(limit.lower, own.min(axis=0)), np.maximum(limit.upper, own.max(axis=0))
        excess.append(float(max((lower - angles).max(), (angles - upper).max())))
    return max(excess)


def _accelerations(clip: Clip) -> FloatArray:
    """Angular accelerations of all joints, degrees per second squared, [F - 2, J]."""
    turns = quaternion.multiply(quaternion.conjugate(clip.rotations[:-1]), clip.rotations[1:])
    steps = np.degrees(quaternion.log(turns)) * clip.rate
    return np.asarray(np.linalg.norm(np.diff(steps, axis=0), axis=-1) * clip.rate)


def _border_acceleration(clip: Clip, holds: Sequence[Hold]) -> float:
    near = {frame + shift - 1 for hold in holds for frame in (hold.first, hold.last) for shift in (-1, 0, 1)}
    rows = [row for row in near if 0 <= row < clip.frame_count - 2]
    return float(_accelerations(clip)[rows].max())


def compare(fold: Fold) -> dict[str, tuple[Figures, float]]:
    """Every way to treat the feet of one fold, with the seconds it took."""
    variant, holds = make_variant(fold)
    restored = restore_feet(variant, fold.sketch, holds)
    results = {
        "textured, feet as they come": (measure(variant, variant, fold.truth, holds), 0.0),
        "feet restored": (measure(restored, restored, fold.truth, holds), 0.0),
    }
    for name, solve in (
        ("per frame, then spline (Lee, Shin)", solve_lee_shin),
        (
            "whole motion",
            lambda clip, what: hold_motion(clip, what, frequency=FREQUENCY, limits=read_limits(clip)).clip,
        ),
    ):
        start = time.perf_counter()
        solved = solve(restored, holds)
        seconds = time.perf_counter() - start
        results[name] = (measure(solved, restored, fold.truth, holds), seconds)
    return results


def main() -> None:
    """Print one table per walk."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("names", nargs="*", default=["07_01", "07_03", "07_06", "91_02", "91_13"])
    given = parser.parse_args()
    for fold in find_folds(given.data, given.names):
        print(f"\n### {fold.truth.name}, {fold.truth.frame_count} frames\n")
        print("| feet | slide mm | off floor mm | change outside ° | % above 6 Hz | at borders | beyond limits ° | s |")
        print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
        for name, (figures, seconds) in compare(fold).items():
            numbers = [figures.slide_mm, figures.off_floor_mm, figures.change_deg, 100.0 * figures.above]
            numbers += [figures.border, max(figures.excess_deg, 0.0), seconds]
            print(f"| {name} | {' | '.join(f'{number:.2f}' for number in numbers)} |")


if __name__ == "__main__":
    main()
