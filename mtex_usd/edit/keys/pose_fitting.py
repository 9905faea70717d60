"""Where sparse poses go, and what they are: a piecewise slerp near a motion, with keys all joints have in common."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.body import Body, read_body
from mtex_usd.edit.keys.difference import measure_difference
from mtex_usd.edit.keys.refining import Goal, Refiner, Spans
from mtex_usd.edit.keys.sampled import play_between, slerp
from mtex_usd.edit.keys.stretches import measure_stretches
from mtex_usd.edit.keys.tolerance import Tolerance
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip

__all__ = ["PoseSearch", "Poses", "play_poses"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

_CHECKED = 4  # times a frame the result is looked at
_MARGIN = 0.9995  # of the tolerance at frames: between them a little more may be off
_ROUNDS = 100
_PATHS = 24
_KEY_PRICE = 6.0
_DEARER = 2.0
_STEPS = 30
_HALVINGS = 10


@dataclass(frozen=True, eq=False)
class Poses:
    """N poses of all joints.

    Parameters
    ----------
    frames
        Where they are, shape [N].
    rotations, translations, scales
        Shapes [N, J, 4], [N, J, 3] and [N, J, 3].
    """

    frames: IntArray
    rotations: FloatArray
    translations: FloatArray
    scales: FloatArray

    def take_over(self, body: Body, clip: Clip, joints: IntArray, keys: BoolArray) -> "Poses":
        """Put other turns and arms of joints in place of those of some keys; what never moves keeps its bits.

        Parameters
        ----------
        body
            Turns and arms of all joints at all N keys.
        clip
            The clip the poses are of.
        joints
            Whose are taken.
        keys
            Which keys, shape [N].
        """
        rotations, translations = np.array(self.rotations), np.array(self.translations)
        turned, moved = body.to_local(clip.skeleton)
        turning = joints[np.ptp(clip.rotations[:, joints], axis=0).any(axis=-1)]
        moving = joints[np.ptp(clip.translations[:, joints], axis=0).any(axis=-1)]
        chosen = np.flatnonzero(keys)
        rotations[np.ix_(chosen, turning)] = turned[np.ix_(chosen, turning)]
        translations[np.ix_(chosen, moving)] = moved[np.ix_(chosen, moving)]
        return replace(self, rotations=rotations, translations=translations)


def play_poses(poses: Poses, clip: Clip, per_frame: int) -> Clip:
    """Play poses as UsdSkel does.

    Parameters
    ----------
    poses
        The poses.
    clip
        The clip they are of.
    per_frame
        Frames of the result to each frame of the clip.
    """
    times = np.arange((clip.frame_count - 1) * per_frame + 1) / per_frame
    first = np.clip(np.searchsorted(poses.frames, times, side="right") - 1, 0, max(len(poses.frames) - 2, 0))
    after = np.minimum(first + 1, len(poses.frames) - 1)
    part = ((times - poses.frames[first]) / np.maximum(poses.frames[after] - poses.frames[first], 1))[:, None]
    mix = part[..., None]
    return replace(
        clip,
        rate=clip.rate * per_frame,
        time_codes_per_frame=clip.time_codes_per_frame / per_frame,
        rotations=slerp(poses.rotations[first], poses.rotations[after], part),
        translations=(1.0 - mix) * poses.translations[first] + mix * poses.translations[after],
        scales=(1.0 - mix) * poses.scales[first] + mix * poses.scales[after],
    )


@dataclass(frozen=True, eq=False)
class _Keys:
    """Which frames are keys, and which of them hold the clip's own pose, both [F]."""

    placed: BoolArray
    pinned: BoolArray


