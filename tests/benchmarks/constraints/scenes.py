"""Gleicher's examples on captured motion: a raised step, a door knob, other bodies, a box, a jump, partners.

``python -m tests.benchmarks.constraints.scenes [--pictures FOLDER]`` solves each and prints how exactly its constraints
are met, how much the motion changes, and how long it took.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.contacts import detect_contacts
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.planting import Hold, plan_contacts, retarget_with_contacts, to_constraints
from mtex_usd.constraints.spacetime import (
    Constraint,
    DistanceBetween,
    MassOver,
    Point,
    PointAt,
    Solution,
    measure_energy_above,
    solve_spacetime,
)
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from tests.benchmarks.constraints.drawing import draw_scene
from tests.benchmarks.quality.cases import METERS_PER_UNIT, load_captures, to_clip

FloatArray = npt.NDArray[np.float64]

STEP_M = 0.2
ROOT_WEIGHT = 3.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """What was solved.

    Parameters
    ----------
    name
        What tables call it.
    before, after
        The motions, one per character.
    solution
        What the solve says.
    seconds
        What it took.
    remark
        What this scene is about, measured.
    """

    name: str
    before: tuple[Clip, ...]
    after: tuple[Clip, ...]
    solution: Solution
    seconds: float
    remark: str


def read_capture(data_dir: Path, name: str) -> Clip:
    """One capture at 24 frames/s, in units of 0.05644 m."""
    folder = "91_from_amc" if name.startswith("91") else name[:2]
    return to_clip(load_captures(data_dir / "cmu_bvh" / folder, [name])[name])


def _plan(clip: Clip) -> tuple[Hold, ...]:
    return plan_contacts(detect_contacts(clip), clip)


def _track(clip: Clip, joint: int, offset: FloatArray, frames: npt.NDArray[np.intp]) -> FloatArray:
    """Where a point is, skeleton units, [N, 3]."""
    given = np.asarray(offset, dtype=float)[None]
    return place_points(clip.skeleton, [joint], given, clip.rotations[frames], clip.translations[frames])[:, 0]


def _joint(clip: Clip, name: str) -> int:
    return next(i for i, joint in enumerate(clip.joints) if joint.rpartition("/")[2] == name)


def _solve(
    name: str,
    clips: Sequence[Clip],
    constraints: Sequence[Constraint],
    remark: Callable[[Solution], str],
    **options: float,
) -> Scene:
    start = time.perf_counter()
    solution = solve_spacetime(list(clips), constraints, **{"translation_weight": ROOT_WEIGHT, **options})
    seconds = time.perf_counter() - start
    return Scene(
        name=name,
        before=tuple(clips),
        after=solution.clips,
        solution=solution,
        seconds=seconds,
        remark=remark(solution),
    )


def raise_step(data_dir: Path) -> Scene:
    """One footstep of 07_01 is 20 cm higher, onto a step."""
    walk = read_capture(data_dir, "07_01")
    holds = _plan(walk)
    step = next(h for h in holds if h.name.startswith("left.toes") and h.first > 10)
    raised = [h for h in holds if h.name.startswith("left") and h.first <= step.last and h.last >= step.first]
    up = STEP_M / METERS_PER_UNIT
    changed = [replace(h, height=(h.height or 0.0) + up) if h in raised else h for h in holds]

    def remark(solution: Solution) -> str:
        after = solution.clips[0]
        slides = [np.ptp(_track(after, h.joint, h.offset, h.frames), axis=0).max() for h in raised]
        moved = np.abs(after.rotations - walk.rotations).max(axis=(1, 2)) > 0.01
        frames = np.flatnonzero(moved)
        return (
            f"raised foot moves {1000 * METERS_PER_UNIT * max(slides):.2f} mm in its contact; frames that change by "
            f"more than a degree: {frames.min()} to {frames.max()} of {walk.frame_count}"
        )

    return _solve("a step 20 cm higher", [walk], to_constraints(changed, walk), remark)


def reach_knob(data_dir: Path) -> Scene:
    """A hand reaches a door knob at the last frame of a walk; the feet stay planted."""
    walk = read_capture(data_dir, "07_01")
    last = walk.frame_count - 1
    hand = _joint(walk, "RightHand")
    own = _track(walk, hand, np.zeros(3), np.array([last]))[0]
    forward = walk.translations[last, 0] - walk.translations[last - 10, 0]
    forward[1] = 0.0
    knob = (
        own + 0.25 / METERS_PER_UNIT * forward / np.linalg.norm(forward) + np.array([0.0, 0.2, 0.0]) / METERS_PER_UNIT
    )
    reach = PointAt("knob", Point("RightHand"), [last], knob)

    def remark(solution: Solution) -> str:
        gap = np.linalg.norm(_track(solution.clips[0], hand, np.zeros(3), np.array([last]))[0] - knob)
        moved = np.linalg.norm(knob - own)
        return f"the hand is {1000 * METERS_PER_UNIT * gap:.2f} mm off, moved {METERS_PER_UNIT * moved:.2f} m"

    return _solve("a door knob", [walk], [*to_constraints(_plan(walk), walk), reach], remark)


def _scale_body(skeleton: Skeleton, factor: Callable[[str], float]) -> Skeleton:
    """The same skeleton with bones of other lengths, by the joint's last name."""
    rest = np.array(skeleton.rest)
    rest[:, 3, :3] *= np.array([factor(joint.rpartition("/")[2]) for joint in skeleton.joints])[:, None]
    return replace(skeleton, rest=rest)


