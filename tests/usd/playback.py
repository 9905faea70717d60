"""What a USD application plays: joint transforms through UsdSkel, with nothing from the package under test."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdSkel, UsdUtils

FloatArray = npt.NDArray[np.float64]


@contextmanager
def no_diagnostics() -> Iterator[None]:
    """Fail on any warning, status or error that USD reports inside."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    yield
    messages = [item.commentary for item in delegate.TakeUncoalescedDiagnostics()]
    assert not messages, f"USD reported: {messages}"


def skeleton_query(stage: Usd.Stage, skeleton: str) -> UsdSkel.SkeletonQuery:
    """Ask UsdSkel about a Skeleton, from scratch."""
    return UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(skeleton)))


def local_transforms(stage: Usd.Stage, skeleton: str, time_code: float) -> dict[str, FloatArray]:
    """Give each joint's transform relative to its parent, as UsdSkel poses the Skeleton."""
    query = skeleton_query(stage, skeleton)
    matrices = query.ComputeJointLocalTransforms(time_code)
    return dict(zip(query.GetJointOrder(), map(np.array, matrices), strict=True))


def rest_transforms(stage: Usd.Stage, skeleton: str) -> dict[str, FloatArray]:
    """Give each joint's rest transform."""
    prim = UsdSkel.Skeleton(stage.GetPrimAtPath(skeleton))
    return dict(zip(prim.GetJointsAttr().Get(), map(np.array, prim.GetRestTransformsAttr().Get()), strict=True))


def animation_arrays(
    stage: Usd.Stage, animation: str, time_codes: Sequence[float]
) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Give joints, rotations [F, J, 4] (real first) and translations [F, J, 3] of a SkelAnimation."""
    query = UsdSkel.Cache().GetAnimQuery(UsdSkel.Animation(stage.GetPrimAtPath(animation)))
    poses = [query.ComputeJointLocalTransformComponents(time_code) for time_code in time_codes]
    rotations = np.array([np.array(pose[1])[:, [3, 0, 1, 2]] for pose in poses])
    return tuple(query.GetJointOrder()), rotations, np.array([np.array(pose[0]) for pose in poses])


def transform(rotation: FloatArray, translation: FloatArray, scale: FloatArray) -> FloatArray:
    """Compose one USD matrix (row vectors) of a quaternion (real first), a translation and a scale."""
    w, x, y, z = rotation / np.linalg.norm(rotation)
    columns = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(scale) @ columns.T
    matrix[3, :3] = translation
    return matrix


def stack_over(root_path: Path, layers: Sequence[Path], stage: Usd.Stage) -> Path:
    """Write a root layer that stacks layers, with the frame rate of a stage."""
    root = Sdf.Layer.CreateNew(str(root_path))
    root.subLayerPaths[:] = [str(layer) for layer in layers]
    root.timeCodesPerSecond = stage.GetTimeCodesPerSecond()
    root.Save()
    return root_path


def select_variant(stage: Usd.Stage, model: str, variant_set: str, variant: str) -> None:
    """Select a variant as usdview does, in the session layer."""
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        assert stage.GetPrimAtPath(model).GetVariantSet(variant_set).SetVariantSelection(variant)
