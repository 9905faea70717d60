"""An animation on the character that plays it, bit for bit and as a clip."""

from dataclasses import dataclass

from pxr import Usd

from mtex_usd.errors import StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.usd.animation import AnimationSamples, sample_sketch
from mtex_usd.usd.characters import Character
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.sampled_clip import fill_missing, to_clip

__all__ = ["Played", "read_played"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Played:
    """An animation on one character.

    Parameters
    ----------
    prim
        The SkelAnimation.
    skeleton_prim
        The first of the Skeletons that play it.
    samples
        The animation as USD gives it, bit for bit, missing attributes filled from rest.
    clip
        The animation on all joints of the character.
    """

    prim: Usd.Prim
    skeleton_prim: Usd.Prim
    samples: AnimationSamples
    clip: Clip


def read_played(stage: Usd.Stage, reader: ClipReader, character: Character) -> Played:
    """Read an animation on the character that plays it, at the frames of the stage.

    Parameters
    ----------
    stage
        The composed stage.
    reader
        Of the same stage.
    character
        Who plays it.

    Raises
    ------
    InputError, StageError
        Whatever is wrong with the animation or its Skeleton, and where it is a single pose.
    """
    prim, skeleton_prim = (stage.GetPrimAtPath(path) for path in (character.animation, character.skeletons[0]))
    skeleton = reader.read_skeleton(skeleton_prim)
    samples = fill_missing(sample_sketch(stage, prim), skeleton)
    if len(samples.time_codes) < 2:
        raise StageError(f"{prim.GetPath()} is a single pose", expected="an animation of at least two frames")
    return Played(prim=prim, skeleton_prim=skeleton_prim, samples=samples, clip=to_clip(samples, skeleton))
