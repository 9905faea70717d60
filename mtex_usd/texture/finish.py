"""From a path of candidates to a finished motion: copy, stretch, scale, join, texture and synthesize.

Texture (Pullen & Bregler 2002, section 3.1): y = x - sum B_k(x) + sum B_k(m) over the texture bands of the joined path
m. Synthesis (section 4.1): the joined path without its highest band.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d

from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import Channel
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.candidates import Candidates
from mtex_usd.texture.facing import replace_yaw
from mtex_usd.texture.joining import join_curves, join_rotations
from mtex_usd.texture.pyramid import Bands, decompose
from mtex_usd.texture.reading import Motion
from mtex_usd.texture.roles import Roles
from mtex_usd.texture.space import Copied, Space, goes_along_ground
from mtex_usd.texture.stretching import stretch_cubic

__all__ = ["Finished", "Finisher"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

# Farther from its mean than this, in degrees, a joint's vectors exaggerate turns twofold, and at 360 the axis is lost.
_FAR = 210.0


@dataclass(frozen=True, eq=False)
class Finished:
    """One path made into motion.

    Parameters
    ----------
    clip
        The result on the whole skeleton.
    joined, curves
        The joined path and the result as curves of the space, shape [F, C].
    """

    clip: Clip
    joined: FloatArray
    curves: FloatArray


@dataclass(frozen=True, eq=False)
class Finisher:
    """Everything that is the same for all paths of one sketch.

    Parameters
    ----------
    sketch
        The sketch.
    takes
        The takes, in the order the candidates count them.
    space
        What is copied, and how.
    roles
        What it is copied for, and when.
    fragments
        Sketch fragments, shape [Q, 2].
    candidates
        Candidates per sketch fragment, length Q.
    join_frames
        N of the joining blend.
    held
        How far the texturing of joints is held back at every frame, shape [F], by joint.
    """

    sketch: Motion
    takes: Sequence[Motion]
    space: Space
    roles: Roles
    fragments: IntArray
    candidates: Sequence[Candidates]
    join_frames: int
    held: Mapping[int, FloatArray] = field(default_factory=dict)
    _copied: dict[int, Copied] = field(default_factory=dict)
    _residuals: dict[int, FloatArray] = field(default_factory=dict)
    _stretched: dict[tuple[int, float, float, int], Copied] = field(default_factory=dict)

    def take_copy(self, take: int) -> Copied:
        """What can be copied of one take."""
        if take not in self._copied:
            self._copied[take] = self.space.read(self.takes[take])
        return self._copied[take]

    @cached_property
    def _own(self) -> Copied:
        return self.space.read(self.sketch)

    @cached_property
    def sketch_bands(self) -> Bands:
        """The sketch's copied channels, decomposed."""
        return decompose(self.space.to_curves(self._own))

    @cached_property
    def sketch_curves(self) -> FloatArray:
        """The sketch's copied channels, the sum of their bands, shape [F, C]."""
        return np.asarray(self.sketch_bands.bands.sum(axis=0) + self.sketch_bands.residual)

    @cached_property
    def textured(self) -> FloatArray:
        """How far each column is textured at each frame, shape [F, C]."""
        return self._free * self.roles.weights(self.space.channels, lambda span: span.texture, self.join_frames)

    @cached_property
    def _free(self) -> FloatArray:
        """How far each column may be textured at each frame, shape [F, C]."""
        free = np.ones((self.sketch.clip.frame_count, len(self.space.channels)))
        for column, channel in enumerate(self.space.channels):
            if channel.joint in self.held:
                free[:, column] -= self.held[channel.joint]
        return free

    @cached_property
    def synthesized(self) -> FloatArray:
        """How far each column is synthesized at each frame, shape [F, C]."""
        return self.roles.weights(self.space.channels, lambda span: span.synthesize, self.join_frames)

    def finish(self, choice: Sequence[int]) -> Finished:
        """Make one path into motion.

        Parameters
        ----------
        choice
            Index of the candidate per sketch fragment, length Q.

        Notes
        -----
        A path that turns a synthesized joint farther than 210 degrees from its mean is smoothed there as quaternions:
        vectors that long exaggerate turns, and near 360 degrees a small one changes them beyond measure.
        """
        joined = self._on_nearest_turn(self._keep_yaw(self._join(choice)))
        path = self.space.to_curves(joined)
        curves = self._combine(path)
        far = self._far_from_mean(path)
        if far.any():
            curves = self._smooth_as_quaternions(curves, joined, far)
        return Finished(self.space.apply(self.space.from_curves(curves), self.sketch), path, curves)

    def _far_from_mean(self, path: FloatArray) -> BoolArray:
        """Where synthesized joints come so far from their mean that vectors will not do, shape [F, W]."""
        count = len(self.space.whole)
        vectors = path[:, : 3 * count].reshape(len(path), count, 3)
        far = np.asarray(np.linalg.norm(vectors, axis=-1) > _FAR)
        if not far.any():
            return far
        # As far around as what is smoothed there sees.
        around = maximum_filter1d(far.astype(np.uint8), 2 ** (self.roles.synthesis_band + 1) + 1, axis=0) > 0
        return np.asarray(around & (self.synthesized[:, : 3 * count : 3] == 1.0))

    def _smooth_as_quaternions(self, curves: FloatArray, joined: Copied, far: BoolArray) -> FloatArray:
        """Where `far` [F, W] says so, take the highest bands out of the joined path's quaternions instead, [F, C]."""
        flat = quaternion.unroll(joined.rotations).reshape(len(curves), -1)
        smooth = decompose(flat).at_or_below(self.roles.synthesis_band).reshape(joined.rotations.shape)
        plain = self.space.from_curves(curves)
        rotations = np.where(far[..., None], quaternion.normalize(smooth), plain.rotations)
        mended = self.space.to_curves(replace(plain, rotations=rotations))
        columns = np.flatnonzero(np.repeat(far.any(axis=0), 3))
        result = np.array(curves)
        result[:, columns] = mended[:, columns]
        return result

    def _join(self, choice: Sequence[int]) -> Copied:
        return self.join_pieces(self.take_pieces(choice), self.find_continued(choice))

    def take_pieces(self, choice: Sequence[int]) -> list[Copied]:
        """Give the fragments of a path, stretched and scaled, not yet joined; neighbours share a frame.

        Parameters
        ----------
        choice
            Index of the candidate per sketch fragment, length Q.
        """
        pieces = [self._stretch(q, k) for q, k in enumerate(choice)]
        scales = self._scales(choice)
        if np.any(scales != 1.0):
            pieces = [self._scale(piece, q, k, scales) for q, (piece, k) in enumerate(zip(pieces, choice, strict=True))]
        return pieces

    def join_pieces(self, pieces: Sequence[Copied], continued: BoolArray) -> Copied:
        """Make fragments meet, and blend the quadratic in where they were not consecutive.

        Parameters
        ----------
        pieces
            As :meth:`take_pieces` gives them.
        continued
            Whether the two fragments at each join were consecutive in their take, shape [Q - 1].
        """
        rotations = join_rotations([piece.rotations for piece in pieces], continued, self.join_frames)
        curves = join_curves(
            [piece.curves for piece in pieces],
            continued,
            self.join_frames,
            turning=self.space.turning,
            sliding=self._along_ground,
        )
        # Where a take's root was in the room it was recorded in means nothing: the way begins where the sketch's does.
        start = np.where(self.space.sliding, self._own.curves[0] - curves[0], 0.0)
        return Copied(rotations, curves + start)

    @cached_property
    def _along_ground(self) -> BoolArray:
        """Which single curves are the root's way along the ground, shape [C']."""
        root, up = self.space.root, self.sketch.clip.skeleton.up
        return np.array([goes_along_ground(channel, root, up) for channel in self.space.single], dtype=np.bool_)

    @cached_property
    def _way(self) -> IntArray:
        """Columns that are the root's way along the ground."""
        return 3 * len(self.space.whole) + np.flatnonzero(self._along_ground)

    @cached_property
    def _height(self) -> IntArray:
        """Columns that are the root's height."""
        return 3 * len(self.space.whole) + np.flatnonzero(self.space.sliding & ~self._along_ground)

    def find_continued(self, choice: Sequence[int]) -> BoolArray:
        """Tell whether the two fragments at each join were consecutive in their take, shape [Q - 1].

        Parameters
        ----------
        choice
            Index of the candidate per sketch fragment, length Q.
        """
        used = [(c.take[k], c.first[k], c.last[k]) for c, k in zip(self.candidates, choice, strict=True)]
        pairs = itertools.pairwise(used)
        return np.array([a[0] == b[0] and a[2] == b[1] for a, b in pairs], dtype=np.bool_)

    def _stretch(self, q: int, k: int) -> Copied:
        """One candidate at its sketch fragment's length."""
        found = self.candidates[q]
        frames = int(self.fragments[q, 1] - self.fragments[q, 0]) + 1
        key = (int(found.take[k]), float(found.first[k]), float(found.last[k]), frames)
        if key not in self._stretched:
            self._stretched[key] = _stretch(self.take_copy(key[0]), *key[1:])
        return self._stretched[key]

    def _scales(self, choice: Sequence[int]) -> FloatArray:
        """The scale factor over time, from the middle of one fragment to the middle of the next, shape [F]."""
        factors = [c.scale[k] for c, k in zip(self.candidates, choice, strict=True)]
        return np.asarray(np.interp(np.arange(self.fragments[-1, 1] + 1), self.fragments.mean(axis=1), factors))

    def _scale(self, piece: Copied, q: int, k: int, scales: FloatArray) -> Copied:
        """Scale a stretched fragment about its take's residual."""
        found = self.candidates[q]
        first, last = self.fragments[q]
        residual = self._residual(int(found.take[k]))
        base = stretch_cubic(residual, float(found.first[k]), float(found.last[k]), len(piece.rotations))
        curves = self.space.to_curves(piece)
        return self.space.from_curves(base + scales[first : last + 1, None] * (curves - base))

    def _residual(self, take: int) -> FloatArray:
        if take not in self._residuals:
            self._residuals[take] = decompose(self.space.to_curves(self.take_copy(take))).residual
        return self._residuals[take]

    def _keep_yaw(self, joined: Copied) -> Copied:
        """Where the root's rotation is synthesized, give it the sketch's turn about up."""
        root = self.space.root
        if not any(c.joint == root and c.is_rotation for span in self.roles.spans for c in span.synthesize):
            return joined
        if root not in self.space.whole:
            return self._keep_yaw_angle(joined)
        rotations = np.array(joined.rotations)
        column = self.space.whole.index(root)
        yaw_of = self.sketch.rotations[:, root]
        rotations[:, column] = replace_yaw(rotations[:, column], yaw_of, self.sketch.clip.skeleton.up)
        return replace(joined, rotations=rotations)

    def _keep_yaw_angle(self, joined: Copied) -> Copied:
        """The same for a root copied in single angles: the outermost is its turn about up."""
        axis = self.space.orders[self.space.root][0].lower()
        upright = abs(self.sketch.clip.skeleton.up["xyz".index(axis)]) > 1.0 - 1e-6
        yaw = [upright and channel == Channel(self.space.root, f"r{axis}") for channel in self.space.single]
        return replace(joined, curves=np.where(yaw, self._own.curves, joined.curves))

    def _on_nearest_turn(self, joined: Copied) -> Copied:
        """Bring single angles to the sketch's turn, or one that ramps in or out would go round on the way."""
        weights = self.synthesized[:, 3 * len(self.space.whole) :]
        ramps = (weights > 0.0) & (weights < 1.0)
        gap = np.sum((self._own.curves - joined.curves) * ramps, axis=0) / np.maximum(ramps.sum(axis=0), 1)
        shift = np.where(self.space.turning, 360.0 * np.round(gap / 360.0), 0.0)
        return replace(joined, curves=joined.curves + shift)

    def _combine(self, path: FloatArray) -> FloatArray:
        """Texture and synthesize the sketch's curves from the joined path, shape [F, C]."""
        lowest = max(self.roles.synthesis_band, *(span.texture_bands[1] for span in self.roles.spans))
        own, taken = self.sketch_bands, decompose(path, most=lowest)
        sketch = self.sketch_curves
        result = sketch + self._fill_in(taken.at_or_below(self.roles.synthesis_band) - sketch)
        for bands in {span.texture_bands for span in self.roles.spans}:
            detail = taken.sum_of(*bands) - own.sum_of(*bands)
            result += self._texture_weight(bands) * detail
        return np.asarray(result)

    def _fill_in(self, gap: FloatArray) -> FloatArray:
        """What synthesis adds to the sketch that lies so far from the path, both shape [F, C].

        The root's way along the ground is filled in step by step: where the sketch takes over again it walks on from
        where the character has got to. Its height is counted from where each stretch of synthesis begins, and comes
        back to the sketch's floor.
        """
        weights, way, height = self.synthesized, self._way, self._height
        added = weights * gap
        added[:, way] = _add_up(weights[:, way], gap[:, way])
        added[:, height] -= weights[:, height] * _at_begin(gap[:, height], weights[:, height] > 0.0)
        return added

    def _texture_weight(self, bands: tuple[int, int]) -> FloatArray:
        """How far each column is textured with some bands at each frame, shape [F, C]."""
        weights = self.roles.weights(
            self.space.channels,
            lambda span: span.texture if span.texture_bands == bands else frozenset(),
            self.join_frames,
        )
        return self._free * weights


def _add_up(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Sum of the steps of values, each weighed, from zero on; all of shape [F, C]."""
    steps = 0.5 * (weights[1:] + weights[:-1]) * np.diff(values, axis=0)
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])


def _at_begin(values: FloatArray, held: BoolArray) -> FloatArray:
    """What values [F, C] are where each stretch of frames that is held began, shape [F, C]."""
    frames = np.arange(len(values))[:, None]
    begins = np.concatenate([held[:1], held[1:] & ~held[:-1]])
    return np.take_along_axis(values, np.maximum.accumulate(np.where(begins, frames, 0), axis=0), axis=0)


def _stretch(copied: Copied, first: float, last: float, frames: int) -> Copied:
    """Stretch rotations as unit quaternions and curves as numbers, in one pass."""
    joints = copied.rotations.shape[1]
    flat = np.concatenate([copied.rotations.reshape(len(copied.rotations), -1), copied.curves], axis=1)
    stretched = stretch_cubic(flat, first, last, frames)
    rotations = stretched[:, : 4 * joints].reshape(frames, joints, 4)
    lengths = np.linalg.norm(rotations, axis=-1, keepdims=True)
    return Copied(rotations / lengths, stretched[:, 4 * joints :])
