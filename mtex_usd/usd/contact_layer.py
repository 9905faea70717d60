"""Contacts that were found, written as MtexContactAPI for an animator to edit."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pxr import Gf, Sdf, Tf, Usd

from mtex_usd.constraints.planting import Hold
from mtex_usd.motion.clip import Clip
from mtex_usd.usd.atomic import mark_layer, write_layer
from mtex_usd.usd.schema import CONTACT_API
from mtex_usd.usd.stage_rate import stage_rate

__all__ = ["write_contacts"]

_UNIFORM = Sdf.VariabilityUniform


def write_contacts(stage: Usd.Stage, found: Mapping[Sdf.Path, tuple[Clip, Sequence[Hold]]], file_path: Path) -> None:
    """Write the contacts of animations into a layer of overs.

    Parameters
    ----------
    stage
        The shot, whose rate the layer gets.
    found
        Motion and contacts by path of the animation.
    file_path
        A file that is not there, or one this function wrote.
    """
    layer = Sdf.Layer.CreateAnonymous(f"contacts{file_path.suffix or '.usda'}")
    mark_layer(layer, "contacts")
    layer.timeCodesPerSecond = stage.GetTimeCodesPerSecond()
    layer.framesPerSecond = stage_rate(stage).rate
    for path, (clip, holds) in found.items():
        prim = Sdf.CreatePrimInLayer(layer, path)
        groups: dict[str, list[Hold]] = {}
        for hold in holds:
            groups.setdefault(Tf.MakeValidIdentifier(hold.name.rpartition(" ")[0]), []).append(hold)
        prim.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[f"{CONTACT_API}:{name}" for name in groups]))
        for name, group in groups.items():
            _author_contact(prim, f"mtex:contact:{name}", group, clip)
    write_layer(layer, file_path)


def _author_contact(prim: Sdf.PrimSpec, prefix: str, holds: Sequence[Hold], clip: Clip) -> None:
    """Author one point and all its intervals."""
    kinds, times = Sdf.ValueTypeNames, clip.time_codes
    x, y, z = map(float, holds[0].offset)
    codes = [Sdf.TimeCode(float(times[frame])) for hold in holds for frame in (hold.first, hold.last)]
    values = {
        "joint": (kinds.Token, clip.joints[holds[0].joint]),
        "offset": (kinds.Point3d, Gf.Vec3d(x, y, z)),
        "intervals": (kinds.TimeCodeArray, Sdf.TimeCodeArray(codes)),
        "mode": (kinds.Token, "plant"),
    }
    for name, (type_name, value) in values.items():
        Sdf.AttributeSpec(prim, f"{prefix}:{name}", type_name, _UNIFORM).default = value
