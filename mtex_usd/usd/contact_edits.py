"""Contacts of what a stage shows, moved by hand: read, and put over it in the session layer."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdGeom, UsdSkel, Vt

from mtex_usd.constraints.contacts import detect_contacts
from mtex_usd.constraints.planting import Hold, JointRange, describe_holds, plan_contacts
from mtex_usd.errors import InputError, StageError
from mtex_usd.motion.clip import Clip
from mtex_usd.motion.skeleton import FloatArray
from mtex_usd.usd.animation import AnimationSamples, sample_sketch
from mtex_usd.usd.clip_io import ClipReader
from mtex_usd.usd.contacts import check_standing, declared_frequency, read_holds
from mtex_usd.usd.custom_data import from_metadata, to_metadata
from mtex_usd.usd.limits import read_limits
from mtex_usd.usd.sampled_clip import add_joints, fill_missing, to_clip
from mtex_usd.usd.schema import CONTACT_API, api_instances
from mtex_usd.usd.session import find_skeletons, session_offset
from mtex_usd.usd.variants import PathSet, find_sets, selected_path

__all__ = ["ContactMotion", "author_motion", "keep_specs", "put_back", "read_motions"]

_ToUsd = Callable[[npt.NDArray[np.floating]], object]

_KEY = "mtex"
_ORIGINAL = "original"
_REAL_LAST = [1, 2, 3, 0]  # USD keeps i, j, k, real in memory


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactMotion:
    """What a character plays at the moment, with what is held in it.

    Parameters
    ----------
    label
        What users read.
    spec_path
        Where the session layer overrides it: in the variant that is selected, where there is one.
    samples
        As USD gives it, missing attributes filled from rest.
    clip
        The motion on all joints.
    holds
        What is held: as its variant records it, else as declared, else as found on it.
    frequency
        The highest frequency of changes, Hz.
    limits
        How far joints may turn.
    to_world
        From skeleton space to the world, row vectors, shape [4, 4].
    """

    label: str
    spec_path: Sdf.Path
    samples: AnimationSamples
    clip: Clip
    holds: tuple[Hold, ...]
    frequency: float
    limits: tuple[JointRange, ...]
    to_world: FloatArray


def read_motions(stage: Usd.Stage, prims: Sequence[Usd.Prim]) -> tuple[ContactMotion, ...]:
    """Read what the characters that a user picked play at the moment.

    Parameters
    ----------
    stage
        The composed stage.
    prims
        What was picked: meshes, Skeletons, models, or animations that Skeletons play.

    Returns
    -------
    tuple of ContactMotion
        One per animation that is played.

    Raises
    ------
    StageError
        Where nothing that was picked plays an animation, the original of a set is shown, or the animation lies inside
        an instance.
    InputError
        Where no contact is found.
    """
    players: dict[Sdf.Path, Usd.Prim] = {}
    for skeleton in find_skeletons(stage, prims):
        source = UsdSkel.BindingAPI(skeleton).GetInheritedAnimationSource()
        if source:
            players.setdefault(source.GetPath(), skeleton)
    if not players:
        raise StageError(
            "nothing selected plays an animation",
            expected="a mesh, a Skeleton, an animation or a model with one",
            found=", ".join(str(prim.GetPath()) for prim in prims) or "an empty selection",
        )
    sets = {found.output: found for found in find_sets(stage)}
    return tuple(_read_motion(stage, path, skeleton, sets.get(path)) for path, skeleton in players.items())


def _read_motion(stage: Usd.Stage, path: Sdf.Path, skeleton_prim: Usd.Prim, path_set: PathSet | None) -> ContactMotion:
    prim = stage.GetPrimAtPath(path)
    spec_path = _find_spec_path(stage, prim, path_set)
    skeleton = ClipReader(stage).read_skeleton(skeleton_prim)
    samples = fill_missing(sample_sketch(stage, prim), skeleton)
    if len(samples.time_codes) < 2:
        raise StageError(f"{path} is a single pose", expected="an animation of at least two frames")
    clip = to_clip(samples, skeleton)
    check_standing(skeleton_prim, clip)
    source = stage.GetPrimAtPath(path_set.source) if path_set and path_set.source else prim
    return ContactMotion(
        label=f"{path_set.label}, {selected_path(stage, path_set)}" if path_set else str(path),
        spec_path=spec_path,
        samples=samples,
        clip=clip,
        holds=_find_holds(prim, source, skeleton_prim, clip),
        frequency=declared_frequency(source),
        limits=read_limits(skeleton_prim, skeleton),
        to_world=np.array(UsdGeom.XformCache(clip.start).GetLocalToWorldTransform(skeleton_prim)),
    )


def _find_spec_path(stage: Usd.Stage, prim: Usd.Prim, path_set: PathSet | None) -> Sdf.Path:
    if path_set is not None:
        variant = selected_path(stage, path_set)
        if variant == _ORIGINAL:
            raise StageError(f"{path_set.label} shows the original, which stays as it is", fix="Select a path first.")
        in_variant = path_set.model.AppendVariantSelection(path_set.name, variant)
        return in_variant.AppendChild(path_set.output.name)
    if prim.IsInstanceProxy():
        raise StageError(
            f"{prim.GetPath()} lies inside an instance, where nothing can be edited",
            fix="Process the animation first, or set instanceable to false.",
        )
    return prim.GetPath()


def _find_holds(prim: Usd.Prim, source: Usd.Prim, skeleton_prim: Usd.Prim, clip: Clip) -> tuple[Hold, ...]:
    recorded = from_metadata((prim.GetCustomDataByKey(_KEY) or {}).get("contacts", {}))
    if isinstance(recorded, list) and recorded:
        return tuple(_to_hold(each, clip) for each in recorded)
    if api_instances(source, CONTACT_API):
        return read_holds(source, skeleton_prim, clip, "declared")
    found = plan_contacts(detect_contacts(clip), clip)
    if not found:
        raise InputError(
            f"{prim.GetPath()}: no contact was found",
            expected="feet that stand on the floor for a moment, or contacts that are declared",
            fix=f"Apply {CONTACT_API} to the animation.",
        )
    return found


def _to_hold(said: Mapping[str, object], clip: Clip) -> Hold:
    first, last = (round((float(str(said[key])) - clip.start) / clip.time_codes_per_frame) for key in ("start", "end"))
    return Hold(
        name=str(said["name"]),
        joint=clip.joints.index(str(said["joint"])),
        offset=np.array(said["offset"], dtype=float),
        first=max(first, 0),
        last=min(last, clip.frame_count - 1),
        still=True,
    )


def author_motion(stage: Usd.Stage, motion: ContactMotion, clip: Clip, holds: Sequence[Hold]) -> None:
    """Put a changed motion over what a stage shows, in the session layer.

    Parameters
    ----------
    stage
        Only its session layer changes.
    motion
        What was read.
    clip
        What was made of its clip; joints that did not change keep the samples' bits.
    holds
        What is held in it, recorded in ``customData["mtex"]``.
    """
    changed = np.flatnonzero(
        (clip.rotations != motion.clip.rotations).any(axis=(0, 2))
        | (clip.translations != motion.clip.translations).any(axis=(0, 2))
    ).tolist()
    added = tuple(clip.joints[joint] for joint in changed if clip.joints[joint] not in motion.samples.joints)
    samples = add_joints(motion.samples, added, clip.skeleton)
    columns = [samples.joints.index(clip.joints[joint]) for joint in changed]
    rotations, translations = np.array(samples.rotations), np.array(samples.translations)
    rotations[:, columns], translations[:, columns] = clip.rotations[:, changed], clip.translations[:, changed]
    offset = session_offset(stage).GetInverse()
    times = [offset * time for time in samples.time_codes.tolist()]
    arrays: dict[str, tuple[Sdf.ValueTypeName, _ToUsd, npt.NDArray[np.floating]]] = {
        "rotations": (Sdf.ValueTypeNames.QuatfArray, Vt.QuatfArray.FromNumpy, rotations[..., _REAL_LAST]),
        "translations": (Sdf.ValueTypeNames.Float3Array, Vt.Vec3fArray.FromNumpy, translations),
        "scales": (Sdf.ValueTypeNames.Half3Array, Vt.Vec3hArray.FromNumpy, samples.scales.astype(np.float16)),
    }
    with Sdf.ChangeBlock():
        prim = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), motion.spec_path)
        said = dict(prim.customData.get(_KEY, {}))
        contacts = to_metadata(describe_holds(holds, clip))
        prim.SetInfo("customData", {**prim.customData, _KEY: {**said, "contacts": contacts}})
        joints = _find_attribute(prim, "joints", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
        joints.default = Vt.TokenArray(samples.joints)
        for name, (type_name, to_usd, values) in arrays.items():
            attribute = _find_attribute(prim, name, type_name, Sdf.VariabilityVarying)
            attribute.ClearInfo("timeSamples")
            for time, frame in zip(times, np.ascontiguousarray(values), strict=True):
                attribute.layer.SetTimeSample(attribute.path, time, to_usd(frame))


def _find_attribute(
    prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, variability: Sdf.Variability
) -> Sdf.AttributeSpec:
    return prim.attributes.get(name) or Sdf.AttributeSpec(prim, name, type_name, variability)


def keep_specs(stage: Usd.Stage) -> Sdf.Layer:
    """Give a copy of the session layer, for :func:`put_back`.

    Parameters
    ----------
    stage
        The stage.
    """
    copy = Sdf.Layer.CreateAnonymous("before.usda")
    copy.TransferContent(stage.GetSessionLayer())
    return copy


def put_back(stage: Usd.Stage, motion: ContactMotion, before: Sdf.Layer) -> None:
    """Take back what :func:`author_motion` authored, and nothing that others authored meanwhile.

    Parameters
    ----------
    stage, motion
        As given to that function.
    before
        What :func:`keep_specs` gave before.
    """
    session, path = stage.GetSessionLayer(), motion.spec_path
    if not session.GetPrimAtPath(path):
        return
    if before.GetPrimAtPath(path):
        Sdf.CopySpec(before, path, session, path)
        return
    with Sdf.ChangeBlock():
        parent = path.GetParentPath()
        del session.GetPrimAtPath(parent).nameChildren[path.name]  # type: ignore[attr-defined]
        if parent.IsPrimVariantSelectionPath():
            _drop_variant(session, parent, before)
            parent = parent.GetParentPath()
    _drop_inert(session, parent, before)


def _drop_inert(session: Sdf.Layer, path: Sdf.Path, before: Sdf.Layer) -> None:
    """Take overs out that say nothing and were not there before, from below upward."""
    if path.IsAbsoluteRootPath() or before.GetPrimAtPath(path) or not session.GetPrimAtPath(path).isInert:
        return
    above = path.GetParentPath()
    siblings = session.rootPrims if above.IsAbsoluteRootPath() else session.GetPrimAtPath(above).nameChildren
    del siblings[path.name]  # type: ignore[attr-defined]
    _drop_inert(session, above, before)


def _drop_variant(session: Sdf.Layer, path: Sdf.Path, before: Sdf.Layer) -> None:
    """Take a variant out that held nothing else, and its set with the last one."""
    name, variant = path.GetVariantSelection()
    model = session.GetPrimAtPath(path.GetParentPath())
    found = model.variantSets[name]
    if before.GetObjectAtPath(path) or found.variants[variant].primSpec.nameChildren:
        return
    found.RemoveVariant(found.variants[variant])
    if not found.variants:
        del model.variantSets[name]
        model.variantSetNameList.prependedItems.remove(name)
