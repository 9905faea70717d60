"""Edits declared on animations, with the motions they name, ready to run."""

from collections.abc import Sequence

import numpy as np
from pxr import Sdf, Usd

from mtex_usd import edit
from mtex_usd.constraints.contacts import detect_contacts
from mtex_usd.constraints.planting import plan_contacts
from mtex_usd.constraints.retargeting import Pair, map_joints, retarget_mapped
from mtex_usd.edit.stack.edit import ContactFinder, Edit
from mtex_usd.edit.stack.operations import check_edit
from mtex_usd.edit.stack.others import complete_joints, put_on_joints
from mtex_usd.errors import InputError
from mtex_usd.motion.anatomy import find_anatomy
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.correspondence import corresponding_joints
from mtex_usd.motion.skeleton import Skeleton
from mtex_usd.motion.timing import resample_clip
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.schema import ContactSettings, read_contacts, read_edit, read_pairs, read_stacks

__all__ = ["EditReader", "make_contact_finder"]

_SAME_REST = 1e-4  # of the longest bone


class EditReader:
    """Reads the edits of one stage.

    Parameters
    ----------
    stage
        The composed stage, which must not change meanwhile.
    reader
        Of the same stage.
    """

    def __init__(self, stage: Usd.Stage, reader: ClipReader) -> None:
        self._stage = stage
        self._reader = reader
        self._open: list[Sdf.Path] = []

    def read(self, prim: Usd.Prim, names: Sequence[str], *, like: Clip) -> tuple[Edit, ...]:
        """Read edits, with the motions they name.

        Parameters
        ----------
        prim
            The SkelAnimation they are declared on.
        names
            Which, in order.
        like
            The motion they are made of: others are brought onto its joints and to its rate.

        Raises
        ------
        InputError, StageError
            Whatever is wrong with an edit or with a motion it names, naming the prim.
        """
        return tuple(self._read_edit(prim, name, like) for name in names)

    def read_take(self, prim: Usd.Prim, *, skeleton: Skeleton | None = None) -> Clip:
        """Read a take on its own skeleton, with the edits made that it declares to be made before matching.

        Parameters
        ----------
        prim
            A SkelAnimation.
        skeleton
            Of the character, for a take that has none.

        Raises
        ------
        InputError, StageError
            As :meth:`read`, and as :meth:`mtex_usd.usd.clip_io.ClipReader.read_take`; where edits of takes name each
            other in a circle.
        """
        clip = self._reader.read_take(prim, skeleton=skeleton)
        names = read_stacks(prim).before
        if not names:
            return clip
        if prim.GetPath() in self._open:
            circle = " -> ".join(map(str, [*self._open, prim.GetPath()]))
            raise InputError(f"{prim.GetPath()}: its edits need themselves", found=circle)
        self._open.append(prim.GetPath())
        edits = self.read(prim, names, like=clip)
        self._open.pop()
        return edit.run_stack(clip, edits, find_contacts=make_contact_finder(prim)).clip

    def _read_edit(self, prim: Usd.Prim, name: str, like: Clip) -> Edit:
        said = read_edit(prim, name)
        # A motion that goes over into itself is closed to a loop, as it is when the edit's turn comes.
        others = [path for path in said.others if not (said.op == "join" and path == prim.GetPath())]
        clips = tuple(self._read_other(prim, path, like) for path in others)
        declared = Edit(name=name, op=said.op, settings=said.settings, others=clips)
        try:
            check_edit(declared)
        except InputError as error:
            raise _at(prim, error) from error
        return declared

    def _read_other(self, prim: Usd.Prim, path: Sdf.Path, like: Clip) -> Clip:
        other_prim = self._stage.GetPrimAtPath(path)
        other = resample_clip(self.read_take(other_prim, skeleton=like.skeleton), like.rate)
        try:
            return _put_on(other, like, read_pairs(other_prim) or read_pairs(prim))
        except InputError as error:
            raise _at(other_prim, error) from error


def _put_on(other: Clip, like: Clip, pairs: Sequence[Pair]) -> Clip:
    """Give a motion on all joints of another: by their names where the skeletons are the same, else retargeted."""
    if not pairs and (_rests_alike(other, like) or not all(map(find_anatomy, (other.skeleton, like.skeleton)))):
        return put_on_joints(other, like)
    joint_map = map_joints(other.skeleton, like.skeleton, tuple(pairs))
    whole = retarget_mapped(other, joint_map, like=like)
    return complete_joints(whole, like, [share.joint for share in joint_map.shares])


def _rests_alike(other: Clip, like: Clip) -> bool:
    named = corresponding_joints(other.joints, like.joints)
    here, there = list(named.keys()), list(named.values())
    size = max(1.0, float(np.abs(like.rest).max()))
    return bool(named) and bool(np.allclose(like.rest[here], other.rest[there], rtol=0.0, atol=_SAME_REST * size))


def _at(prim: Usd.Prim, error: InputError) -> InputError:
    message = f"{prim.GetPath()}: {error.message}"
    return InputError(message, expected=error.expected, found=error.found, fix=error.fix)


def make_contact_finder(prim: Usd.Prim) -> ContactFinder:
    """Make what tells where the contacts of an animation begin and end.

    Parameters
    ----------
    prim
        The SkelAnimation; its MtexContactAPI says what is declared.
    """
    declared = read_contacts(prim)

    def find_frames(clip: Clip, contacts: str) -> tuple[int, ...]:
        """Give the frames of a clip at which contacts begin and end."""
        frames = {frame for contact in declared for frame in _declared_frames(contact, clip)}
        unknown = {contact.joint for contact in declared if not contact.intervals}
        if contacts == "detect" or unknown:
            frames |= _detected_frames(clip, None if contacts == "detect" else unknown)
        return tuple(sorted(frames))

    return find_frames


def _declared_frames(contact: ContactSettings, clip: Clip) -> list[int]:
    """Frames of the clip at a contact's borders; edits of time may have moved them out of it."""
    frames = [round((time - clip.start) / clip.time_codes_per_frame) for time in contact.intervals]
    return [frame for frame in frames if 0 <= frame < clip.frame_count]


def _detected_frames(clip: Clip, joints: set[str] | None) -> set[int]:
    """Borders of the contacts that are found, of some joints or of all."""
    holds = plan_contacts(detect_contacts(clip), clip)
    names = [(clip.joints[hold.joint], clip.joints[hold.joint].rpartition("/")[2]) for hold in holds]
    wanted = [hold for hold, both in zip(holds, names, strict=True) if joints is None or joints & set(both)]
    return {frame for hold in wanted for frame in (hold.first, hold.last)}
