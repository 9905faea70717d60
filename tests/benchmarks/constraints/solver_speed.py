"""How fast the spacetime solve is, as ratios within one run, so that the machine does not matter.

``python -m tests.benchmarks.constraints.solver_speed`` prints

- the solve of a short window against SLSQP of scipy.optimize with dense matrices, on the same splines and to the same
  optimum;
- seconds for 100 to 10,000 frames of the same steps with planted feet, and the power of the frames that fits them;
- moving one of 200 constraints of a solved motion of 300 frames and 31 joints, and solving its neighbourhood, against
  solving the whole.

Linear algebra on blocks this small gains nothing from several threads and suffers where other programs want the cores,
so run it with ``OMP_NUM_THREADS=1`` on a busy machine.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mtex_usd.constraints.spacetime import Point, PointAt, PointStill, Solution, resolve_near, solve_spacetime
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from tests.oracle import spacetime as twin
from tests.spacetime_support import follow
from tests.synthetic import LEFT_FOREARM, LEFT_KNEE, POSITIONS, RIGHT_KNEE, make_skeleton, walk

__all__ = [
    "LEAST_NEAR_RATIO",
    "LEAST_SPEEDUP",
    "MOST_POWER",
    "Near",
    "Speedup",
    "compare_near",
    "compare_with_scipy",
    "fit_power",
    "main",
    "time_lengths",
]

LEAST_SPEEDUP = 50.0
LEAST_NEAR_RATIO = 20.0
MOST_POWER = 1.15
HUNDREDS = (1, 3, 10, 30, 100)

_CM = 0.01
_HAND = Point(LEFT_FOREARM, (25.0, 0.0, 0.0))
_FEET = tuple(Point(joint, (0.0, -45.0, 0.0)) for joint in (LEFT_KNEE, RIGHT_KNEE))
_STRIDE = 27
_STRETCH = 100  # frames
_EXACT = 1e-7  # metres: within a tolerance there is a cheaper motion, which SLSQP does not look for


@dataclass(frozen=True, kw_only=True)
class Speedup:
    """Seconds of both, and how far the two results are apart, relative to the largest change."""

    ours_s: float
    theirs_s: float
    apart: float

    @property
    def ratio(self) -> float:
        """How many times faster ours is."""
        return self.theirs_s / self.ours_s


@dataclass(frozen=True, kw_only=True)
class Near:
    """Seconds of the whole and of the neighbourhood."""

    whole_s: float
    near_s: float
    constraint_count: int
    joint_count: int

    @property
    def ratio(self) -> float:
        """How many times faster the neighbourhood is."""
        return self.whole_s / self.near_s


def _timed(function: Callable[[], Solution], runs: int) -> tuple[float, Solution]:
    best, result = np.inf, None
    for _ in range(runs):
        start = time.perf_counter()
        result = function()
        best = min(best, time.perf_counter() - start)
    assert result is not None
    return best, result


def compare_with_scipy(frames: int = 16) -> Speedup:
    """Solve a reach and a planted foot both ways."""
    clip = walk(frames)
    held, place = np.arange(4, 9), follow(clip, _HAND)[10] + 5.0
    wishes = [
        PointAt("hand", _HAND, [10], place, tolerance=_EXACT),
        PointStill("foot", _FEET[0], held, tolerance=_EXACT),
    ]
    ours_s, solution = _timed(lambda: solve_spacetime(clip, wishes), 5)
    (character,) = solution.memory.cast.characters
    motion = twin.Motion(
        parents=clip.parents.tolist(),
        rotations=clip.rotations,
        translations=_CM * clip.translations,
        turning=list(character.turning),
        root=0,
    )
    joints = [clip.joints.index(point.joint) for point in (_HAND, _FEET[0])]
    constraints = [
        ("at", joints[0], _CM * np.array(_HAND.offset), [10], _CM * place),
        ("still", joints[1], _CM * np.array(_FEET[0].offset), held),
    ]
    weights = solution.memory.cast.weights
    start = time.perf_counter()
    coefficients, _, _ = twin.solve(
        motion, constraints, solution.memory.knots.extended, weights, smoothness=30.0, cycles_per_frame=0.25
    )
    theirs_s = time.perf_counter() - start
    difference = np.abs(solution.memory.knots.matrix @ (coefficients - solution.memory.coefficients)).max()
    largest = np.abs(solution.memory.knots.matrix @ coefficients).max()
    return Speedup(ours_s=ours_s, theirs_s=theirs_s, apart=float(difference / largest))


def _plant(first: int, side: int) -> PointStill:
    begin = first + 13 * side
    return PointStill(f"{side} {first}", _FEET[side], np.arange(begin, begin + 10))


def _steps(frames: int) -> list[PointStill]:
    """Plant each foot once per stride."""
    return [_plant(first, side) for first in range(2, frames - _STRIDE, _STRIDE) for side in (0, 1)]


def _repeat(clip: Clip, times: int) -> Clip:
    """Give the same stretch again and again, each where the last ended."""
    step = clip.translations[-1, 0] - clip.translations[0, 0]
    translations = np.tile(clip.translations, (times, 1, 1))
    translations[:, 0] += np.repeat(np.arange(times), clip.frame_count)[:, None] * step
    rotations, scales = (np.tile(values, (times, 1, 1)) for values in (clip.rotations, clip.scales))
    return replace(clip, rotations=rotations, translations=translations, scales=scales)


def time_lengths(hundreds: Sequence[int]) -> dict[int, float]:
    """Seconds for walks of so many hundreds of frames, by their frames.

    All are the same stretch again and again, so that what is measured is the length: where nothing repeats, a longer
    walk also has harder steps and takes more iterations.
    """
    stretch = walk(_STRETCH)
    firsts = [(first, side) for first in range(2, _STRETCH - _STRIDE, _STRIDE) for side in (0, 1)]
    out = {}
    for times in hundreds:
        clip = _repeat(stretch, times)
        steps = [_plant(_STRETCH * number + first, side) for number in range(times) for first, side in firsts]
        out[clip.frame_count], _ = _timed(lambda clip=clip, steps=steps: solve_spacetime(clip, steps), 1)
    return out


def fit_power(seconds: dict[int, float]) -> float:
    """Fit the power of the frames that the seconds grow with: 1 where they are linear."""
    slope, _ = np.polyfit(np.log(list(seconds)), np.log(list(seconds.values())), 1)
    return float(slope)


def _big_walk(frames: int, joint_count: int) -> tuple[Clip, list[str]]:
    """A walk on the humanoid with fingers of two bones added at the hands until there are enough joints."""
    positions, fingers = dict(POSITIONS), []
    hands = [joint for joint in POSITIONS if joint.endswith("ForeArm")]
    while len(positions) < joint_count:
        hand = hands[len(fingers) % 2]
        x, y, z = positions[hand]
        side = 25.0 if x > 0.0 else -25.0
        first = f"{hand}/Finger{len(fingers)}"
        positions[first] = (x + side, y, z + len(fingers) - 5.0)
        fingers.append(first)
        if len(positions) < joint_count:
            last = f"{first}/Tip"
            positions[last] = (x + 1.3 * side, y, z + len(fingers) - 5.0)
            fingers[-1] = last
    skeleton = make_skeleton(tuple(positions), positions=positions)
    return walk(frames, skeleton=skeleton), fingers


def compare_near(frames: int = 300, joint_count: int = 31, constraint_count: int = 200) -> Near:
    """Move one fingertip of many, and solve its neighbourhood."""
    rng = np.random.default_rng(0)
    clip, fingers = _big_walk(frames, joint_count)
    wishes: list[PointAt | PointStill] = list(_steps(frames))
    for number in range(constraint_count - len(wishes)):
        point, frame = Point(fingers[number % len(fingers)]), 5 + (number * 37) % (frames - 10)
        place = follow(clip, point)[frame] + rng.uniform(-2.0, 2.0, 3)
        wishes.append(PointAt(f"touch {number}", point, [frame], place))
    whole_s, solution = _timed(lambda: solve_spacetime(clip, wishes), 1)
    chosen = min(
        (wish for wish in wishes if isinstance(wish, PointAt)), key=lambda wish: abs(wish.frames[0] - frames // 2)
    )
    moved = replace(chosen, place=np.asarray(chosen.place) + np.array([2.0, 2.0, 0.0]))
    near_s, near = _timed(lambda: resolve_near(solution, moved), 3)
    assert max(near.residuals.values()) <= 1e-4
    turned = quaternion.angle_between(near.clips[0].rotations, solution.clips[0].rotations)
    assert turned.max() > 0.01
    return Near(whole_s=whole_s, near_s=near_s, constraint_count=len(wishes), joint_count=len(clip.joints))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print all three."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--longest", type=int, default=HUNDREDS[-1], help="hundreds of frames of the longest walk")
    options = parser.parse_args(arguments)
    speedup = compare_with_scipy()
    print(
        f"against SLSQP: {speedup.ours_s:.3f} s and {speedup.theirs_s:.2f} s, {speedup.ratio:.0f} times as fast "
        f"(at least {LEAST_SPEEDUP:.0f}); results {speedup.apart:.1e} of the change apart (at most 1e-3)"
    )
    seconds = time_lengths([times for times in HUNDREDS if times <= options.longest])
    for frames, elapsed in seconds.items():
        print(f"{frames:6d} frames {elapsed:8.3f} s {1e3 * elapsed / frames:8.3f} ms per frame")
    print(f"seconds grow with the frames to the power {fit_power(seconds):.3f} (at most {MOST_POWER})")
    longest = max(seconds)
    varied, _ = _timed(lambda: solve_spacetime(walk(longest), _steps(longest)), 1)
    print(f"{longest:6d} frames {varied:8.3f} s {1e3 * varied / longest:8.3f} ms per frame where nothing repeats")
    near = compare_near()
    print(
        f"one of {near.constraint_count} constraints moved, {near.joint_count} joints: whole {near.whole_s:.2f} s, "
        f"neighbourhood {near.near_s:.3f} s, {near.ratio:.0f} times as fast (at least {LEAST_NEAR_RATIO:.0f})"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
