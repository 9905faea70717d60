"""How a result came about, worked out again: candidates, and a path before and after its fragments were joined.

A result keeps what was made and where it comes from, not the steps between. They follow from the same takes and
settings by the same functions, in a fraction of a second.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mtex_usd.errors import ResultError
from mtex_usd.motion import quaternion
from mtex_usd.motion.channels import KINDS, Channel, to_skeleton_rotations, to_skeleton_translations
from mtex_usd.motion.clip import Clip
from mtex_usd.review.shot import ReviewedCharacter
from mtex_usd.texture.candidates import Candidates, find_candidates
from mtex_usd.texture.engine import Ground, read_ground
from mtex_usd.texture.fragments import cut_at
from mtex_usd.texture.reading import Motion
from mtex_usd.texture.result import FragmentUse, Variant
from mtex_usd.texture.space import Copied, Space, choose_orders

__all__ = ["Joining", "Retraced", "retrace"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Joining:
    """One path on its way from fragments to a motion; columns as :attr:`Retraced.space`.

    Parameters
    ----------
    captured
        The stretched fragments end to end, the frames they share twice, shape [F + Q - 1, C].
    skewed
        Made to meet, shape [F, C].
    joined
        Blended as well, shape [F, C].
    continued
        Whether the two fragments at each join were consecutive in their take, shape [Q - 1].
    """

    captured: FloatArray
    skewed: FloatArray
    joined: FloatArray
    continued: BoolArray


@dataclass(frozen=True, eq=False)
class Retraced:
    """A result with the steps that led to it.

    Parameters
    ----------
    character
        What was made.
    ground
        Sketch and takes as the method read them.
    fragments
        Sketch fragments, shape [Q, 2].
    candidates
        Candidates per sketch fragment, length Q.
    space
        The columns that can be shown: those copied, then those matched, then those that contacts changed.
    """

    character: ReviewedCharacter
    ground: Ground
    fragments: IntArray
    candidates: tuple[Candidates, ...]
    space: Space

    @property
    def join_frames(self) -> int:
        """N of the joining blend."""
        return round(self.character.recipe.join_time * self.character.sketch.rate)

    @cached_property
    def take_numbers(self) -> dict[str, int]:
        """Which take a name is, as candidates count them."""
        return {take.clip.name: number for number, take in enumerate(self.ground.takes)}

    @cached_property
    def sketch_curves(self) -> FloatArray:
        """The sketch, shape [F, C]."""
        return self.space.to_curves(self.space.read(self.ground.sketch))

    @cached_property
    def finished_curves(self) -> FloatArray:
        """The variants as they were finished, contacts held, shape [V, F, C]."""
        return np.stack([self._read_finished(variant.clip) for variant in self.character.variants])

    @cached_property
    def joinings(self) -> tuple[Joining, ...]:
        """The variants' paths before and after joining, length V."""
        return tuple(self._join(variant.motion) for variant in self.character.variants)

    def read_take_curves(self, take: int) -> FloatArray:
        """One take on the turn nearest the sketch, shape [F, C]."""
        return self._near_sketch(self.space.to_curves(self.space.read(self.ground.takes[take])))

    def _near_sketch(self, curves: FloatArray) -> FloatArray:
        """Shift single angles by whole turns to where the sketch has them on the mean, shape [F, C]."""
        return curves + self._turns(self.sketch_curves.mean(axis=0) - curves.mean(axis=0))

    def locate(self, use: FragmentUse) -> tuple[int, float, float]:
        """Give the take's number and the frames in it that a fragment is copied from."""
        number = self.take_numbers[use.take]
        clip = self.ground.takes[number].clip
        frames = (np.array([use.take_start, use.take_end]) - clip.start) / clip.time_codes_per_frame
        first, last = np.round(frames, 6).tolist()
        return number, first, last

    def find_choice(self, variant: Variant) -> list[int]:
        """Give the candidate that each fragment of a variant is, -1 for one that is none of them."""
        return [self._find(q, self.locate(use)) for q, use in enumerate(variant.fragments)]

    def _find(self, q: int, place: tuple[int, float, float]) -> int:
        found = self.candidates[q]
        same = (found.take == place[0]) & (found.first == place[1]) & (found.last == place[2])
        return int(np.argmax(same)) if same.any() else -1

    def _turns(self, gap: FloatArray) -> FloatArray:
        """The whole turns in a gap [..., C], for columns that are single angles."""
        turning = np.concatenate([np.zeros(3 * len(self.space.whole), dtype=np.bool_), self.space.turning])
        return np.where(turning, 360.0 * np.round(gap / 360.0), 0.0)

    def _read_finished(self, clip: Clip) -> FloatArray:
        """Read a variant as the sketch was read, its root in the sketch's facing frame."""
        own, root = self.ground.sketch, self.space.root
        rotations = to_skeleton_rotations(clip.rotations, clip.skeleton)
        offsets = to_skeleton_translations(clip.translations, clip.skeleton)
        rotations[:, root] = own.facing.into(rotations[:, root])
        motion = Motion(clip, rotations, offsets, own.facing.unroll_travel(offsets[:, root]), own.facing)
        return self._near_sketch(self.space.to_curves(self.space.read(motion)))

    def _join(self, variant: Variant) -> Joining:
        chosen = [_only(*self.locate(use), use.scale) for use in variant.fragments]
        ground = replace(self.ground, space=self.space)
        finisher = ground.build_finisher(self.fragments, chosen, self.character.recipe, {})
        first = [0] * len(chosen)
        pieces, continued = finisher.take_pieces(first), finisher.find_continued(first)
        met = finisher.join_pieces(pieces, np.ones(len(continued), dtype=np.bool_))
        blended = finisher.join_pieces(pieces, continued)
        skewed, joined = (self._near_sketch(self.space.to_curves(copied)) for copied in (met, blended))
        placed = [self._place(piece, skewed[begin]) for piece, begin in zip(pieces, self.fragments[:, 0], strict=True)]
        return Joining(np.concatenate(placed), skewed, joined, continued)

    def _place(self, piece: Copied, begin: FloatArray) -> FloatArray:
        """Lay a fragment where the joined path has it: on the turn nearest, root travel carrying on."""
        split = 3 * len(self.space.whole)
        curves = self.space.to_curves(piece)
        vectors = np.concatenate([begin[None, :split], curves[:, :split]]).reshape(len(curves) + 1, -1, 3)
        near = np.degrees(quaternion.unroll_vectors(np.radians(vectors)))[1:].reshape(len(curves), split)
        gap = begin - curves[0]
        shift = np.where(self._sliding, gap, self._turns(gap))[split:]
        return np.concatenate([near, curves[:, split:] + shift], axis=1)

    @cached_property
    def _sliding(self) -> BoolArray:
        return np.concatenate([np.zeros(3 * len(self.space.whole), dtype=np.bool_), self.space.sliding])


