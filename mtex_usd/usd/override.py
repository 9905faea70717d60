"""The override layer: the finished versions of each sketch as variants, in overs and new prims only.

Why it looks as it does is measured, situation by situation (DECISIONS.md): variants are weaker than local opinions of
the same layer stack, so each variant defines an animation of its own, ``<Anim>_mtex``, and the binding to it is
authored twice: locally, for all that can be edited, and in the path variants, for what lies inside an instance.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, Vt

from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import check_target, file_maker, mark_layer, write_layer
from mtex_usd.usd.characters import Character
from mtex_usd.usd.control_curves import author_curves
from mtex_usd.usd.custom_data import to_metadata
from mtex_usd.usd.diagnostics import open_layer
from mtex_usd.usd.selection import Selections, read_selections
from mtex_usd.usd.thin_root import ROOT_METADATA, author_metadata, build_thin_root, read_root_metadata, thin_root_path

if TYPE_CHECKING:
    from mtex_usd.edit import KeyCurve

__all__ = ["ORIGINAL", "CharacterResult", "VariantSamples", "check_outputs", "variant_names", "write_override"]

ORIGINAL = "original"

_REAL_LAST = [1, 2, 3, 0]  # USD keeps i, j, k, real in memory

Float32Array = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False, kw_only=True)
class VariantSamples:
    """What one path variant says.

    Parameters
    ----------
    joints
        The sketch's joints in its order, then added ones; length J.
    time_codes
        Of the composed stage, ascending, shape [F].
    rotations
        Relative to the parent, real part first, float32, shape [F, J, 4].
    translations
        Relative to the parent, stage units, float32, shape [F, J, 3].
    scales
        Shape [F, J, 3]; stored as half.
    custom_data
        Goes to ``customData["mtex"]``: strings, numbers, lists of those, and lists of mappings.
    curves
        The motion as curves, to stand beside the samples as splines.
    """

    joints: tuple[str, ...]
    time_codes: npt.NDArray[np.float64]
    rotations: Float32Array
    translations: Float32Array
    scales: npt.NDArray[np.floating]
    custom_data: Mapping[str, object]
    curves: tuple["KeyCurve", ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class CharacterResult:
    """The versions of one animation on one character.

    Parameters
    ----------
    character
        Who plays it.
    names
        What the variants are called, ``original`` not among them.
    variants
        One per name; the first is selected unless the user chose another.
    """

    character: Character
    names: tuple[str, ...]
    variants: tuple[VariantSamples, ...]


def variant_names(count: int) -> tuple[str, ...]:
    """Name the path variants: ``path_01`` and on, padded so that they sort; ``original`` is not among them."""
    width = max(2, len(str(count)))
    return tuple(f"path_{i:0{width}d}" for i in range(1, count + 1))


def check_outputs(out: Path, *, maker: str) -> None:
    """Make sure that a command may write an override layer and its thin root here, before any work is done for it.

    Parameters
    ----------
    out
        Where the override layer is going to be written.
    maker
        The command.

    Raises
    ------
    InputError
        As :func:`mtex_usd.usd.atomic.check_target`, and where another command made the layer that is there.
    """
    check_target(out, "override")
    check_target(thin_root_path(out), "stage")
    found = file_maker(out)
    if found and found != maker:
        raise InputError(
            f"{out} holds what another command made",
            expected=f"a layer of {maker}, or no file",
            found=f"one of {found}",
            fix="Choose another name for the output.",
        )


def write_override(
    stage: Usd.Stage,
    results: Sequence[CharacterResult],
    out: Path,
    *,
    maker: str = "usdmtex",
    select: str | None = None,
    keep: Sequence[Character] = (),
) -> tuple[Path, Path]:
    """Write the override layer and the thin root that stacks it over the shot.

    Parameters
    ----------
    stage
        The shot, as :func:`mtex_usd.usd.source_stage.open_source` gives it.
    results
        At least one, each with at least one variant.
    out
        The override layer; ``X.usd`` gives the thin root ``X.stage.usda``. Files we wrote before are replaced.
    maker
        The command that makes it.
    select
        The variant to select in every set; by default the one the user had selected, where it still exists, else the
        best path. What was selected is read from the files at `out` and from our override layers muted on the stage.
    keep
        Characters whose sets are taken over unchanged from an earlier run's layer at `out`.

    Returns
    -------
    tuple[Path, Path]
        The override layer and the thin root.

    Raises
    ------
    InputError
        Where `select` names no variant, a file of that name is not ours or cannot be written, or the stage has no file.
    """
    check_outputs(out, maker=maker)
    selections = read_selections(stage, out, select)
    layer = _build_layer(stage, results, selections)
    mark_layer(layer, "override", maker=maker)
    _take_over(layer, keep, out, selections)
    time_codes = np.concatenate([variant.time_codes for result in results for variant in result.variants])
    if keep:
        time_codes = np.append(time_codes, layer.ListAllTimeSamples())
    metadata = read_root_metadata(stage, time_codes, results[0].character.model)
    root = build_thin_root(stage, metadata, out)
    _update_selections(root, layer, [*(result.character for result in results), *keep])
    author_metadata(layer, {key: metadata[key] for key in ROOT_METADATA})
    write_layer(layer, out)
    write_layer(root, thin_root_path(out))
    return out, thin_root_path(out)


def _build_layer(stage: Usd.Stage, results: Sequence[CharacterResult], selections: Selections) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous("override.usdc")
    with Sdf.ChangeBlock():
        for result in results:
            selected = selections.choose(*_set_of(result))
            _author_character(layer, stage, result, selected)
    return layer


def _set_of(result: CharacterResult) -> tuple[Sdf.Path, str, tuple[str, ...]]:
    return result.character.model, result.character.variant_set, (*result.names, ORIGINAL)


def _author_character(layer: Sdf.Layer, stage: Usd.Stage, result: CharacterResult, selected: str) -> None:
    character = result.character
    model = Sdf.CreatePrimInLayer(layer, character.model)
    model.variantSetNameList.prependedItems.append(character.variant_set)
    model.variantSelections[character.variant_set] = selected
    _author_bindings(layer, character, character.model)
    variant_set = Sdf.VariantSetSpec(model, character.variant_set)
    recipe = _recipe_schemas(stage.GetPrimAtPath(character.animation))
    original = _author_output(Sdf.VariantSpec(variant_set, ORIGINAL).primSpec, character, recipe)
    if _loses_clips(stage, character):
        _copy_samples(stage.GetPrimAtPath(character.animation), original)
    for name, samples in zip(result.names, result.variants, strict=True):
        variant = Sdf.VariantSpec(variant_set, name).primSpec
        _author_bindings(layer, character, variant.path)
        _author_uninstanced(layer, stage, character, variant.path)
        output = _author_output(variant, character, recipe)
        _author_samples(output, samples)
        if samples.curves:
            author_curves(output, samples.curves)


def _recipe_schemas(animation: Usd.Prim) -> list[str]:
    # From the metadata and not GetAppliedSchemas, which knows registered schemas only.
    applied = animation.GetMetadata("apiSchemas")
    return [name for name in (applied.GetAppliedItems() if applied else ()) if name.startswith("Mtex")]


def _author_bindings(layer: Sdf.Layer, character: Character, below: Sdf.Path) -> None:
    """Bind each Skeleton to the output, below the model or below one of its variants."""
    for skeleton in character.skeletons:
        prim = Sdf.CreatePrimInLayer(layer, skeleton.ReplacePrefix(character.model, below))
        prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["SkelBindingAPI"]))
        binding = Sdf.RelationshipSpec(prim, "skel:animationSource", custom=False)
        binding.targetPathList.explicitItems = [character.output]


def _author_uninstanced(layer: Sdf.Layer, stage: Usd.Stage, character: Character, variant: Sdf.Path) -> None:
    """Open the instances between model and Skeletons, or the variant's bindings would not reach them."""
    above = {path for skeleton in character.skeletons for path in skeleton.GetPrefixes()}
    for path in sorted(path for path in above if path.HasPrefix(character.model) and path != character.model):
        if stage.GetPrimAtPath(path).IsInstance():
            Sdf.CreatePrimInLayer(layer, path.ReplacePrefix(character.model, variant)).instanceable = False


