"""CMU captures as clips, read without USD."""

from functools import cache
from pathlib import Path

import numpy as np

from mtex_usd.formats.bvh import read_bvh
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["UNIT_M", "load_capture", "load_with_t_pose"]

UNIT_M = 0.05644


@cache
def load_with_t_pose(data_dir: Path, name: str) -> Clip:
    """Read a capture as its file has it: the first frame is an added T-pose."""
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
        rotations=recording.rotations,
        translations=recording.translations,
        scales=np.ones(recording.translations.shape),
        name=name,
    )


@cache
def load_capture(data_dir: Path, name: str, *, frames: int | None = None) -> Clip:
    """Read a capture, less the T-pose, from frame 0; its first frames only where a number is given."""
    whole = load_with_t_pose(data_dir, name)
    part = slice(1, None if frames is None else 1 + frames)
    return Clip(
        skeleton=whole.skeleton,
        rate=whole.rate,
        rotations=whole.rotations[part],
        translations=whole.translations[part],
        scales=whole.scales[part],
        name=name,
    )
