"""Weighted means of motions, pose by pose: rotations as rotations, the root in the facing frame.

Heading and travel are added up from blended increments, so that motions which face and go different ways give one that
goes on between them; height and lean are blended as they are. Every frame's weights sum to one, but any may be negative
or above one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.frames import append_frames, take_frames
from mtex_usd.edit.root import level, move_level, place_root, read_root
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.facing import Facing

__all__ = ["Strand", "average_rotations", "make_strand", "mix_strands"]

FloatArray = npt.NDArray[np.float64]

_ROUNDS = 50  # of the mean of many rotations; a dozen is enough where they are within a quarter turn
_SETTLED = 1e-14  # radians


@dataclass(frozen=True, eq=False, kw_only=True)
class Strand:
    """A motion beside what its root does in skeleton space.

    Parameters
    ----------
    clip
        The motion.
    joint
        Index of the root.
    rotations, positions
        Of the root in skeleton space, shapes [F, 4] and [F, 3].
    heading
        Smoothed turn of the facing frame about up, radians, shape [F].
    """

    clip: Clip
    joint: int
    rotations: FloatArray
    positions: FloatArray
    heading: FloatArray

    @property
    def facing(self) -> Facing:
        """The facing frame."""
        return Facing(self.heading, self.clip.skeleton.up)

    def cut(self, first: int, last: int) -> "Strand":
        """Give the frames first to last, both included."""
        part = slice(first, last + 1)
        return Strand(
            clip=take_frames(self.clip, part),
            joint=self.joint,
            rotations=self.rotations[part],
            positions=self.positions[part],
            heading=self.heading[part],
        )

    def placed_after(self, other: "Strand") -> "Strand":
        """Move it over the floor so that it begins where another ends, facing that way; heights stay."""
        turn = float(other.heading[-1] - self.heading[0])
        rotations, positions = move_level(
            self.rotations,
            self.positions,
            turn=turn,
            pivot=self.positions[0],
            goal=other.positions[-1],
            up=self.clip.skeleton.up,
        )
        clip = place_root(self.clip, rotations, positions, joint=self.joint)
        return replace(self, clip=clip, rotations=rotations, positions=positions, heading=self.heading + turn)

    def then(self, other: "Strand") -> "Strand":
        """Append another, whose first frame is this one's last and is left out."""
        return Strand(
            clip=append_frames(self.clip, other.clip, skipped=1),
            joint=self.joint,
            rotations=np.concatenate([self.rotations, other.rotations[1:]]),
            positions=np.concatenate([self.positions, other.positions[1:]]),
            heading=np.concatenate([self.heading, other.heading[1:]]),
        )


def make_strand(clip: Clip, joint: int) -> Strand:
    """Read what a motion's root does."""
    root = read_root(clip, joint=joint)
    return Strand(
        clip=clip, joint=joint, rotations=root.rotations, positions=root.positions, heading=root.facing.heading
    )


def mix_strands(strands: Sequence[Strand], weights: FloatArray, *, begin_with_first: bool = False) -> Strand:
    """Give the weighted mean of motions on the same joints.

    Parameters
    ----------
    strands
        Two or more of the same length.
    weights
        Shape [F, N], every row summing to one.
    begin_with_first
        Begin where the first begins and facing as it does; else between all, by their weights.

    Returns
    -------
    Strand
        Poses where one weight is 1 and the others 0 are that motion's, bit for bit, the root's from the first frame on.
    """
    clips = [strand.clip for strand in strands]
    rotations = average_rotations([clip.rotations for clip in clips], weights)
    translations = _average([clip.translations for clip in clips], weights)
    scales = _average([clip.scales for clip in clips], weights)
    mixed = replace(clips[0], rotations=rotations, translations=translations, scales=scales)
    start = np.eye(len(strands))[0] if begin_with_first else weights[0]
    root = _mix_roots(strands, weights, start)
    placed = place_root(mixed, root.rotations, root.positions, joint=root.joint)
    alone = _leading_alone(weights, start)
    for name in ("rotations", "translations"):
        getattr(placed, name)[:alone, root.joint] = getattr(clips[int(np.argmax(start))], name)[:alone, root.joint]
    return replace(root, clip=placed)


