"""The part of a skeleton that goals have to do with: their joints and what is above them.

The solver places all joints of a skeleton again and again, so it is given no more of it than it needs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.ik.goals import Goal
from mtex_usd.constraints.ik.limits import JointLimits
from mtex_usd.motion.clip import Clip

__all__ = ["Part", "take_part"]

IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """A clip of some of the joints, with what is said about them.

    Parameters
    ----------
    joints
        Which joints of the whole they are, ascending.
    clip
        Their motion.
    goals, limits
        As for the whole, with the joints numbered as in the part.
    """

    joints: IntArray
    clip: Clip
    goals: tuple[Goal, ...]
    limits: JointLimits | None

    def number(self, joints: IntArray) -> IntArray:
        """Give the numbers that joints of the whole have here."""
        return np.searchsorted(self.joints, joints)


def take_part(clip: Clip, goals: Sequence[Goal], limits: JointLimits | None) -> Part:
    """Take the joints of some goals, and all above them, out of a clip."""
    skeleton = clip.skeleton
    joints = np.array(sorted({above for goal in goals for above in skeleton.chain(goal.joint)}), dtype=np.intp)
    own = replace(skeleton, joints=tuple(skeleton.joints[joint] for joint in joints), rest=skeleton.rest[joints])
    numbers = {int(joint): number for number, joint in enumerate(joints)}
    return Part(
        joints=joints,
        clip=replace(
            clip,
            skeleton=own,
            rotations=clip.rotations[:, joints],
            translations=clip.translations[:, joints],
            scales=clip.scales[:, joints],
        ),
        goals=tuple(replace(goal, joint=numbers[goal.joint]) for goal in goals),
        limits=None if limits is None else limits.for_joints(joints),
    )