class PoseSearch:
    """The search for poses of one clip.

    Parameters
    ----------
    clip
        The clip.
    tolerance
        What the counted joints may be off by.
    fixed
        Frames that are keys and hold the clip's own pose.
    joints
        Indices of the joints that count.
    """

    def __init__(self, clip: Clip, tolerance: Tolerance, fixed: IntArray, joints: IntArray) -> None:
        self._clip = clip
        self._tolerance = tolerance
        self._joints = joints
        placed = np.zeros(clip.frame_count, dtype=np.bool_)
        placed[fixed] = True
        self._start = _Keys(placed, placed)

    def reduce(self) -> Poses:
        """Find few poses within the tolerance."""
        return self._refit(self._add(self._find_keys(), 1.0, self._refit))

    def _find_keys(self) -> _Keys:
        """Seek a path through stretches that slerps can follow, and again with what is learnt from the poses on it."""
        clip = self._clip
        fixed = np.flatnonzero(self._start.placed)
        radians = _MARGIN * np.radians(self._tolerance.degrees)
        stretches = measure_stretches(clip.rotations[:, self._joints], radians, fixed.tolist())
        best, fewest, price = self._start, np.inf, _KEY_PRICE
        for _ in range(_PATHS):
            path = stretches.find_path(price)
            placed = np.zeros(clip.frame_count, dtype=np.bool_)
            placed[path] = True
            keys = _Keys(placed, self._start.pinned)
            passed = self._refine(keys)[1]
            missing = int(np.add.reduceat(passed > 1.0, path).astype(np.bool_).sum())
            if len(path) + missing < fewest:
                best, fewest = keys, len(path) + missing
            stretches.raise_prices(path, passed)
            if not missing:
                price *= _DEARER
        return best

    @cached_property
    def _above(self) -> IntArray:
        """The joints that count and all above them."""
        found = set(self._joints.tolist())
        for joint in range(len(self._clip.joints) - 1, -1, -1):
            found |= {int(self._clip.parents[joint])} if joint in found else set()
        return np.array(sorted(found - {-1}), dtype=np.intp)

    @cached_property
    def _refiner(self) -> Refiner:
        units = self._tolerance.metres / self._clip.skeleton.meters_per_unit
        counted = np.isin(self._above, self._joints)
        body = read_body(self._clip).only(self._above)
        return Refiner(Goal(body, _MARGIN * self._tolerance.degrees, _MARGIN * units, counted))

    def _refine(self, keys: _Keys) -> tuple[Poses, FloatArray]:
        """Fit poses so that the largest error is small; also how many times the limits are reached, [F]."""
        rough = self._fit(keys)
        at_keys = replace(self._clip, rotations=rough.rotations, translations=rough.translations, scales=rough.scales)
        spans, body = Spans(rough.frames, keys.pinned[rough.frames]), read_body(at_keys)
        found, passed = self._refiner.refine(spans, body.only(self._above), rounds=_STEPS)
        body.turns[self._above], body.arms[self._above] = found.turns, found.arms
        return rough.take_over(body, self._clip, self._joints, ~spans.pinned), passed

    def _refit(self, keys: _Keys) -> Poses:
        return self._refine(keys)[0]

    def fit_count(self, key_count: int) -> Poses:
        """Find the tolerance, by its ratio to the given one, that needs just so many poses."""
        low, high = 0.0, 1.0
        best = self._add(self._start, high, self._fit)
        while best.placed.sum() > key_count:
            low, high = high, 4.0 * high
            best = self._add(self._start, high, self._fit)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            found = self._add(self._start, middle, self._fit)
            if found.placed.sum() <= key_count:
                best, high = found, middle
            else:
                low = middle
        return self._fit(best)

    @cached_property
    def _fine(self) -> Clip:
        return play_between(self._clip, _CHECKED)

    @cached_property
    def _fine_places(self) -> FloatArray:
        return self._fine.skeleton.world_pose(self._fine.rotations, self._fine.translations)[0]

    def measure(self, poses: Poses) -> tuple[FloatArray, FloatArray]:
        """Measure joints that count, degrees and metres, four times a frame, both [T, N]."""
        played = play_poses(poses, self._clip, _CHECKED)
        degrees, metres = measure_difference(played, self._fine, self._fine_places)
        return degrees[:, self._joints], metres[:, self._joints]

    def _passed(self, poses: Poses) -> FloatArray:
        """How many times the tolerance is passed at every frame, [F]."""
        played = play_poses(poses, self._clip, 1)
        degrees, metres = measure_difference(played, self._clip, self._fine_places[::_CHECKED])
        return self._ratio(degrees[:, self._joints], metres[:, self._joints])

    def _ratio(self, degrees: FloatArray, metres: FloatArray) -> FloatArray:
        turned, moved = degrees.max(axis=1) / self._tolerance.degrees, metres.max(axis=1) / self._tolerance.metres
        return np.asarray(np.maximum(turned, moved))

    def _add(self, keys: _Keys, scale: float, fit: Callable[[_Keys], Poses]) -> _Keys:
        """Add keys until every frame is within a scale of the tolerance, then look between frames."""
        for _ in range(_ROUNDS):
            poses = fit(keys)
            passed = self._passed(poses) / scale
            if (passed <= 1.0).all():
                passed = self._ratio(*self.measure(poses)) / scale
                if (passed <= 1.0).all():
                    break
                keys = _tie(keys, passed)
            else:
                keys = _insert(keys, np.where(passed > 1.0, passed, 0.0))
        return keys

    @cached_property
    def _columns(self) -> FloatArray:
        """All that is fitted, [F, 10 J]."""
        clip = self._clip
        parts = (quaternion.unroll(clip.rotations), clip.translations, clip.scales)
        return np.concatenate([part.reshape(clip.frame_count, -1) for part in parts], axis=1)

    def _fit(self, keys: _Keys) -> Poses:
        """Fit poses by least squares of linear interpolation, which between near keys is slerp but for its speed."""
        frames = np.flatnonzero(keys.placed)
        values = _fit_linear(self._columns, frames, keys.pinned[frames])
        joints = len(self._clip.joints)
        rotations, rest = values[:, : 4 * joints].reshape(-1, joints, 4), values[:, 4 * joints :]
        translations, scales = (part.reshape(-1, joints, 3) for part in np.split(rest, 2, axis=1))
        return Poses(frames, quaternion.normalize(rotations), translations, scales)


