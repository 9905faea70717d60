"""Which schemas are applied to a prim, and what their attributes say, whether or not USD knows them in this process."""

from typing import Any

from pxr import Usd

from mtex_usd.errors import InputError

__all__ = ["api_instances", "authored", "has_api", "where"]


def has_api(prim: Usd.Prim, api_name: str) -> bool:
    """Tell whether an API schema is applied, one that this process does not know included."""
    return api_name in _applied_schemas(prim)


def api_instances(prim: Usd.Prim, api_name: str) -> tuple[str, ...]:
    """Name the instances of a multiple-apply API schema, strongest first, registered or not."""
    prefix = f"{api_name}:"
    return tuple(name.removeprefix(prefix) for name in _applied_schemas(prim) if name.startswith(prefix))


def _applied_schemas(prim: Usd.Prim) -> list[str]:
    # GetAppliedSchemas drops what this process does not know; the type info lacks what other schemas build in.
    composed = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    return list(dict.fromkeys([*map(str, composed), *map(str, prim.GetAppliedSchemas())]))


def authored(prim: Usd.Prim, name: str) -> Any:
    """Give the authored value of an attribute that holds one for all time.

    Parameters
    ----------
    prim
        The prim that has the attribute.
    name
        The attribute's name.

    Returns
    -------
    object
        The composed value as USD gives it, time codes mapped by layer offsets; None where nothing is authored or the
        value is blocked.

    Raises
    ------
    InputError
        Where the attribute has time samples or a spline and no default value.
    """
    attribute = prim.GetAttribute(name)
    if not attribute or not attribute.HasAuthoredValue():
        return None
    # Get alone would give the schema's fallback in place of samples.
    if attribute.GetResolveInfo(Usd.TimeCode.Default()).GetSource() != Usd.ResolveInfoSourceDefault:
        raise InputError(
            f"{where(prim, name)} changes over time", expected="one value for all time", fix="Author a default value."
        )
    return attribute.Get()


def where(prim: Usd.Prim, name: str) -> str:
    """Give what messages call a property."""
    return f"{prim.GetPath()}.{name}"
