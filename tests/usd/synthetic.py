"""Synthetic results: the source animation turned by a known angle per variant, with one joint added."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd

from mtex_usd.motion import quaternion
from mtex_usd.usd.characters import Character, find_characters
from mtex_usd.usd.override import CharacterResult, VariantSamples, variant_names
from tests.usd.playback import animation_arrays
from tests.usd.stage_parts import ADDED_JOINT, OFFSETS, Situation

VARIANTS = 3


def make_results(
    stage: Usd.Stage, situation: Situation, *, variants: int = VARIANTS, previous: Path | None = None
) -> tuple[CharacterResult, ...]:
    """Find the characters of a situation and give each its variants."""
    paths = [Sdf.Path(animation) for animation in situation.animations]
    characters = find_characters(stage, paths, previous=previous)
    return tuple(make_result(stage, character, i, variants) for i, character in enumerate(characters))


def make_result(stage: Usd.Stage, character: Character, number: int, variants: int = VARIANTS) -> CharacterResult:
    """Turn every joint of the source by an angle that tells characters and variants apart."""
    start, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    time_codes = np.linspace(start, end, 13)
    joints, rotations, translations = animation_arrays(stage, str(character.animation), time_codes.tolist())
    samples = tuple(
        _make_variant(joints, time_codes, rotations, translations, 5.0 * (k + 1) + 0.5 * number)
        for k in range(variants)
    )
    return CharacterResult(character=character, names=variant_names(len(samples)), variants=samples)


def _make_variant(
    joints: tuple[str, ...],
    time_codes: npt.NDArray[np.float64],
    rotations: npt.NDArray[np.float64],
    translations: npt.NDArray[np.float64],
    degrees: float,
) -> VariantSamples:
    frames = len(time_codes)
    turn = quaternion.exp(np.radians([0.0, degrees, 0.0]))
    arm = quaternion.exp(np.radians(np.outer(np.linspace(0, degrees, frames), [0.0, 0.0, 1.0])))
    added = np.broadcast_to(OFFSETS[ADDED_JOINT], (frames, 1, 3))
    return VariantSamples(
        joints=(*joints, ADDED_JOINT),
        time_codes=time_codes,
        rotations=np.concatenate(
            [quaternion.multiply(rotations, np.broadcast_to(turn, rotations.shape)), arm[:, None]], axis=1
        ).astype(np.float32),
        translations=np.concatenate([translations, added], axis=1).astype(np.float32),
        scales=np.ones((frames, len(joints) + 1, 3), dtype=np.float16),
        custom_data=make_custom_data(round(degrees)),
    )


def make_custom_data(rank: int) -> dict[str, object]:
    """Give what the contract asks of customData, with values to tell variants apart."""
    fragment = {"start": 1.0, "end": 31.0, "take": "/Takes/walk_1", "takeStart": 4.0, "takeEnd": 30.0}
    return {
        "rank": rank,
        "distance": 12.5 * rank,
        "zeroCostJoins": 1,
        "rotationOrders": {"Hips": "ZYX", ADDED_JOINT: "XYZ"},
        "fragments": [
            {**fragment, "distance": 2.5, "scale": 1.0},
            {**fragment, "start": 31.0, "end": 61.0, "distance": 1.5, "scale": 0.5},
        ],
    }
