"""Retargeting that keeps contacts (Gleicher 2000, section 1.7.2.4): feet that stood still on one body do on another."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.contacts import Contact, Effector, detect_contacts, find_effectors
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.planting.holding import Held, hold_motion
from mtex_usd.constraints.planting.plan import Hold, plan_contacts
from mtex_usd.constraints.retargeting import JointMap, Pair, as_pairs, map_joints, retarget_mapped
from mtex_usd.constraints.retargeting.body import stands_near_zero
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["retarget_with_contacts"]


def retarget_with_contacts(
    clip: Clip,
    onto: Skeleton | Clip,
    *,
    contacts: Sequence[Contact] | None = None,
    pairs: Sequence[Pair | tuple[str, str]] = (),
    frequency: float = 6.0,
) -> Held:
    """Put a motion on another humanoid's skeleton, its feet standing where and when they stood.

    Parameters
    ----------
    clip, onto
        As :func:`mtex_usd.constraints.retargeting.retarget` takes them.
    contacts
        Contacts of the motion's heels and toes; those found on it where None.
    pairs
        As that function takes them.
    frequency
        The highest frequency of the change, Hz.

    Returns
    -------
    Held
        The motion, on all joints of the character. Every foot point keeps still while it did on the motion, at a height
        in proportion to the legs.

    Raises
    ------
    InputError
        Where one of the skeletons is no humanoid, or a pair names a joint that is not there.
    NoSolutionError
        Where the contacts cannot be met on the character.
    """
    skeleton = onto.skeleton if isinstance(onto, Clip) else onto
    said = as_pairs(pairs)
    joint_map = map_joints(clip.skeleton, skeleton, said)
    motion = retarget_mapped(clip, joint_map, like=onto if isinstance(onto, Clip) else None)
    found = plan_contacts(detect_contacts(clip) if contacts is None else contacts, clip)
    holds = _carry_over(found, motion, joint_map)
    return hold_motion(_set_down(motion, holds, joint_map), holds, frequency=frequency)


def _set_down(motion: Clip, holds: Sequence[Hold], joint_map: JointMap) -> Clip:
    """Move the whole motion up or down to where its contacts are on the whole, so that feet in the air come along."""
    gaps = [(hold.height or 0.0) - float(np.median(_track(hold, motion) @ motion.skeleton.up)) for hold in holds]
    hips = joint_map.anatomies[1].parts["hips"]
    if not gaps or motion.skeleton.parents[hips] >= 0:
        return motion
    translations = np.array(motion.translations)
    translations[:, hips] += np.median(gaps) * motion.skeleton.up
    return replace(motion, translations=translations)


def _track(hold: Hold, motion: Clip) -> npt.NDArray[np.float64]:
    """Where the motion has the point that is held, shape [N, 3]."""
    poses = (motion.rotations[hold.frames], motion.translations[hold.frames])
    return place_points(motion.skeleton, [hold.joint], np.asarray(hold.offset)[None], *poses)[:, 0]


def _carry_over(holds: Sequence[Hold], motion: Clip, joint_map: JointMap) -> tuple[Hold, ...]:
    """The same holds on the character's feet."""
    effectors = {effector.name: effector for effector in find_effectors(motion.skeleton, clip=motion)}
    carried = []
    for name, group in _by_point(holds).items():
        if name in effectors:
            levels = _find_levels(group, effectors[name], joint_map)
            moved = {"joint": effectors[name].joint, "offset": effectors[name].offset}
            carried += [replace(hold, height=level, **moved) for hold, level in zip(group, levels, strict=True)]  # type: ignore[arg-type]
    return tuple(carried)


def _by_point(holds: Sequence[Hold]) -> dict[str, list[Hold]]:
    groups: dict[str, list[Hold]] = {}
    for hold in holds:
        groups.setdefault(hold.name.rpartition(" ")[0], []).append(hold)
    return groups


def _find_levels(holds: Sequence[Hold], effector: Effector, joint_map: JointMap) -> list[float]:
    """Heights for the character: what is stepped onto in proportion, from where its own point stands.

    Where its rest pose stands on the floor that is the point's height there; else the motion's own in proportion.
    """
    heights = [hold.height or 0.0 for hold in holds]
    skeleton, body = joint_map.stance.target, joint_map.stance.bodies[1]
    point = skeleton.rest_positions[effector.joint]
    point = point + quaternion.rotate(skeleton.rest_orientations[effector.joint], effector.offset)
    own = float(quaternion.rotate(body.upright, point) @ skeleton.up)
    if not stands_near_zero(skeleton, joint_map.anatomies[1], body):
        return [joint_map.scale * height for height in heights]
    return [own + joint_map.scale * (height - min(heights)) for height in heights]
