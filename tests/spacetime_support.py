"""Where points are, for tests of constraints."""

import numpy as np

from mtex_usd.motion import quaternion


def follow(clip, point):
    """Where a point is at every frame, skeleton units, [F, 3]."""
    joint = clip.joints.index(point.joint)
    positions, world = clip.skeleton.world_pose(clip.rotations, clip.translations)
    return positions[:, joint] + quaternion.rotate(world[:, joint], np.array(point.offset))
