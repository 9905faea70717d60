"""Turns and places of joints with the samples last: on whole clips several times as fast as frame after frame.

A turn is a rotation since rest in skeleton axes, as in :mod:`mtex_usd.motion.channels`. Turns along a chain compose as
they are: nothing has to be known of the bones' own axes.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.keys.tree import list_levels
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import (
    to_local_rotations,
    to_local_translations,
    to_skeleton_rotations,
    to_skeleton_translations,
)
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Body", "angles_apart", "compose", "cross", "distances", "read_body", "rotate"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Body:
    """A motion of J joints at T times.

    Parameters
    ----------
    parents
        Parent by joint, -1 for a root, shape [J].
    turns
        Rotations since rest in skeleton axes, real first, shape [J, 4, T].
    arms
        From the parent to the joint while the parent is at rest, skeleton axes and units, shape [J, 3, T].
    """

    parents: IntArray
    turns: FloatArray
    arms: FloatArray

    def take(self, times: IntArray) -> "Body":
        """Give some of the times alone."""
        return replace(self, turns=self.turns[..., times], arms=self.arms[..., times])

    @cached_property
    def total_turns(self) -> FloatArray:
        """What each joint is turned by together with all above it, shape [J, 4, T]."""
        totals = np.array(self.turns)
        _add_up_turns(self, totals, np.ones(len(totals), dtype=np.bool_))
        return totals

    @cached_property
    def places(self) -> FloatArray:
        """Where the joints are in skeleton space, shape [J, 3, T]."""
        places = np.array(self.arms)
        _add_up_places(self, places, np.ones(len(places), dtype=np.bool_))
        return places

    def to_local(self, skeleton: Skeleton) -> tuple[FloatArray, FloatArray]:
        """Give rotations and translations relative to the parents, as clips have them, [T, J, 4] and [T, J, 3]."""
        turned, arms = (np.moveaxis(part, -1, 0) for part in (self.turns, self.arms))
        offsets = arms - _arms_at_rest(skeleton)
        return to_local_rotations(turned, skeleton), to_local_translations(offsets, skeleton)

    def only(self, joints: IntArray) -> "Body":
        """Give some of the joints alone, with each of them all that is above it, in rising order."""
        numbers = np.append(np.searchsorted(joints, np.arange(len(self.parents))), -1)
        return Body(numbers[self.parents[joints]], self.turns[joints], self.arms[joints])

    def list_below(self, joints: BoolArray) -> BoolArray:
        """Mark joints and all below them, [J] to [J]."""
        found = np.array(joints)
        for members, parents in list_levels(self.parents):
            found[members] |= found[parents]
        return found

    def change(self, joints: BoolArray, turns: FloatArray, arms: FloatArray) -> "Body":
        """Exchange turns and arms of some joints; what is not below them is not computed again.

        Parameters
        ----------
        joints
            Which joints are changed, shape [J].
        turns, arms
            Of all joints, shapes [J, 4, T] and [J, 3, T].
        """
        changed, below = Body(self.parents, turns, arms), self.list_below(joints)
        totals, places = np.array(self.total_turns), np.array(self.places)
        totals[joints], places[joints] = turns[joints], arms[joints]
        _add_up_turns(changed, totals, below)
        changed.__dict__["total_turns"] = totals
        _add_up_places(changed, places, below)
        changed.__dict__["places"] = places
        return changed


def _add_up_turns(body: Body, totals: FloatArray, chosen: BoolArray) -> None:
    for joints, parents in _levels_of(body, chosen):
        totals[joints] = compose(totals[parents], body.turns[joints])


def _add_up_places(body: Body, places: FloatArray, chosen: BoolArray) -> None:
    for joints, parents in _levels_of(body, chosen):
        places[joints] = places[parents] + rotate(body.total_turns[parents], body.arms[joints])


def _levels_of(body: Body, chosen: BoolArray) -> Iterator[tuple[IntArray, IntArray]]:
    for joints, parents in list_levels(body.parents):
        picked = chosen[joints]
        if picked.any():
            yield joints[picked], parents[picked]


def read_body(clip: Clip) -> Body:
    """Read the frames of a clip.

    Parameters
    ----------
    clip
        The clip.
    """
    skeleton = clip.skeleton
    arms = _arms_at_rest(skeleton) + to_skeleton_translations(clip.translations, skeleton)
    return Body(skeleton.parents, _put_last(to_skeleton_rotations(clip.rotations, skeleton)), _put_last(arms))


def _arms_at_rest(skeleton: Skeleton) -> FloatArray:
    above = np.concatenate([skeleton.rest_orientations, [[1.0, 0.0, 0.0, 0.0]]])[skeleton.parents]
    return quaternion.rotate(above, skeleton.rest_translations)


def _put_last(rows: FloatArray) -> FloatArray:
    return np.ascontiguousarray(np.moveaxis(rows, 0, -1))


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compose rotations [N, 4, T], b first."""
    (aw, ax, ay, az), (bw, bx, by, bz) = np.moveaxis(a, 1, 0), np.moveaxis(b, 1, 0)
    out = np.empty_like(a)
    out[:, 0] = aw * bw - ax * bx - ay * by - az * bz
    out[:, 1] = aw * bx + ax * bw + ay * bz - az * by
    out[:, 2] = aw * by - ax * bz + ay * bw + az * bx
    out[:, 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """Rotate vectors [N, 3, T] by rotations [N, 4, T]."""
    axis = q[:, 1:]
    t = cross(axis, v)
    t *= 2.0
    out = cross(axis, t)
    t *= q[:, :1]
    out += t
    out += v
    return out


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Give the cross products of vectors [N, 3, T]."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape), dtype=np.result_type(a, b))
    for first, second, third in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[:, second], b[:, third], out=out[:, first])
        out[:, first] -= a[:, third] * b[:, second]
    return out


def angles_apart(a: FloatArray, b: FloatArray) -> FloatArray:
    """Give the angles between rotations [N, 4, T], degrees, shape [N, T]."""
    near, far = (np.einsum("jit,jit->jt", way, way) for way in (a - b, a + b))
    # Through the chord, which tells small angles as well as large ones.
    return np.asarray(np.degrees(4.0 * np.arcsin(np.minimum(0.5 * np.sqrt(np.minimum(near, far)), 1.0))))


def distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Give the distances of places [N, 3, T], shape [N, T]."""
    way = a - b
    return np.asarray(np.sqrt(np.einsum("jit,jit->jt", way, way)))
