"""The method from end to end on clips (Pullen & Bregler 2002, section 3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.motion.channels import Channel
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.candidates import Candidates, build_lattice, find_candidates, find_sketch_fragments
from mtex_usd.texture.diversity import find_diverse_paths
from mtex_usd.texture.finish import Finished, Finisher
from mtex_usd.texture.matching import MOST_SCALE
from mtex_usd.texture.paths import Path, find_paths
from mtex_usd.texture.pool import Matching, Pool, build_pool
from mtex_usd.texture.pyramid import decompose
from mtex_usd.texture.reading import Motion, choose_root, read_sketch, read_takes
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import FragmentUse, TexturedMotion, Variant
from mtex_usd.texture.roles import Roles, resolve_roles
from mtex_usd.texture.space import Space, choose_orders

__all__ = ["Ground", "animated_channels", "assemble_motion", "describe_path", "read_ground", "texture_motion"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

# A channel that moves less than this, in degrees or thousandths of the height, is not animated.
_STILL = 1e-3


def texture_motion(
    sketch: Clip, takes: Sequence[Clip], recipe: Recipe, *, held: Mapping[int, FloatArray] | None = None
) -> TexturedMotion:
    """Texture and synthesize a sketch from takes.

    Parameters
    ----------
    sketch
        The animator's motion on every joint of the character, joints it lacks at rest.
    takes
        Recorded motion at the sketch's rate, each on a skeleton of its own that holds every joint of a role; joints
        correspond by full path, then by unique last name.
    recipe
        What to match, texture and synthesize, and how.
    held
        How far the texturing of a joint is held back at every frame, 0 to 1, shape [F], by joint: as where its foot is
        on the floor (Pullen & Bregler 2002, section 4.1).

    Returns
    -------
    TexturedMotion
        At most ``recipe.paths`` variants, best first; fewer, with a note, where there are no more.

    Raises
    ------
    InputError
        Channels that do not resolve, a role joint no take has, takes too short, nothing to do.
    """
    ground = read_ground(sketch, takes, recipe)
    fragments = find_sketch_fragments(ground.roles, ground.pools, sketch.frame_count)
    candidates = find_candidates(ground.roles, ground.pools, fragments, recipe)
    finisher = ground.build_finisher(fragments, candidates, recipe, held or {})
    space = ground.space
    curves = [space.to_curves(finisher.take_copy(take)) for take in range(len(ground.takes))]
    sliding = np.concatenate([np.zeros(3 * len(space.whole), dtype=np.bool_), space.sliding])
    lattice = build_lattice(candidates, fragments, curves, sliding, recipe)
    if recipe.diversity > 0.0:
        chosen = find_diverse_paths(lattice, finisher, curves, recipe)
    else:
        chosen = [(path, finisher.finish(path.choice)) for path in find_paths(lattice, recipe.paths)]
    variants = tuple(_describe(rank, path, done, finisher) for rank, (path, done) in enumerate(chosen, start=1))
    notes = [*ground.roles.notes, *ground.absent, *_notes(ground.pools, finisher, recipe, len(variants))]
    breaks = np.append(fragments[:, 0], fragments[-1, 1])
    return assemble_motion(finisher, variants, breaks, notes)


@dataclass(frozen=True, eq=False)
class Ground:
    """Sketch and takes, read and measured: what paths are made on, whether they are searched or given.

    Parameters
    ----------
    sketch
        The sketch.
    takes
        The takes that have all joints with a role, in the order candidates count them.
    roles
        What is copied for what, and when.
    space
        What is copied, and how.
    pools
        The takes' fragments by way of matching.
    absent
        A note for each take left out.
    """

    sketch: Motion
    takes: tuple[Motion, ...]
    roles: Roles
    space: Space
    pools: dict[Matching, Pool]
    absent: tuple[str, ...]

    def build_finisher(
        self, fragments: IntArray, candidates: Sequence[Candidates], recipe: Recipe, held: Mapping[int, FloatArray]
    ) -> Finisher:
        """Give what makes paths through some candidates into motion.

        Parameters
        ----------
        fragments, candidates
            As :class:`~mtex_usd.texture.finish.Finisher` has them.
        recipe
            Tells the join time.
        held
            As there.
        """
        join_frames = round(recipe.join_time * self.sketch.clip.rate)
        return Finisher(self.sketch, self.takes, self.space, self.roles, fragments, candidates, join_frames, held)


def read_ground(sketch: Clip, takes: Sequence[Clip], recipe: Recipe) -> Ground:
    """Read and measure sketch and takes.

    Parameters
    ----------
    sketch, takes, recipe
        As for :func:`texture_motion`.

    Raises
    ------
    InputError
        As :func:`texture_motion`.
    """
    root = choose_root(sketch, takes)
    animated = animated_channels(sketch, root) if _matches_all(recipe) else ()
    roles = resolve_roles(recipe, sketch, animated)
    own = read_sketch(sketch, root, roles.heading_band)
    motions, absent = read_takes(takes, sketch, root, roles.heading_band, roles.used)
    space = _build_space(roles, root, own, motions)
    ways = dict.fromkeys(Matching.of_span(span) for span in roles.spans)
    pools = {way: build_pool(own, motions, space, way, recipe) for way in ways}
    return Ground(own, tuple(motions), roles, space, pools, tuple(absent))


def _matches_all(recipe: Recipe) -> bool:
    """Whether a match list is empty, which stands for every animated channel."""
    return not recipe.match or any(segment.match == () for segment in recipe.segments)


def animated_channels(sketch: Clip, root: int) -> tuple[Channel, ...]:
    """Give the channels that move in the sketch, the one with most energy in the paper's match band first.

    The order matters only where the recipe names neither match nor break channels.
    """
    motion = read_sketch(sketch, root, 4)
    moving = np.ptp(motion.rotations, axis=0).max(axis=-1) > 1e-6
    joints = [int(joint) for joint in np.flatnonzero(moving)]
    space = replace(_no_space(root), orders=choose_orders(joints, [motion], root))
    channels = [Channel(joint, kind) for joint in joints for kind in ("rx", "ry", "rz")]
    still = {True: _STILL, False: 1e-3 * _STILL * sketch.skeleton.height}
    shifting = np.flatnonzero(np.ptp(sketch.translations, axis=0).max(axis=-1) > still[False])
    channels += [Channel(int(joint), kind) for joint in shifting for kind in ("tx", "ty", "tz")]
    curves = {channel: space.read_channel(motion, channel) for channel in channels}
    animated = [channel for channel in channels if np.ptp(curves[channel]) > still[channel.is_rotation]]
    if not animated:
        return ()
    bands = decompose(np.stack([curves[channel] for channel in animated], axis=1))
    energy = dict(zip(animated, np.square(bands.sum_of(3, 5)).sum(axis=0).tolist(), strict=True))
    return tuple(sorted(animated, key=lambda c: (not c.is_rotation, -energy[c] if c.is_rotation else 0.0)))


def _no_space(root: int) -> Space:
    return Space(root, (), (), {}, np.empty((0, 4)))


def _build_space(roles: Roles, root: int, own: Motion, motions: Sequence[Motion]) -> Space:
    """Choose Euler orders for the joints read in angles, and centre the whole joints on their mean rotations."""
    space = Space.of_roles(roles, root, {})
    joints = _turning_joints(roles)
    space = replace(space, orders=choose_orders(joints, [own, *motions], root))
    textured = any(span.texture for span in roles.spans)
    return space.centred_on([own, *motions] if textured else motions)


def _turning_joints(roles: Roles) -> list[int]:
    """Joints with a role for one of their rotations."""
    return sorted({channel.joint for channel in roles.used if channel.is_rotation})


def describe_path(rank: int, choice: Sequence[int], joins: int, done: Finished, finisher: Finisher) -> Variant:
    """Say where the fragments of a finished path come from.

    Parameters
    ----------
    rank
        1 is the best.
    choice
        Index of the candidate per sketch fragment, length Q.
    joins
        How many joins were consecutive in their take.
    done, finisher
        What was made of the path, and what made it.
    """
    uses = tuple(_describe_fragment(q, k, finisher) for q, k in enumerate(choice))
    return Variant(
        rank=rank,
        distance=sum(use.distance for use in uses),
        zero_cost_joins=joins,
        fragments=uses,
        clip=done.clip,
        joined=done.joined,
        curves=done.curves,
    )


def _describe(rank: int, path: Path, done: Finished, finisher: Finisher) -> Variant:
    return describe_path(rank, path.choice, len(path.joins), done, finisher)


def _describe_fragment(q: int, k: int, finisher: Finisher) -> FragmentUse:
    found = finisher.candidates[q]
    take, sketch = finisher.takes[int(found.take[k])].clip, finisher.sketch.clip
    first, last = finisher.fragments[q]
    return FragmentUse(
        start=_time_code(sketch, first),
        end=_time_code(sketch, last),
        take=take.name,
        take_start=_time_code(take, found.first[k]),
        take_end=_time_code(take, found.last[k]),
        distance=float(found.distance[k]),
        scale=float(found.scale[k]),
        band=finisher.roles.span_at(int(first)).match_band,
    )


def _time_code(clip: Clip, frame: float) -> float:
    return float(clip.start + clip.time_codes_per_frame * frame)


def _notes(pools: dict[Matching, Pool], finisher: Finisher, recipe: Recipe, found: int) -> list[str]:
    """Say what a user should know about takes, limits and variants."""
    skipped = dict.fromkeys(take for pool in pools.values() for take in pool.skipped)
    notes = [f"take {finisher.takes[take].clip.name} is skipped: too short for one fragment" for take in skipped]
    times = finisher.sketch.clip.time_codes
    for (first, last), found_here in zip(finisher.fragments, finisher.candidates, strict=True):
        if found_here.stretch_lifted:
            notes.append(
                f"no take fragment is within {recipe.max_stretch:g} lengths of {times[first]:g} to {times[last]:g}; "
                "the limit was lifted there"
            )
    if any((candidates.scale == MOST_SCALE).any() for candidates in finisher.candidates):
        notes.append(f"the scale factor was held at {MOST_SCALE:g}: some takes move far less than the sketch")
    if found < recipe.paths:
        notes.append(f"{found} of {recipe.paths} variants: there are no more different ones")
    return notes


def assemble_motion(
    finisher: Finisher, variants: tuple[Variant, ...], breaks: IntArray, notes: Sequence[str]
) -> TexturedMotion:
    """Put variants together with what they are to be checked by.

    Parameters
    ----------
    finisher
        What made them, or the last of those that did: what is read off it is the same for all of one ground.
    variants
        Best first.
    breaks
        Frames of the sketch's breaks, shape [Q + 1].
    notes
        What a user should know.
    """
    space, sketch = finisher.space, finisher.sketch.clip
    return TexturedMotion(
        sketch=sketch,
        channels=tuple(channel.name(sketch.joints) for channel in space.channels),
        sketch_curves=finisher.sketch_curves,
        textured=finisher.textured,
        synthesized=finisher.synthesized,
        rotation_orders={sketch.joints[joint]: order for joint, order in space.orders.items()},
        mean_rotations={sketch.joints[j]: mean for j, mean in zip(space.whole, space.means, strict=True)},
        breaks=breaks,
        variants=variants,
        notes=tuple(notes),
    )
