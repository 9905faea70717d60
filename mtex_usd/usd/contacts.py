"""Contacts declared on an animation, as points to hold in the character's space."""

import numpy as np
from pxr import Usd, UsdGeom

from mtex_usd.constraints.contacts import Contact, Effector, detect_contacts
from mtex_usd.constraints.planting import Hold
from mtex_usd.errors import InputError, StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray
from mtex_usd.usd.schema import ContactSettings, read_contacts

__all__ = ["check_standing", "declared_frequency", "read_holds"]

_FREQUENCY = 6.0


def read_holds(prim: Usd.Prim, skeleton_prim: Usd.Prim, clip: Clip, contacts: str) -> tuple[Hold, ...]:
    """Read the contacts declared on an animation.

    Parameters
    ----------
    prim
        The SkelAnimation with MtexContactAPI.
    skeleton_prim
        The Skeleton that plays it.
    clip
        The animation on all joints of the Skeleton.
    contacts
        ``mtex:contacts`` of the recipe.

    Returns
    -------
    tuple of Hold
        One per interval; where no intervals are authored, those found. None where contacts are off.

    Raises
    ------
    InputError
        Where a contact is not right, names a joint that is not there, or a time outside the animation; where contacts
        are declared and there are none.
    StageError
        Where a prim above the Skeleton moves.
    """
    if contacts == "off":
        return ()
    declared = read_contacts(prim)
    if contacts == "declared" and not declared:
        raise InputError(f"{prim.GetPath()} declares no contacts", expected="MtexContactAPI:<name> applied")
    check_standing(skeleton_prim, clip)
    return tuple(hold for contact in declared for hold in _read_hold(prim, skeleton_prim, clip, contact))


def check_standing(skeleton_prim: Usd.Prim, clip: Clip) -> None:
    """Refuse a Skeleton that is carried along by a prim above it: what is still in its space moves in the world.

    Raises
    ------
    StageError
        Naming the prim that moves.
    """
    prim = skeleton_prim
    while prim and not prim.IsPseudoRoot():
        xformable = UsdGeom.Xformable(prim)
        if xformable and len(set(_poses(xformable, clip.time_codes))) > 1:
            raise StageError(
                f"{prim.GetPath()} moves, and with it the floor in the space of {skeleton_prim.GetPath()}",
                expected="transforms above the Skeleton that do not change where contacts are to be held",
                fix="Put the motion on the root joint.",
            )
        prim = prim.GetParent()


def _poses(xformable: UsdGeom.Xformable, time_codes: FloatArray) -> list[tuple[float, ...]]:
    if not xformable.TransformMightBeTimeVarying():
        return []
    matrices = [xformable.GetLocalTransformation(float(time_code)) for time_code in time_codes]
    return [tuple(np.array(matrix).ravel().tolist()) for matrix in matrices]


def _read_hold(prim: Usd.Prim, skeleton_prim: Usd.Prim, clip: Clip, contact: ContactSettings) -> list[Hold]:
    source = f"{prim.GetPath()}: contact {contact.name}"
    effector = Effector(
        name=contact.name, joint=_find_joint(contact.joint, clip, source), offset=np.array(contact.offset)
    )
    if not contact.intervals:
        found = detect_contacts(clip, effectors=[effector])
        if not found:
            raise InputError(f"{source}: the point is never low and slow", fix="Author its intervals.")
        return [_hold_found(number, each, clip, contact) for number, each in enumerate(found, start=1)]
    frames = [_find_frame(time, clip, source) for time in contact.intervals]
    pairs = zip(frames[::2], frames[1::2], strict=True)
    return [
        _hold_interval(number, first, last, effector, skeleton_prim, clip, contact)
        for number, (first, last) in enumerate(pairs, start=1)
    ]


def _find_joint(name: str, clip: Clip, source: str) -> int:
    names = [joint.rpartition("/")[2] for joint in clip.joints]
    found = [i for i, joint in enumerate(clip.joints) if name in (joint, names[i])]
    if len(found) != 1:
        there = ", ".join(clip.joints[i] for i in found) if found else ", ".join(names)
        raise InputError(f"{source}: no single joint {name!r}", expected="one joint", found=there)
    return found[0]


def _find_frame(time: float, clip: Clip, source: str) -> int:
    frame = (time - clip.start) / clip.time_codes_per_frame
    if not -0.5 <= frame <= clip.frame_count - 0.5:
        first, last = clip.time_codes[[0, -1]]
        raise InputError(
            f"{source}: a time outside", expected=f"time codes from {first:g} to {last:g}", found=f"{time:g}"
        )
    return round(frame)


def _hold_found(number: int, found: Contact, clip: Clip, contact: ContactSettings) -> Hold:
    """A contact that was found by height and speed."""
    return Hold(
        name=f"{contact.name} {number}",
        joint=found.effector.joint,
        offset=found.effector.offset,
        first=found.first,
        last=found.last,
        still=contact.mode == "plant",
        height=float(found.point @ clip.skeleton.up),
        tolerance=contact.tolerance,
    )


def _hold_interval(
    number: int,
    first: int,
    last: int,
    effector: Effector,
    skeleton_prim: Usd.Prim,
    clip: Clip,
    contact: ContactSettings,
) -> Hold:
    """A contact with its interval given."""
    slides = contact.mode == "slide"
    space = _find_space(clip.time_codes[first : last + 1], skeleton_prim, contact)
    places = None if contact.mode == "follow" and contact.point is None else _find_places(space, contact)
    return Hold(
        name=f"{contact.name} {number}",
        joint=effector.joint,
        offset=effector.offset,
        first=first,
        last=last,
        still=contact.mode == "plant" and places is None,
        height=float(places[0] @ clip.skeleton.up) if slides and places is not None else None,
        keeps_height=slides and places is None,
        places=None if slides else places,
        carried=space if contact.mode == "follow" and places is None else None,
        tolerance=contact.tolerance,
    )


def _find_space(time_codes: FloatArray, skeleton_prim: Usd.Prim, contact: ContactSettings) -> FloatArray:
    """From the target's space, or the world's, into skeleton space at every frame, row vectors, [N, 4, 4]."""
    from_world = np.linalg.inv(_matrix(skeleton_prim, float(time_codes[0])))
    if contact.target is None:
        return np.tile(from_world, (len(time_codes), 1, 1))
    target = skeleton_prim.GetStage().GetPrimAtPath(contact.target)
    return np.array([_matrix(target, float(time)) @ from_world for time in time_codes])


def _find_places(space: FloatArray, contact: ContactSettings) -> FloatArray | None:
    """Where the point is to be at every frame, skeleton space, [N, 3]; None where only the motion itself tells."""
    if contact.target is None and contact.point is None:
        return None
    local = np.array([*(contact.point or (0.0, 0.0, 0.0)), 1.0])
    return np.asarray((local @ space)[:, :3])


def _matrix(prim: Usd.Prim, time_code: float) -> FloatArray:
    """Local to world, row vectors, [4, 4]."""
    return np.array(UsdGeom.XformCache(time_code).GetLocalToWorldTransform(prim))


def declared_frequency(prim: Usd.Prim) -> float:
    """Give the highest frequency of the change that any contact on an animation allows, Hz."""
    return max((contact.frequency for contact in read_contacts(prim)), default=_FREQUENCY)