def _author_output(variant: Sdf.PrimSpec, character: Character, recipe: Sequence[str]) -> Sdf.PrimSpec:
    output = Sdf.PrimSpec(variant, character.output.name, Sdf.SpecifierDef, "SkelAnimation")
    output.referenceList.Prepend(Sdf.Reference("", character.animation))
    # Through the reference it inherits the recipe, and would be a sketch itself.
    output.SetInfo("apiSchemas", Sdf.TokenListOp.Create(deletedItems=list(recipe)))
    return output


def _author_samples(output: Sdf.PrimSpec, samples: VariantSamples) -> None:
    output.SetInfo("customData", {"mtex": to_metadata(samples.custom_data)})
    types = Sdf.ValueTypeNames
    joints = Sdf.AttributeSpec(output, "joints", types.TokenArray, Sdf.VariabilityUniform)
    joints.default = Vt.TokenArray(samples.joints)
    rotations = Sdf.AttributeSpec(output, "rotations", types.QuatfArray)
    values = np.ascontiguousarray(samples.rotations[..., _REAL_LAST], dtype=np.float32)
    _author_values(rotations, Vt.QuatfArray.FromNumpy, samples.time_codes, values)
    translations = Sdf.AttributeSpec(output, "translations", types.Float3Array)
    values = np.ascontiguousarray(samples.translations, dtype=np.float32)
    _author_values(translations, Vt.Vec3fArray.FromNumpy, samples.time_codes, values)
    scales = Sdf.AttributeSpec(output, "scales", types.Half3Array)
    _author_values(
        scales, Vt.Vec3hArray.FromNumpy, samples.time_codes, np.ascontiguousarray(samples.scales, dtype=np.float16)
    )


