"""CMU captures as clips, for the tests of edits."""

from functools import cache
from pathlib import Path

import numpy as np

from mtex_usd.formats.bvh import read_bvh
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

UNIT_M = 0.05644


@cache
def load(data_dir: Path, name: str) -> Clip:
    """Read a capture, less the frame of the added T-pose."""
    folder = "91_from_amc" if name.startswith("91") else name[:2]
    recording = read_bvh(data_dir / "cmu_bvh" / folder / f"{name}.bvh")
    joints: list[str] = []
    for joint, parent in zip(recording.names, recording.parents, strict=True):
        joints.append(joint if parent < 0 else f"{joints[parent]}/{joint}")
    rest = np.tile(np.eye(4), (len(joints), 1, 1))
    rest[:, 3, :3] = recording.offsets
    return Clip(
        skeleton=Skeleton(joints=tuple(joints), rest=rest, meters_per_unit=UNIT_M),
        rate=recording.rate,
        rotations=recording.rotations[1:],
        translations=recording.translations[1:],
        scales=np.ones(recording.translations[1:].shape),
        name=name,
    )
