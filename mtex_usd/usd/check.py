"""Reading the written result back as any USD application would, and naming what stands in its way.

The thin root is opened composed and every variant is evaluated through UsdSkel. Where the override layer also lies
inside the shot's own layer stack, as a pipeline may put it, the shot is evaluated too: there, stronger layers can block
it.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import NoReturn

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdSkel

from mtex_usd.errors import ResultError, StageError
from mtex_usd.usd.diagnostics import open_layer
from mtex_usd.usd.override import ORIGINAL, CharacterResult, VariantSamples
from mtex_usd.usd.thin_root import find_stacked

__all__ = ["check_override"]

_CHECKED_FRAMES = 5  # first, last and three between; the list of all sample times is compared whole
_REAL_FIRST = [3, 0, 1, 2]  # USD keeps i, j, k, real in memory
_BINDING = "skel:animationSource"
_VALUES = ("joints", "translations", "rotations", "scales")

# Translations, rotations (real first) and scales at one time; empty where UsdSkel gives none.
Pose = tuple[npt.NDArray[np.floating], ...]


@dataclass(frozen=True)
class _Reader:
    """A composed stage that should show the override layer's variants."""

    stage: Usd.Stage
    override: Sdf.Layer

    def query(self, cache: UsdSkel.Cache, skeleton: Sdf.Path) -> UsdSkel.AnimQuery:
        """What a Skeleton plays; falsy for nothing."""
        return cache.GetSkelQuery(UsdSkel.Skeleton(self.stage.GetPrimAtPath(skeleton))).GetAnimQuery()

    def plays(self, query: UsdSkel.AnimQuery, animation: Sdf.Path) -> bool:
        """Tell whether a query reads an animation, which UsdSkel names by its prototype inside an instance."""
        prim = self.stage.GetPrimAtPath(animation)
        return bool(query and prim) and query.GetPrim() in (prim, prim.GetPrimInPrototype())

    def fail(self, what: str, prim_path: Sdf.Path, names: Iterable[str]) -> NoReturn:
        """Raise, naming the opinion on one of the properties that is stronger than the override layer's, if any."""
        for spec in self._stronger(prim_path, names):
            raise StageError(
                f"{what} is blocked by a stronger opinion in {spec.layer.identifier} at {spec.path}",
                expected=f"the opinion of {self.override.identifier}",
                fix="Remove that opinion, or stack the override layer over that layer.",
            )
        raise ResultError(
            f"{what} differs from what was computed, read through {self.stage.GetRootLayer().identifier}",
            fix="If the override layer lies in an offset sublayer, move it into one without.",
        )

    def _stronger(self, prim_path: Sdf.Path, names: Iterable[str]) -> Iterator[Sdf.PropertySpec]:
        prim = self.stage.GetPrimAtPath(prim_path)
        specs = takewhile(lambda spec: spec.layer != self.override, prim.GetPrimStack() if prim else ())
        found = (spec.properties.get(name) for spec in specs for name in names)
        return (spec for spec in found if spec)


def check_override(root_path: Path, results: Sequence[CharacterResult]) -> None:
    """Evaluate every variant of a written result and compare it with what was computed.

    Parameters
    ----------
    root_path
        The thin root that :func:`mtex_usd.usd.override.write_override` wrote.
    results
        What it was given.

    Raises
    ------
    StageError
        Where a stronger opinion blocks the result; names the layer and the spec.
    ResultError
        Where a variant differs from what was computed without one.
    """
    stage = Usd.Stage.Open(str(root_path))
    stacked = find_stacked(stage.GetRootLayer())
    if stacked.override is None:
        raise ResultError(f"{root_path} stacks no override layer")
    override = open_layer(stacked.override)
    _check_stage(_Reader(stage, override), results)
    if stage.GetLayerStack().count(override) > 1:
        _check_stage(_Reader(Usd.Stage.Open(str(stacked.shot)), override), results)


def _check_stage(reader: _Reader, results: Sequence[CharacterResult]) -> None:
    _select(reader.stage, results, [ORIGINAL] * len(results))
    cache = UsdSkel.Cache()
    for result in results:
        _check_original(reader, cache, result)
    for i in range(max(len(result.variants) for result in results)):
        names = [result.names[min(i, len(result.names) - 1)] for result in results]
        _select(reader.stage, results, names)
        cache = UsdSkel.Cache()
        for name, result in zip(names, results, strict=True):
            if i < len(result.variants):
                _check_variant(reader, cache, result, name, result.variants[i])


def _select(stage: Usd.Stage, results: Sequence[CharacterResult], names: Sequence[str]) -> None:
    """Select one variant of every set in the session layer, which beats all others, in one recomposition."""
    with Sdf.ChangeBlock():
        for result, name in zip(results, names, strict=True):
            prim = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), result.character.model)
            prim.variantSelections[result.character.variant_set] = name


def _check_variant(
    reader: _Reader, cache: UsdSkel.Cache, result: CharacterResult, name: str, samples: VariantSamples
) -> None:
    character = result.character
    what = f"variant {name} of {character.animation}"
    for skeleton in character.skeletons:
        query = reader.query(cache, skeleton)
        if not reader.plays(query, character.output):
            reader.fail(f"{what} on {skeleton}", skeleton, [_BINDING])
    if not _equals_samples(query, samples):
        reader.fail(what, character.output, _VALUES)


def _equals_samples(query: UsdSkel.AnimQuery, samples: VariantSamples) -> bool:
    if tuple(query.GetJointOrder()) != samples.joints or not _has_times(query, samples.time_codes):
        return False
    return all(
        _equal(
            _pose(query, float(samples.time_codes[i])),
            (samples.translations[i], samples.rotations[i], samples.scales[i].astype(np.float16)),
        )
        for i in _frames(len(samples.time_codes))
    )


def _has_times(query: UsdSkel.AnimQuery, time_codes: npt.NDArray[np.float64]) -> bool:
    # What never changes is one default and has no times.
    times = query.GetJointTransformTimeSamples()
    return not times or np.array_equal(times, time_codes)


def _frames(count: int) -> list[int]:
    return sorted({round(i) for i in np.linspace(0, count - 1, _CHECKED_FRAMES)})


def _check_original(reader: _Reader, cache: UsdSkel.Cache, result: CharacterResult) -> None:
    character = result.character
    query = reader.query(cache, character.skeletons[0])
    if not query and reader.stage.GetPrimAtPath(character.model).IsInstance():
        return  # nobody was bound, and a local binding does not reach into an instance
    what = f"variant {ORIGINAL} of {character.animation}"
    time_codes = result.variants[0].time_codes
    if not query:
        reader.fail(what, character.skeletons[0], [_BINDING])
    source = cache.GetAnimQuery(UsdSkel.Animation(reader.stage.GetPrimAtPath(character.animation)))
    same_joints = tuple(query.GetJointOrder()) == tuple(source.GetJointOrder())
    for time_code in (float(time_codes[i]) for i in _frames(len(time_codes))):
        if not (same_joints and _equal(_pose(query, time_code), _pose(source, time_code))):
            reader.fail(what, character.output, _VALUES)


def _pose(query: UsdSkel.AnimQuery, time_code: float) -> Pose:
    translations, rotations, scales = map(np.asarray, query.ComputeJointLocalTransformComponents(time_code))
    return translations, rotations[:, _REAL_FIRST] if rotations.size else rotations, scales


def _equal(one: Pose, other: Pose) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