def _fit_linear(columns: FloatArray, frames: IntArray, pinned: BoolArray) -> FloatArray:
    """Fit linear splines with common keys to columns [F, M]; pinned keys hold the columns' values, [N, M]."""
    from scipy.linalg import solveh_banded  # noqa: PLC0415  (slow to import, seldom used)

    if pinned.all():
        return columns[frames]
    lengths = np.maximum(np.append(np.diff(frames), 0), 1)
    part = (np.arange(len(columns)) - np.repeat(frames, lengths)) / np.repeat(lengths, lengths)
    starting, ending = 1.0 - part, part
    band, right = np.zeros((2, len(frames))), np.add.reduceat(starting[:, None] * columns, frames, axis=0)
    band[0] = np.add.reduceat(starting * starting, frames)
    band[0, 1:] += np.add.reduceat(ending * ending, frames)[:-1]
    band[1] = np.add.reduceat(starting * ending, frames)
    right[1:] += np.add.reduceat(ending[:, None] * columns, frames, axis=0)[:-1]
    held = np.where(pinned[:, None], columns[frames], 0.0)
    right[1:] -= band[1, :-1, None] * held[:-1]
    right[:-1] -= band[1, :-1, None] * held[1:]
    band[1, :-1][pinned[:-1] | pinned[1:]] = 0.0
    band[0, pinned], right[pinned] = 1.0, columns[frames[pinned]]
    solved = solveh_banded(band, right, lower=True, check_finite=False)
    # Exactly what is asked for, and exactly what never changes.
    still = (columns == columns[0]).all(axis=0)
    solved[pinned], solved[:, still] = columns[frames[pinned]], columns[0, still]
    return np.asarray(solved)


def _insert(keys: _Keys, weights: FloatArray) -> _Keys:
    """Set a key at the centre of what is wrong in each stretch; where there is no room, hold the poses at its ends."""
    frames = np.flatnonzero(keys.placed)
    lengths = np.append(np.diff(frames), 0)
    total = np.add.reduceat(weights, frames)
    moment = np.add.reduceat(weights * np.arange(len(weights)), frames)
    placed, pinned = np.array(keys.placed), np.array(keys.pinned)
    split = (total > 0.0) & (lengths > 1)
    centres = np.round(moment[split] / total[split]).astype(np.intp)
    placed[np.clip(centres, frames[split] + 1, frames[split] + lengths[split] - 1)] = True
    short = np.flatnonzero((total > 0.0) & (lengths <= 1))
    pinned[frames[short]] = True
    pinned[frames[np.minimum(short + 1, len(frames) - 1)]] = True
    return _Keys(placed, pinned)


def _tie(keys: _Keys, passed: FloatArray) -> _Keys:
    """Hold the clip's own poses on both sides of times, four a frame, where something is wrong."""
    wrong = np.flatnonzero(passed > 1.0)
    placed, pinned = np.array(keys.placed), np.array(keys.pinned)
    for frames in (wrong // _CHECKED, -(-wrong // _CHECKED)):
        placed[frames] = pinned[frames] = True
    return _Keys(placed, pinned)