def _leading_alone(weights: FloatArray, start: FloatArray) -> int:
    """How many first frames are one motion alone, begun where it begins."""
    if np.count_nonzero(start) != 1:
        return 0
    other = np.flatnonzero((weights != start).any(axis=1))
    return int(other[0]) if other.size else len(weights)


def _mix_roots(strands: Sequence[Strand], weights: FloatArray, start: FloatArray) -> Strand:
    up = strands[0].clip.skeleton.up
    between = 0.5 * (weights[1:] + weights[:-1])
    first = strands[0].heading[0]
    # Whole turns between the motions' first headings mean nothing.
    begins = np.array([first + _nearest_turn(strand.heading[0] - first) for strand in strands])
    turns = np.stack([np.diff(strand.heading) for strand in strands], axis=1)
    heading = np.cumsum(np.concatenate([[start @ begins], (between * turns).sum(axis=1)]))
    facing = Facing(heading, up)
    leans = average_rotations([strand.facing.into(strand.rotations)[:, None] for strand in strands], weights)
    positions = np.stack([strand.positions for strand in strands], axis=1)
    travel = np.stack([strand.facing.unroll_travel(strand.positions) for strand in strands], axis=1)
    begin = quaternion.rotate(quaternion.exp(-heading[0] * up), level(start @ positions[0], up))
    steps = np.einsum("fn,fni->fi", between, np.diff(travel, axis=0))
    way = facing.roll_travel(np.cumsum(np.concatenate([begin[None], steps]), axis=0))
    heights = np.einsum("fn,fn->f", weights, positions @ up)
    return replace(
        strands[0],
        rotations=facing.out_of(leans[:, 0]),
        positions=level(way, up) + heights[:, None] * up,
        heading=heading,
    )


def _nearest_turn(angle: float) -> float:
    return float(angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi)))


def _average(values: Sequence[FloatArray], weights: FloatArray) -> FloatArray:
    mean = np.einsum("fn,nfji->fji", weights, np.stack(values))
    return _keep_alone(mean, values, weights)


def _keep_alone(mean: FloatArray, values: Sequence[FloatArray], weights: FloatArray) -> FloatArray:
    """Put frames that are one motion alone there as they are, and joints that are the same in all."""
    same = np.logical_and.reduce([(value == values[0]).all(axis=-1) for value in values])
    mean[same] = values[0][same]
    for number, value in enumerate(values):
        alone = weights[:, number] == 1.0
        alone &= np.count_nonzero(weights, axis=1) == 1
        mean[alone] = value[alone]
    return mean


def average_rotations(rotations: Sequence[FloatArray], weights: FloatArray) -> FloatArray:
    """Weighted mean of rotations; of two, the point on the shortest way between them, or on beyond either.

    Parameters
    ----------
    rotations
        N arrays of shape [F, J, 4].
    weights
        Shape [F, N], every row summing to one.

    Returns
    -------
    FloatArray
        Shape [F, J, 4]. Between two, the way round is kept where it passes half a turn, so that nothing flips.

    Notes
    -----
    The mean M solves sum w log(M^-1 R) = 0; it is found by moving M along that sum (Buss & Fillmore 2001), beginning
    with the rotation of the largest weight. For two that is one step.
    """
    if len(rotations) == 2:
        apart = quaternion.log(quaternion.multiply(quaternion.conjugate(rotations[0]), rotations[1]))
        turn = weights[:, 1, None, None] * quaternion.unroll_vectors(apart)
        mean = quaternion.multiply(rotations[0], quaternion.exp(turn))
    else:
        mean = _iterate_mean(np.stack(rotations), weights)
    return _keep_alone(quaternion.normalize(mean), rotations, weights)


def _iterate_mean(rotations: FloatArray, weights: FloatArray) -> FloatArray:
    heaviest = np.argmax(weights, axis=1)
    mean: FloatArray = rotations[heaviest, np.arange(len(weights))]
    for _ in range(_ROUNDS):
        apart = quaternion.log(quaternion.multiply(quaternion.conjugate(mean), rotations))
        step = np.einsum("fn,nfji->fji", weights, apart)
        mean = quaternion.multiply(mean, quaternion.exp(step))
        if np.abs(step).max() <= _SETTLED:
            break
    return mean