def retrace(character: ReviewedCharacter) -> Retraced:
    """Work out again how a result came about.

    Parameters
    ----------
    character
        The result with the takes and the settings it was made with.

    Raises
    ------
    ResultError
        Where they are not those it was made with.
    """
    texturing = character.texturing
    ground = read_ground(texturing.sketch, character.takes, character.recipe)
    fragments = cut_at(texturing.breaks)
    candidates = find_candidates(ground.roles, ground.pools, fragments, character.recipe)
    _check(character, ground)
    return Retraced(character, ground, fragments, candidates, _shown_space(character, ground))


def _check(character: ReviewedCharacter, ground: Ground) -> None:
    """Refuse takes or settings that do not belong to the result."""
    names = tuple(channel.name(character.sketch.joints) for channel in ground.space.channels)
    used = {use.take for variant in character.variants for use in variant.fragments}
    absent = used - {take.clip.name for take in ground.takes}
    if names != character.channels or absent:
        raise ResultError(
            f"{character.anim}: the review's takes or settings are not those its variants were made with",
            expected=f"{len(character.channels)} copied channels, takes {', '.join(sorted(used))}",
            found=f"{len(names)} copied channels, without takes {', '.join(sorted(absent)) or 'none'}",
        )


def _shown_space(character: ReviewedCharacter, ground: Ground) -> Space:
    """The space of what is copied, with what is matched and what contacts changed as further single curves."""
    space, roles = ground.space, ground.roles
    matched = [channel for span in roles.spans for channel in (span.break_channel, *span.match)]
    held = [
        Channel(joint, kind)
        for joint in _held_joints(character)
        for kind in KINDS[:3]
        if Channel(joint, kind) not in space.channels
    ]
    extra = tuple(channel for channel in dict.fromkeys([*matched, *held]) if channel not in space.single)
    missing = sorted({channel.joint for channel in extra if channel.is_rotation} - set(space.orders))
    orders = {**space.orders, **choose_orders(missing, [ground.sketch], space.root)}
    return replace(space, single=(*space.single, *extra), orders=orders)


def _held_joints(character: ReviewedCharacter) -> list[int]:
    """Joints that turn in some variant otherwise than in the sketch."""
    sketch = character.sketch.rotations
    changed = [np.abs(variant.clip.rotations - sketch).max(axis=(0, 2)) > 1e-6 for variant in character.variants]
    return [int(joint) for joint in np.flatnonzero(np.any(changed, axis=0))] if changed else []


def _only(take: int, first: float, last: float, scale: float) -> Candidates:
    """A list of one candidate."""
    return Candidates(
        np.array([take]), np.array([first]), np.array([last]), np.zeros(1), np.array([scale]), stretch_lifted=False
    )
