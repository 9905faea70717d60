"""One motion going over into another, or into itself (Gleicher 2000, section 1.6.4).

Where the two are alike they are laid on each other and blended over a window. Where they are nowhere alike, what is
blended is each going on by inertia, out of the one's end and into the other's beginning.

What it does to contacts: outside the window nothing but the other motion's place and direction changes, so contacts
hold. Inside, feet slide by about as much as the poses differ; give them back by inverse kinematics.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from mtex_usd.edit.blending import check_same_joints
from mtex_usd.edit.cleaning.report import Finding
from mtex_usd.edit.coasting import coast_from, coast_into
from mtex_usd.edit.mixing import Strand, make_strand, mix_strands
from mtex_usd.edit.pose_features import check_pair
from mtex_usd.edit.root import choose_root
from mtex_usd.edit.transitions import (
    Transition,
    find_transition,
    half_window,
    is_itself,
    least_loop,
    measure_transition,
)
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.motion.arguments import as_frame, as_word, refuse
from mtex_usd.motion.clip import Clip

__all__ = ["JoinResult", "join"]

FloatArray = npt.NDArray[np.float64]

Method = Literal["auto", "blend", "interpolate"]

_ALIKE_M = 0.12  # farther apart than this motions are interpolated, not blended
_FASTER = 1.2  # times the sources' fastest turn that a joint may turn in the window
_WIDER = 1.25  # from one window that is tried to the next
_LONGEST_S = 2.0  # of the windows that are tried
_STILL = np.radians(0.01)  # per frame: a joint that turns no faster in either motion has no speed to keep to


@dataclass(frozen=True, eq=False, kw_only=True)
class JoinResult:
    """Two motions joined, or one closed to a loop.

    Parameters
    ----------
    clip
        The whole; a loop's last frame is its first, but for place and direction.
    transition
        Where the one was left and the other entered.
    first, last
        The frames of the whole in between, both included, where it is neither the one nor the other; none where last
        is before first.
    method
        How they were filled: ``blend`` or ``interpolate``.
    notes
        What could not be as it should.
    """

    clip: Clip
    transition: Transition
    first: int
    last: int
    method: str
    notes: tuple[Finding, ...] = ()


@dataclass(frozen=True, eq=False)
class _Middle:
    """One way to fill the middle, from the frame that is left to the frame that is entered, both included."""

    left: int
    entered: int
    strand: Strand
    excess: FloatArray
    """How fast each joint turns there over the fastest it may, [J]."""

    @property
    def worst(self) -> float:
        return float(self.excess.max())


def join(
    clip: Clip,
    other: Clip,
    *,
    transition: Transition | None = None,
    blend_s: float = 0.4,
    method: Method = "auto",
) -> JoinResult:
    """Let one motion go over into another, or close a motion to a loop.

    Parameters
    ----------
    clip
        The motion to begin with, bit for bit until it is left.
    other
        The motion to go over into, on the same joints and at the same rate; it is moved over the floor to where the
        clip has gone, and the way that faces. The clip itself to close it to a loop.
    transition
        Where to leave and to enter; None for where they are most alike.
    blend_s
        How long to blend, or at least to interpolate, seconds; longer, up to 2 s, where a joint would else turn more
        than 1.2 times as fast as anywhere in the two motions.
    method
        ``blend``, ``interpolate`` (from the clip's end to the other's beginning, or between the frames of the
        `transition`), or ``auto``, which interpolates where the motions are nowhere within 0.12 m of each other.

    Returns
    -------
    JoinResult
        With a note for joints that turn too fast all the same.

    Raises
    ------
    InputError
        Different joints or rates, an empty window, a transition without room for it, an unknown method.

    Notes
    -----
    Contacts: blended where they are alike, feet are as still as before, on the sample walks within 1.3 cm.
    Interpolated, they go straight from one stance to the other: a walk into a stand draws the planted foot 22 cm
    over the floor in 0.4 s.

    What is most alike may be near one's end and the other's beginning, or the other way round, so that little of
    both is left: :func:`~mtex_usd.edit.find_transition` takes the frames to look in.

    Examples
    --------
    >>> cycle = join(walk, walk).clip  # doctest: +SKIP
    >>> longer = scale_time(cycle, factor=1.0, frame_count=2000, ends="loop")  # doctest: +SKIP
    """
    check_pair(clip, other)
    check_same_joints(clip, other)
    half = half_window(clip, blend_s)
    as_word(method, get_args(Method), "unknown method")
    _check_transition(clip, other, transition)
    at, is_blend = _choose(clip, other, transition, half, method)
    joint = choose_root([clip, other])
    strands = (make_strand(clip, joint), make_strand(other, joint))
    fill = _blend if is_blend else _interpolate
    limits = _FASTER * np.maximum(_fastest(clip), _fastest(other))
    middle = _best(fill(strands, at, count, limits) for count in _lengths(strands, at, half, is_blend=is_blend))
    return _put_together(strands, at, middle, "blend" if is_blend else "interpolate")


def _check_transition(clip: Clip, other: Clip, transition: object) -> None:
    if transition is None:
        return
    if not isinstance(transition, Transition):
        raise refuse(transition, "transition", "a Transition, as find_transition gives it")
    as_frame(transition.frame, f"transition, frame of {clip.name or 'the clip'}", clip)
    as_frame(transition.other_frame, f"transition, frame of {other.name or 'the other'}", other)


def _choose(
    clip: Clip, other: Clip, transition: Transition | None, half: int, method: Method
) -> tuple[Transition, bool]:
    """Choose the frames, and whether to blend there."""
    if method != "interpolate":
        fits = min(clip.frame_count, other.frame_count) > 2 * half + (
            least_loop(clip, half) if is_itself(clip, other) else 0
        )
        found = transition
        if found is None and (fits or method == "blend"):
            found = find_transition(clip, other, window_s=2.0 * half / clip.rate)
        if found is not None and (method == "blend" or found.distance <= _ALIKE_M):
            return _check_room(clip, other, found, half), True
    ends = transition or measure_transition(clip, other, clip.frame_count - 1, 0, half=half)
    return _check_room(clip, other, ends, 0), False


def _check_room(clip: Clip, other: Clip, at: Transition, half: int) -> Transition:
    if _room(clip, other, at) < half:
        raise InputError(
            "no room for the transition",
            expected=f"{half} frames before and after it in both motions, and in a loop between them",
            found=f"frames {at.frame} of {clip.frame_count} and {at.other_frame} of {other.frame_count}",
            fix="Use a shorter blend_s or other frames.",
        )
    return at


def _room(clip: Clip, other: Clip, at: Transition) -> int:
    """How many frames a window may reach to either side, below 0 where the frames are not there."""
    sides = [at.frame, clip.frame_count - 1 - at.frame, at.other_frame, other.frame_count - 1 - at.other_frame]
    if is_itself(clip, other):
        sides.append((at.frame - at.other_frame) // 2)
    return min(sides)


def _lengths(strands: tuple[Strand, Strand], at: Transition, half: int, *, is_blend: bool) -> Iterator[int]:
    """Lengths of the middle to try, in frames to either side where it is blended, in all where it is interpolated."""
    clip, other = strands[0].clip, strands[1].clip
    longest = round(_LONGEST_S * clip.rate)
    most = min(_room(clip, other, at), longest // 2) if is_blend else longest
    length = half if is_blend else 2 * half
    yield length
    while length < most:
        length = min(most, int(np.ceil(_WIDER * length)))
        yield length


def _blend(strands: tuple[Strand, Strand], at: Transition, half: int, limits: FloatArray) -> _Middle:
    left, entered = at.frame - half, at.other_frame + half
    pair = strands[0].cut(left, at.frame + half), strands[1].cut(at.other_frame - half, entered)
    return _ease_over(pair, left, entered, limits)


def _interpolate(strands: tuple[Strand, Strand], at: Transition, count: int, limits: FloatArray) -> _Middle:
    pair = coast_from(strands[0], at.frame, count), coast_into(strands[1], at.other_frame, count)
    return _ease_over(pair, at.frame, at.other_frame, limits)


def _ease_over(pair: tuple[Strand, Strand], left: int, entered: int, limits: FloatArray) -> _Middle:
    along = np.linspace(0.0, 1.0, pair[0].clip.frame_count)
    over = along * along * (3.0 - 2.0 * along)
    strand = mix_strands(pair, np.stack([1.0 - over, over], axis=1))
    turning = limits > _FASTER * _STILL
    excess = np.where(turning, _fastest(strand.clip) / np.where(turning, limits, 1.0), 0.0)
    return _Middle(left, entered, strand, excess)


def _fastest(clip: Clip) -> FloatArray:
    """Radians from frame to frame that each joint turns at most, [J]."""
    return np.asarray(quaternion.angle_between(clip.rotations[:-1], clip.rotations[1:]).max(axis=0))


def _best(tries: Iterator[_Middle]) -> _Middle:
    """Take the first try in which nothing turns too fast, else the one in which it does least."""
    best = next(tries)
    while best.worst > 1.0:
        following = next(tries, None)
        if following is None:
            break
        best = min(best, following, key=lambda middle: middle.worst)
    return best


def _put_together(strands: tuple[Strand, Strand], at: Transition, middle: _Middle, method: str) -> JoinResult:
    is_loop = is_itself(strands[0].clip, strands[1].clip)
    begin, end = (middle.entered, middle.entered) if is_loop else (0, strands[1].clip.frame_count - 1)
    rest = strands[1].cut(middle.entered, end).placed_after(middle.strand)
    whole = strands[0].cut(begin, middle.left).then(middle.strand).then(rest)
    first = middle.left - begin + 1
    last = first + middle.strand.clip.frame_count - 3
    return JoinResult(
        clip=whole.clip,
        transition=at,
        first=first,
        last=last,
        method=method,
        notes=_describe(whole.clip, middle, first, last),
    )


def _describe(clip: Clip, middle: _Middle, first: int, last: int) -> tuple[Finding, ...]:
    """Give a note for every joint that turns too fast."""
    return tuple(
        Finding(
            step="join",
            joint=clip.joints[joint],
            first=first,
            last=last,
            what=f"it turns {_FASTER * middle.excess[joint]:.2f} times as fast as anywhere in the two motions",
        )
        for joint in np.flatnonzero(middle.excess > 1.0)
    )