def _author_values(
    attribute: Sdf.AttributeSpec,
    to_usd: Callable[[npt.NDArray[np.floating]], object],
    time_codes: npt.NDArray[np.float64],
    values: npt.NDArray[np.floating],
) -> None:
    if (values == values[0]).all():
        # One default is as strong as samples: it beats whatever the referenced animation says at any time.
        attribute.default = to_usd(values[0])
        return
    layer, attribute_path = attribute.layer, attribute.path
    for time_code, value in zip(time_codes.tolist(), values, strict=True):
        layer.SetTimeSample(attribute_path, time_code, to_usd(value))


def _loses_clips(stage: Usd.Stage, character: Character) -> bool:
    """Tell whether the samples come from value clips on a prim that is above the animation and not above the output.

    Clips reach what is below their prim, and a reference brings those of its target alone.
    """
    above = character.animation.GetParentPath().GetPrefixes()
    clipped = (path for path in above if stage.GetPrimAtPath(path).HasAuthoredMetadata("clips"))
    return any(not character.output.HasPrefix(path) for path in clipped)


def _copy_samples(animation: Usd.Prim, output: Sdf.PrimSpec) -> None:
    for name in ("rotations", "translations", "scales"):
        attribute = animation.GetAttribute(name)
        copy = Sdf.AttributeSpec(output, name, attribute.GetTypeName())
        for time_code in attribute.GetTimeSamples():
            output.layer.SetTimeSample(copy.path, time_code, attribute.Get(time_code))


def _take_over(layer: Sdf.Layer, keep: Sequence[Character], earlier_path: Path, selections: Selections) -> None:
    """Copy sets that this run did not make from the layer that is about to be replaced."""
    if not keep or not earlier_path.exists():
        return
    earlier = open_layer(earlier_path)
    for character in keep:
        spec = earlier.GetPrimAtPath(character.model)
        if spec and character.variant_set in spec.variantSets:
            _copy_set(earlier, layer, character, selections)


def _copy_set(earlier: Sdf.Layer, layer: Sdf.Layer, character: Character, selections: Selections) -> None:
    model = Sdf.CreatePrimInLayer(layer, character.model)
    model.variantSetNameList.prependedItems.append(character.variant_set)
    set_path = character.model.AppendVariantSelection(character.variant_set, "")
    Sdf.CopySpec(earlier, set_path, layer, set_path)
    paths = sorted(set(model.variantSets[character.variant_set].variants.keys()) - {ORIGINAL})
    selected = selections.keep(character.model, character.variant_set, [*paths, ORIGINAL])
    model.variantSelections[character.variant_set] = selected
    _author_bindings(layer, character, character.model)


def _update_selections(root: Sdf.Layer, layer: Sdf.Layer, characters: Sequence[Character]) -> None:
    """Bring what users selected in the thin root in line: there it is stronger than in the override layer."""
    for character in characters:
        theirs, ours = root.GetPrimAtPath(character.model), layer.GetPrimAtPath(character.model)
        if theirs and ours and character.variant_set in theirs.variantSelections:
            selected = ours.variantSelections.get(character.variant_set)
            if selected:
                theirs.variantSelections[character.variant_set] = selected