_SHORT = ("ltibia", "lfoot", "rtibia", "rfoot", "lradius", "lwrist", "rradius", "rwrist")
_LONG = ("upperback", "thorax", "lowerneck")


def other_bodies(data_dir: Path) -> list[Scene]:
    """91_01 on a body of 60 %, and on one with short legs and arms and a long trunk."""
    walk = read_capture(data_dir, "91_01")
    bodies = {
        "a body of 60 %": _scale_body(walk.skeleton, lambda _: 0.6),
        "short limbs, long trunk": _scale_body(
            walk.skeleton, lambda name: 0.55 if name in _SHORT else 1.5 if name in _LONG else 1.0
        ),
    }
    return [_retarget(walk, name, body) for name, body in bodies.items()]


def _retarget(walk: Clip, name: str, body: Skeleton) -> Scene:
    start = time.perf_counter()
    held = retarget_with_contacts(walk, body)
    seconds = time.perf_counter() - start
    if held.solution is None:
        raise RuntimeError("the walk has contacts")
    foot, origin = _joint(walk, "lfoot"), np.zeros(3)
    lifts = [np.ptp(_track(clip, foot, origin, np.arange(clip.frame_count))[:, 1]) for clip in (walk, held.clip)]
    remark = f"the foot is lifted {lifts[1] / lifts[0]:.2f} times as high"
    return Scene(name=name, before=(walk,), after=(held.clip,), solution=held.solution, seconds=seconds, remark=remark)


def carry_box(data_dir: Path) -> list[Scene]:
    """Both hands on a box that stands, is lifted and set down, on three bodies, with and without balance."""
    walk = read_capture(data_dir, "91_01")
    part = np.arange(0, 72)
    still = replace(
        walk, rotations=walk.rotations[part], translations=walk.translations[part], scales=walk.scales[part]
    )
    scenes = []
    for name, factor in (("an adult", 1.0), ("a body of 60 %", 0.6), ("a giant", 1.4)):
        body = _scale_body(still.skeleton, lambda _, factor=factor: factor)  # type: ignore[misc]
        clip = retarget_with_contacts(still, body).clip
        scenes += [_carry(clip, name, balance=balance) for balance in (False, True)]
    return scenes


