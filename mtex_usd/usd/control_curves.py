"""Motion as splines on scalar control attributes, for curve editors.

USD's splines (``Ts``) drive scalar attributes only, so the animation itself has samples and the curves stand beside it:
one attribute per channel on a Scope, named after joint and channel. A Bezier segment whose tangents are a third of it
wide is the cubic of :class:`mtex_usd.edit.KeyCurve`.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pxr import Sdf, Ts

from mtex_usd.usd.names import make_prim_name, make_unique

if TYPE_CHECKING:
    from mtex_usd.edit import KeyCurve

__all__ = ["CONTROLS_SUFFIX", "author_curves"]

CONTROLS_SUFFIX = "_controls"
"""What the Scope's name adds to that of the animation."""


def author_curves(animation: Sdf.PrimSpec, curves: "Sequence[KeyCurve]") -> None:
    """Author curves as splines beside an animation.

    Parameters
    ----------
    animation
        The animation's spec; ``<name>_controls`` comes beside it.
    curves
        One per channel. Attributes are ``double <joint>:<kind>``, the joint's path with a colon for each slash and
        names made valid; ``customData["mtex"]`` has joint, kind and unit.
    """
    parent = animation.nameParent
    scope = Sdf.PrimSpec(parent, f"{animation.name}{CONTROLS_SUFFIX}", Sdf.SpecifierDef, "Scope")
    taken: set[str] = set()
    for curve in curves:
        name = make_unique(_attribute_name(curve), taken)
        taken.add(name)
        attribute = Sdf.AttributeSpec(scope, name, Sdf.ValueTypeNames.Double)
        attribute.default = float(curve.values[0])
        unit = "degrees" if curve.kind.startswith("r") else "stage units"
        attribute.SetInfo("customData", {"mtex": {"joint": curve.joint, "kind": curve.kind, "unit": unit}})
        attribute.SetSpline(_make_spline(curve))  # type: ignore[attr-defined]


def _attribute_name(curve: "KeyCurve") -> str:
    joint = ":".join(make_prim_name(part, prefix="_") for part in curve.joint.split("/"))
    return f"{joint}:{curve.kind}"


def _make_spline(curve: "KeyCurve") -> "Ts.Spline":
    spline = Ts.Spline("double")
    before, after = [0.0, *curve.widths.tolist()], [*curve.widths.tolist(), 0.0]
    rows = zip(curve.time_codes, curve.values, curve.slopes_before, curve.slopes_after, before, after, strict=True)
    for time_code, value, slope_before, slope_after, width_before, width_after in rows:
        knot = Ts.Knot("double")  # type: ignore[attr-defined]
        knot.SetTime(float(time_code))
        knot.SetValue(float(value))
        knot.SetNextInterpolation(Ts.InterpCurve)  # type: ignore[attr-defined]
        knot.SetPreTanWidth(width_before)
        knot.SetPreTanSlope(float(slope_before))
        knot.SetPostTanWidth(width_after)
        knot.SetPostTanSlope(float(slope_after))
        spline.SetKnot(knot)  # type: ignore[attr-defined]
    return spline
