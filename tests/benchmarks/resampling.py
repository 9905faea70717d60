"""How fast a clip is resampled, against a loop over frames and joints in one run, so that the machine does not matter.

``python -m tests.benchmarks.resampling`` brings 2,752 frames of 31 joints from 120 to 30 frames a second with
``resample_clip``, and with a loop in plain Python and numpy that weighs, for every new frame of every joint, the frames
under the same filter.
"""

import argparse
import sys
from collections.abc import Sequence

import numpy as np

from mtex_usd.edit import scale_time
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip
from tests.benchmarks.speed import Comparison, compare
from tests.oracle.resampling import low_pass_taps

__all__ = ["FRAMES", "LEAST_FACTOR", "compare_resampling", "main", "make_motion", "resample_in_a_loop"]

FRAMES = 2752
JOINTS = 31
LEAST_FACTOR = 50.0

_DOWN = 4
_SEED = 2000


def make_motion(frames: int = FRAMES) -> Clip:
    """A motion on a chain of joints, all turning smoothly, the first one moving."""
    joints = tuple("/".join(f"J{k}" for k in range(count + 1)) for count in range(JOINTS))
    noise = np.random.default_rng(_SEED)
    walk = 0.02 * np.cumsum(noise.standard_normal((frames, JOINTS, 3)), axis=0)
    translations = np.ones((frames, JOINTS, 3))
    translations[:, 0] = np.cumsum(noise.standard_normal((frames, 3)), axis=0)
    return Clip(
        skeleton=Skeleton(joints=joints, rest=np.tile(np.eye(4), (JOINTS, 1, 1))),
        rate=120.0,
        rotations=quaternion.unroll(quaternion.exp(walk)),
        translations=translations,
        scales=np.ones((frames, JOINTS, 3)),
    )


def resample_in_a_loop(clip: Clip) -> tuple[np.ndarray, np.ndarray]:
    """Rotations and translations at a quarter of the rate, one new frame of one joint at a time."""
    taps = np.array(low_pass_taps(1, _DOWN))
    half, last = len(taps) // 2, clip.frame_count - 1
    count = last // _DOWN + 1
    rotations, translations = np.empty((count, JOINTS, 4)), np.empty((count, JOINTS, 3))
    for frame in range(count):
        begin, end = max(frame * _DOWN - half, 0), min(frame * _DOWN + half + 1, last + 1)
        weights = taps[begin - frame * _DOWN + half : end - frame * _DOWN + half]
        for joint in range(JOINTS):
            for source, out in ((clip.rotations, rotations), (clip.translations, translations)):
                slope = (source[-1, joint] - source[0, joint]) / last
                line = source[0, joint] + slope * np.arange(begin, end)[:, None]
                value = weights @ (source[begin:end, joint] - line)
                out[frame, joint] = value + source[0, joint] + slope * frame * _DOWN
            rotations[frame, joint] /= np.linalg.norm(rotations[frame, joint])
    return rotations, translations


def compare_resampling(*, frames: int, runs: int) -> dict[str, Comparison]:
    """Time resampling, and speeding up by the same factor, against the loop."""
    clip = make_motion(frames)
    parts = {
        "resample_clip": lambda: resample_clip(clip, 30.0),
        "scale_time": lambda: scale_time(clip, factor=0.25),
    }
    return {what: compare(part, lambda: resample_in_a_loop(clip), runs=runs) for what, part in parts.items()}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print and judge; the exit code is 1 where resampling is not so many times faster."""
    parser = argparse.ArgumentParser(description="Measure the speed of resampling as a ratio.")
    parser.add_argument("--runs", type=int, default=7, help="runs of each that count (default: 7)")
    results = compare_resampling(frames=FRAMES, runs=parser.parse_args(arguments).runs)
    for what, found in results.items():
        factor = found.yardstick / found.measured
        print(f"{what} / loop over frames and joints: {1e3 * found.measured:.1f} ms / {1e3 * found.yardstick:.0f} ms")
        print(f"  {factor:.0f} times faster (least {LEAST_FACTOR:g}): {'ok' if factor >= LEAST_FACTOR else 'BELOW'}")
    return int(any(found.yardstick < LEAST_FACTOR * found.measured for found in results.values()))


if __name__ == "__main__":
    sys.exit(main())
