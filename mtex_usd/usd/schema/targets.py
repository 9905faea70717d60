"""Relationships of the schemas whose targets composition may drop."""

from collections.abc import Sequence

from pxr import Sdf, Usd

from mtex_usd.errors import StageError

__all__ = ["check_dropped"]


def check_dropped(relationship: Usd.Relationship, targets: Sequence[Sdf.Path]) -> None:
    """Refuse to go on without a target that a layer names but composition could not carry over.

    Parameters
    ----------
    relationship
        One that need not have targets.
    targets
        What composition gave.

    Raises
    ------
    StageError
        Naming the layer and the target.
    """
    if targets:
        return
    specs = [spec for spec in relationship.GetPropertyStack() if isinstance(spec, Sdf.RelationshipSpec)]
    for spec in specs:
        lost = spec.targetPathList.GetAppliedItems()
        if lost:
            raise StageError(
                f"{relationship.GetPath()}: composition dropped the target {lost[0]}",
                found=f"the target in layer {spec.layer.identifier}, outside what is referenced from there",
                fix="Move the target below the referenced prim, or author the relationship in the referencing layer.",
            )
        if spec.targetPathList.isExplicit:
            return