def _carry(clip: Clip, name: str, *, balance: bool) -> Scene:
    frames = np.arange(20, 56)
    hips = clip.skeleton.joint_positions([0], clip.rotations, clip.translations)[frames, 0]
    leg = np.linalg.norm(clip.skeleton.rest_translations[[_joint(clip, "ltibia"), _joint(clip, "lfoot")]], axis=1).sum()
    left, right = _joint(clip, "lwrist"), _joint(clip, "rwrist")
    across = (_track(clip, left, np.zeros(3), frames) - _track(clip, right, np.zeros(3), frames)).mean(axis=0)
    across[1] = 0.0
    across /= np.linalg.norm(across)
    front = np.cross(across, clip.skeleton.up)
    lift = np.sin(np.pi * np.arange(len(frames)) / (len(frames) - 1))[:, None] * 0.35 * leg * clip.skeleton.up
    place = hips[0] + 0.45 * leg * front - 0.1 * leg * clip.skeleton.up + lift
    width = 0.4 * leg
    constraints: list[Constraint] = [
        *to_constraints(_plan(clip), clip),
        PointAt("left hand on the box", Point("lwrist"), frames, place + 0.5 * width * across),
        DistanceBetween("hands", Point("lwrist"), Point("rwrist"), frames, width),
        PointAt("right hand on the box", Point("rwrist"), frames[[0, -1]], place[[0, -1]] - 0.5 * width * across),
    ]
    if balance:
        constraints.append(_over_feet(clip, frames))

    def remark(solution: Solution) -> str:
        after = solution.clips[0]
        gap = np.linalg.norm(
            _track(after, left, np.zeros(3), frames) - _track(after, right, np.zeros(3), frames), axis=1
        )
        return f"hands {1000 * METERS_PER_UNIT * np.abs(gap - width).max():.2f} mm from their distance"

    return _solve(f"a box, {name}, {'balanced' if balance else 'no balance'}", [clip], constraints, remark)


def _over_feet(clip: Clip, frames: npt.NDArray[np.intp]) -> MassOver:
    """Keep the centre of mass over heels and toes."""
    corners = []
    for foot, toes in (("lfoot", "ltoes"), ("rfoot", "rtoes")):
        ankle, tip = (_track(clip, _joint(clip, j), np.zeros(3), frames).mean(axis=0) for j in (foot, toes))
        corners += [ankle - 0.3 * (tip - ankle), tip]
    return MassOver("balance", np.array(corners), frames)


def jump_higher(data_dir: Path) -> Scene:
    """A jump of 01_01 twice as high, take-off and landing where they were."""
    whole = read_capture(data_dir, "01_01")
    part = np.arange(195, 300)
    clip = replace(
        whole, rotations=whole.rotations[part], translations=whole.translations[part], scales=whole.scales[part]
    )
    holds = _plan(clip)
    heights = clip.translations[:, 0] @ clip.skeleton.up
    top = int(np.argmax(heights))
    before = max(h.last for h in holds if h.last < top)
    after = min(h.first for h in holds if h.first > top)
    base = np.interp(top, [before, after], heights[[before, after]])
    rise = heights[top] - base
    wanted = clip.translations[top, 0] + rise * clip.skeleton.up
    constraints = [*to_constraints(holds, clip), PointAt("the top", Point("Hips"), [top], wanted)]

    def remark(solution: Solution) -> str:
        reached = solution.clips[0].translations[top, 0] @ clip.skeleton.up - base
        return f"rises {METERS_PER_UNIT * reached:.2f} m over take-off, before {METERS_PER_UNIT * rise:.2f} m"

    return _solve("a jump twice as high", [clip], constraints, remark)


