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
        What composition gave, forwarded or not.

    Raises
    ------
    StageError
        Naming the layer and the target.
    """
    specs = [spec for spec in relationship.GetPropertyStack() if isinstance(spec, Sdf.RelationshipSpec)]
    for spec in specs:
        listed = spec.targetPathList.GetAppliedItems()
        # Targets come in the words of the stage and not of the layer: only where one list is all there is, they count.
        lost = listed if not targets else _find_lost(listed, targets) if spec.targetPathList.isExplicit else []
        if lost:
            raise StageError(
                f"{relationship.GetPath()}: composition dropped the target {lost[0]}",
                found=f"the target in layer {spec.layer.identifier}, outside what is referenced from there",
                fix="Move the target below the referenced prim, or author the relationship in the referencing layer.",
            )
        if targets or spec.targetPathList.isExplicit:
            return


def _find_lost(listed: Sequence[Sdf.Path], targets: Sequence[Sdf.Path]) -> Sequence[Sdf.Path]:
    """Give what a list has and composition does not; by name where names tell."""
    if len(targets) >= len(set(listed)):
        return []
    kept = {path.name for path in targets}
    return [path for path in listed if path.name not in kept] or listed
