"""Skeleton prims as plain skeletons, and which Skeleton an animation belongs to."""

from collections.abc import Mapping, Sequence

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from mtex_usd.errors import InputError, StageError
from mtex_usd.motion.skeleton import FloatArray, Skeleton, parents_of
from mtex_usd.usd.animation import AnimationSamples
from mtex_usd.usd.schema import TakeSettings

__all__ = ["find_bindings", "find_take_skeleton", "make_bare_skeleton", "read_skeleton"]

_SINGULAR = 1e-12


def read_skeleton(prim: Usd.Prim) -> Skeleton:
    """Read a Skeleton prim.

    Parameters
    ----------
    prim
        A Skeleton. Where ``restTransforms`` are missing, not one per joint, not finite or not invertible, the rest is
        derived from ``bindTransforms``, as importers do.

    Returns
    -------
    Skeleton
        ``up`` is the stage's up axis and ``meters_per_unit`` the stage's, both brought into the skeleton's space by the
        prim's local-to-world transform at default time.

    Raises
    ------
    StageError
        Where the prim is no Skeleton, has no joints, or neither kind of transforms is usable, or a transform above it
        cannot be inverted.
    InputError
        Where the joints are not unique, or a child comes before its parent.
    """
    if not prim.IsA("Skeleton"):
        raise StageError(f"{prim.GetPath()} is no Skeleton", found=prim.GetTypeName() or "a typeless prim")
    skeleton = UsdSkel.Skeleton(prim)
    joints = tuple(map(str, skeleton.GetJointsAttr().Get() or ()))
    if not joints:
        raise StageError(f"{prim.GetPath()} has no joints", expected="the joints attribute in the Skeleton")
    up, scale = _space(prim)
    unit = UsdGeom.GetStageMetersPerUnit(prim.GetStage()) * scale
    rest = _read_rest(skeleton, joints)
    try:
        return Skeleton(joints=joints, rest=rest, up=up, meters_per_unit=unit)
    except InputError as error:
        raise InputError(f"{prim.GetPath()}: {error.message}", expected=error.expected, found=error.found) from error


def _read_rest(skeleton: UsdSkel.Skeleton, joints: tuple[str, ...]) -> FloatArray:
    rest = _usable(skeleton.GetRestTransformsAttr(), len(joints))
    if rest is not None:
        return rest
    bind = _usable(skeleton.GetBindTransformsAttr(), len(joints))
    if bind is None:
        raise StageError(
            f"{skeleton.GetPath()} has no usable rest pose",
            expected=f"{len(joints)} invertible restTransforms or bindTransforms, one per joint",
        )
    parents = parents_of(joints)
    above = np.where((parents >= 0)[:, None, None], bind[parents], np.eye(4))
    local: FloatArray = bind @ np.linalg.inv(above)
    return local


def _usable(attribute: Usd.Attribute, count: int) -> FloatArray | None:
    value = attribute.Get()
    if value is None or len(value) != count:
        return None
    matrices = np.array(value, dtype=np.float64)
    if not np.isfinite(matrices).all() or (np.abs(np.linalg.det(matrices[:, :3, :3])) < _SINGULAR).any():
        return None
    return matrices


def _space(prim: Usd.Prim) -> tuple[FloatArray, float]:
    """Give the stage's up axis in the prim's space, and how long one unit of the prim is in units of the stage."""
    to_world = np.array(UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))[:3, :3]
    volume = abs(float(np.linalg.det(to_world)))
    if volume < _SINGULAR:
        raise StageError(f"{prim.GetPath()}: a transform above the Skeleton cannot be inverted", fix="Give it a size.")
    axis = "XYZ".index(UsdGeom.GetStageUpAxis(prim.GetStage()))
    up: FloatArray = np.eye(3)[axis] @ np.linalg.inv(to_world)
    return up / np.linalg.norm(up), volume ** (1.0 / 3.0)


def make_bare_skeleton(samples: AnimationSamples, stage: Usd.Stage) -> Skeleton:
    """Make a skeleton for an animation that has none.

    Parameters
    ----------
    samples
        Gives the joints, and the translations of the first frame; none where translations are missing.
    stage
        Gives up axis and unit.

    Returns
    -------
    Skeleton
        Joints sorted so that parents come first, at rest without rotation.
    """
    order = sorted(range(len(samples.joints)), key=lambda i: samples.joints[i].count("/"))
    rest = np.tile(np.eye(4), (len(order), 1, 1))
    if "translations" not in samples.missing:
        rest[:, 3, :3] = samples.translations[0, order]
    return Skeleton(
        joints=tuple(samples.joints[i] for i in order),
        rest=rest,
        up=np.eye(3)["XYZ".index(UsdGeom.GetStageUpAxis(stage))],
        meters_per_unit=UsdGeom.GetStageMetersPerUnit(stage),
    )


def find_bindings(stage: Usd.Stage) -> dict[Sdf.Path, tuple[Usd.Prim, ...]]:
    """Find which Skeletons every animation drives, bindings inherited from above and instances included.

    Parameters
    ----------
    stage
        The composed stage.

    Returns
    -------
    dict
        Skeleton prims, in the stage's order, by the path of the animation.
    """
    bindings: dict[Sdf.Path, tuple[Usd.Prim, ...]] = {}
    for skeleton in _skeletons_below(stage.GetPseudoRoot()):
        source = UsdSkel.BindingAPI(skeleton).GetInheritedAnimationSource()
        if source:
            bindings[source.GetPath()] = (*bindings.get(source.GetPath(), ()), skeleton)
    return bindings


def find_take_skeleton(
    prim: Usd.Prim, settings: TakeSettings, *, bindings: Mapping[Sdf.Path, Sequence[Usd.Prim]] | None = None
) -> Usd.Prim | None:
    """Find the Skeleton an animation was made on.

    Parameters
    ----------
    prim
        A SkelAnimation, take or sketch.
    settings
        May name the Skeleton.
    bindings
        What :func:`find_bindings` found, to spare walking the stage once per take.

    Returns
    -------
    Usd.Prim or None
        The one that is named; else the first that is driven by the animation; else the only Skeleton with all its
        joints beneath the same SkelRoot, or beneath the same parent where there is no SkelRoot; else None.

    Raises
    ------
    StageError
        Where the named prim is no Skeleton.
    """
    stage = prim.GetStage()
    if settings.skeleton is not None:
        named = stage.GetPrimAtPath(settings.skeleton)
        if not named or not named.IsA("Skeleton"):
            raise StageError(f"{prim.GetPath()}: mtex:take:skeleton names no Skeleton", found=str(settings.skeleton))
        return named
    bound = (find_bindings(stage) if bindings is None else bindings).get(prim.GetPath(), ())
    return bound[0] if bound else _only_neighbour(prim)


def _only_neighbour(prim: Usd.Prim) -> Usd.Prim | None:
    joints = set(prim.GetAttribute("joints").Get() or ())
    root = UsdSkel.Root.Find(prim)
    near = _skeletons_below(root.GetPrim() if root else prim.GetParent())
    fitting = [skeleton for skeleton in near if joints <= set(skeleton.GetAttribute("joints").Get() or ())]
    return fitting[0] if len(fitting) == 1 else None


def _skeletons_below(prim: Usd.Prim) -> list[Usd.Prim]:
    prims = Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    return [below for below in prims if below.IsA("Skeleton")]