def hold_hands(data_dir: Path) -> list[Scene]:
    """Two characters of one dance a hand's distance apart for a while, one of 80 %, solved on one and on both."""
    first = read_capture(data_dir, "05_02")
    frames = np.arange(60, 160)
    first = replace(
        first, rotations=first.rotations[frames], translations=first.translations[frames], scales=first.scales[frames]
    )
    small = retarget_with_contacts(first, _scale_body(first.skeleton, lambda _: 0.8)).clip
    moved = np.array(small.translations)
    moved[:, 0] += np.array([0.0, 0.0, 0.7]) / METERS_PER_UNIT
    second = replace(small, translations=moved)
    together = np.arange(30, 60)
    touch = DistanceBetween(
        "hands", Point("LeftHand", clip=0), Point("RightHand", clip=1), together, 0.1 / METERS_PER_UNIT
    )
    return [
        _solve(name, [first, second], [touch], _measure_gap(together), fixed=fixed)  # type: ignore[arg-type]
        for name, fixed in (("partners, one gives way", (0,)), ("partners, both give way", ()))
    ]


def _measure_gap(frames: npt.NDArray[np.intp]) -> Callable[[Solution], str]:
    """Say how far two hands are from a tenth of a metre apart."""

    def remark(solution: Solution) -> str:
        hands = [
            _track(clip, _joint(clip, joint), np.zeros(3), frames)
            for clip, joint in zip(solution.clips, ("LeftHand", "RightHand"), strict=True)
        ]
        gap = np.linalg.norm(hands[0] - hands[1], axis=1)
        return f"hands {1000 * np.abs(METERS_PER_UNIT * gap - 0.1).max():.2f} mm from their distance"

    return remark


def shrink(data_dir: Path) -> Scene:
    """A walker shrinks to 60 % while turning, toes planted: heel and toes of a shrinking foot cannot both stay."""
    walk = read_capture(data_dir, "91_01")
    part = np.arange(100, 260)
    walk = replace(walk, rotations=walk.rotations[part], translations=walk.translations[part], scales=walk.scales[part])
    share = np.interp(np.arange(len(part)), [40, 120], [1.0, 0.6])
    translations = np.array(walk.translations)
    translations[:, 1:] *= share[:, None, None]
    translations[:, 0, 1] *= share
    shrinking = replace(walk, translations=translations)
    toes = [hold for hold in _plan(walk) if "toes" in hold.name]
    holds = [replace(hold, height=(hold.height or 0.0) * float(share[hold.frames].mean())) for hold in toes]

    def remark(solution: Solution) -> str:
        slides = [np.ptp(_track(solution.clips[0], h.joint, h.offset, h.frames), axis=0).max() for h in holds]
        return f"planted points move {1000 * METERS_PER_UNIT * max(slides):.2f} mm"

    return _solve("shrinking to 60 %", [shrinking], to_constraints(holds, shrinking), remark)


def all_scenes(data_dir: Path) -> list[Scene]:
    """Every scene."""
    return [
        raise_step(data_dir),
        reach_knob(data_dir),
        *other_bodies(data_dir),
        *carry_box(data_dir),
        jump_higher(data_dir),
        *hold_hands(data_dir),
        shrink(data_dir),
    ]


def main() -> None:
    """Print one row per scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--pictures", type=Path)
    given = parser.parse_args()
    print("| scene | constraints | worst mm | energy above 6 Hz | largest turn ° | s | |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
    for scene in all_scenes(given.data):
        displacement = scene.solution.displacements[-1]
        above = max(measure_energy_above(d, scene.after[0].rate, 6.0) for d in scene.solution.displacements)
        turn = np.degrees(np.linalg.norm(displacement.rotations, axis=-1)).max()
        worst = 1000.0 * max(scene.solution.residuals.values())
        print(
            f"| {scene.name} | {len(scene.solution.residuals)} | {worst:.2f} | {above:.4f} | {turn:.1f} | "
            f"{scene.seconds:.1f} | {scene.remark} |"
        )
        if given.pictures:
            given.pictures.mkdir(parents=True, exist_ok=True)
            draw_scene(scene.before, scene.after, given.pictures / f"{scene.name.replace(' ', '_')}.png")


if __name__ == "__main__":
    main()
