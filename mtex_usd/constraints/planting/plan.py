"""What is to be held when: contacts as a whole-motion solve takes them, and the limbs they are about."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.contacts import Contact, body_scale
from mtex_usd.constraints.kinematics import place_points
from mtex_usd.constraints.spacetime import Constraint, PlaneOn, Point, PointAt, PointStill
from mtex_usd.motion.anatomy import SIDES, find_anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.texture.roles import ramp

__all__ = ["Hold", "describe_holds", "find_limb", "held_back", "merge_holds", "plan_contacts", "to_constraints"]

FloatArray = npt.NDArray[np.float64]

_LEG = ("thigh", "shin", "foot", "toes")
_ARM = ("clavicle", "upperArm", "foreArm", "hand")


@dataclass(frozen=True, eq=False, kw_only=True)
class Hold:
    """One point that is held for some frames.

    Parameters
    ----------
    name
        What messages call it; unique in a plan.
    joint
        Index of the joint the point moves with.
    offset
        The point in the joint's space, skeleton units, shape [3].
    first, last
        Frames, both included.
    still
        Whether the point keeps still, wherever that is; else only its height or its places count.
    height
        Height along up it is to have, skeleton units; None for any.
    keeps_height
        Whether it keeps the height that the motion it is held on has at the first frame.
    places
        Where it is to be at every frame, skeleton space, shape [N, 3]; None for anywhere.
    carried
        What it moves with from where the motion it is held on has it at the first frame: transforms into skeleton
        space, row vectors, shape [N, 4, 4]; None for nothing.
    tolerance
        Metres.
    """

    name: str
    joint: int
    offset: FloatArray
    first: int
    last: int
    still: bool = False
    height: float | None = None
    keeps_height: bool = False
    places: FloatArray | None = None
    carried: FloatArray | None = None
    tolerance: float = 0.0005

    @property
    def frames(self) -> npt.NDArray[np.intp]:
        """All its frames, shape [N]."""
        return np.arange(self.first, self.last + 1)


def plan_contacts(contacts: Sequence[Contact], clip: Clip, *, within_m: float = 0.015) -> tuple[Hold, ...]:
    """Plan to keep detected contacts: every point still, and at the height it was found at.

    Parameters
    ----------
    contacts
        As :func:`mtex_usd.constraints.contacts.detect_contacts` gives them.
    clip
        The motion they were found on.
    within_m
        Frames at either end at which the point is farther than this from where it is planted are not held, metres
        on an average adult: there it comes and goes.

    Returns
    -------
    tuple of Hold
        One per contact of which two frames at least are left.
    """
    holds = []
    for number, contact in enumerate(contacts, start=1):
        first, last = _near_frames(contact, clip, within_m * body_scale(clip.skeleton))
        if last <= first:
            continue
        holds.append(
            Hold(
                name=f"{contact.effector.name} {number}",
                joint=contact.effector.joint,
                offset=contact.effector.offset,
                first=first,
                last=last,
                still=True,
                height=float(contact.point @ clip.skeleton.up),
            )
        )
    return tuple(holds)


def merge_holds(declared: Sequence[Hold], found: Sequence[Hold]) -> tuple[Hold, ...]:
    """Add what was found to what is declared: a joint of which anything is declared is held as declared alone."""
    joints = {hold.joint for hold in declared}
    return (*declared, *(hold for hold in found if hold.joint not in joints))


def _near_frames(contact: Contact, clip: Clip, within: float) -> tuple[int, int]:
    """First and last frame at which a point is where it is planted, or nearly."""
    frames = slice(contact.first, contact.last + 1)
    joint, offset = [contact.effector.joint], np.asarray(contact.effector.offset)[None]
    places = place_points(clip.skeleton, joint, offset, clip.rotations[frames], clip.translations[frames])[:, 0]
    near = np.flatnonzero(np.linalg.norm(places - contact.point, axis=-1) <= within)
    return (contact.first + int(near[0]), contact.first + int(near[-1])) if near.size else (0, 0)


def to_constraints(holds: Sequence[Hold], clip: Clip) -> tuple[Constraint, ...]:
    """Give the constraints a solve has to meet.

    Parameters
    ----------
    holds, clip
        What is held, and on which motion.
    """
    settled = [_settle(hold, clip) for hold in holds]
    return tuple(constraint for hold in settled for constraint in _constrain(hold, clip.skeleton))


def _settle(hold: Hold, clip: Clip) -> Hold:
    """Read off the motion what a hold leaves to it."""
    if not hold.keeps_height and hold.carried is None:
        return hold
    frames = slice(hold.first, hold.first + 1)
    offset = np.asarray(hold.offset)[None]
    poses = (clip.rotations[frames], clip.translations[frames])
    begin = place_points(clip.skeleton, [hold.joint], offset, *poses)[0, 0]
    if hold.carried is None:
        return replace(hold, height=float(begin @ clip.skeleton.up))
    local = np.array([*begin, 1.0]) @ np.linalg.inv(hold.carried[0])
    return replace(hold, places=(local @ hold.carried)[:, :3])


def _constrain(hold: Hold, skeleton: Skeleton) -> list[Constraint]:
    # Solved twice as exactly as asked for: what is written is single precision.
    tolerance = hold.tolerance / 2.0
    x, y, z = map(float, hold.offset)
    point = Point(skeleton.joints[hold.joint], (x, y, z))
    if hold.places is not None:
        return [PointAt(hold.name, point, hold.frames, hold.places, tolerance=tolerance)]
    found: list[Constraint] = []
    if hold.still and hold.last > hold.first:
        found.append(PointStill(hold.name, point, hold.frames, tolerance=tolerance))
    if hold.height is not None:
        found.append(PlaneOn(f"{hold.name}, height", point, hold.frames, hold.height, tolerance=tolerance))
    return found


def describe_holds(holds: Sequence[Hold], clip: Clip) -> list[dict[str, object]]:
    """Give holds as plain data: name, joint path, offset, first and last time code.

    Parameters
    ----------
    holds, clip
        What is held, and in which motion.
    """
    times, joints = clip.time_codes, clip.joints
    return [
        {
            "name": hold.name,
            "joint": joints[hold.joint],
            "offset": [float(value) for value in hold.offset],
            "start": float(times[hold.first]),
            "end": float(times[hold.last]),
        }
        for hold in holds
    ]


def find_limb(skeleton: Skeleton, joint: int) -> tuple[int, ...]:
    """Give the joints of the limb a joint is on, from its first joint down to its tips.

    Parameters
    ----------
    skeleton
        A humanoid, or anything else.
    joint
        A joint of the limb.

    Returns
    -------
    tuple of int
        Of a humanoid the leg from the thigh or the arm from the clavicle on; else the joint, the two above it as far as
        there are, and all below. A joint of the trunk is on no limb.
    """
    chain = skeleton.chain(joint)
    anatomy = find_anatomy(skeleton)
    if anatomy is None:
        return _below(skeleton, chain[-3:][0])
    for side in SIDES:
        for limb in (_LEG, _ARM):
            begins = [anatomy.parts[f"{side}.{part}"] for part in limb if f"{side}.{part}" in anatomy.parts]
            if begins and begins[0] in chain:
                return _below(skeleton, begins[0])
    return ()


def _below(skeleton: Skeleton, top: int) -> tuple[int, ...]:
    """A joint and all joints below it."""
    return tuple(joint for joint in range(len(skeleton.joints)) if top in skeleton.chain(joint))


def held_back(
    holds: Sequence[Hold], skeleton: Skeleton, *, frame_count: int, ramp_frames: int
) -> dict[int, FloatArray]:
    """Tell how far texturing is held back, joint by joint: wholly while a point of the limb is held.

    Parameters
    ----------
    holds, skeleton
        What is held.
    frame_count
        Of the motion (F).
    ramp_frames
        How long it takes to come and go, frames, so that nothing pops at the borders.

    Returns
    -------
    dict
        Weights 0 to 1, shape [F], by joint (Pullen & Bregler 2002, section 4.1: the lower body is textured only while
        its foot is off the floor).
    """
    steps: dict[int, FloatArray] = {}
    for hold in holds:
        for joint in find_limb(skeleton, hold.joint):
            step = steps.setdefault(joint, np.zeros(frame_count))
            step[hold.first : hold.last + 1] = 1.0
    return {joint: ramp(step[:, None], ramp_frames)[:, 0] for joint, step in steps.items()}
