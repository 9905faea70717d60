"""Names for prims and joints: valid for USD, unique, and as close to the original as that allows."""

from collections.abc import Collection, Sequence

from pxr import Sdf

__all__ = ["build_joint_paths", "make_prim_name", "make_unique", "make_unique_names"]


def make_prim_name(name: str, *, prefix: str) -> str:
    """Give a name that a prim may have.

    Parameters
    ----------
    name
        Any text. Valid names, also those with letters of other scripts, stay as they are.
    prefix
        Put before a name that had to be changed: ``"take_"`` makes ``07_01`` into ``take_07_01``.
    """
    if Sdf.Path.IsValidIdentifier(name):
        return name
    return prefix + "".join(c if Sdf.Path.IsValidIdentifier(f"_{c}") else "_" for c in name)


def make_unique(name: str, taken: Collection[str]) -> str:
    """Give a name that is not taken, by a number at its end from ``_2`` on where it is.

    Parameters
    ----------
    name
        A valid name.
    taken
        Names already in use.
    """
    number, unique = 1, name
    while unique in taken:
        number += 1
        unique = f"{name}_{number}"
    return unique


def make_unique_names(names: Sequence[str]) -> tuple[str, ...]:
    """Make names valid and all different.

    Parameters
    ----------
    names
        Any texts; they may repeat.

    Returns
    -------
    tuple of str
        In the same order. A name that was valid keeps its spelling before any mended one may take it; of equal names
        the first keeps it.
    """
    valid = {name for name in names if Sdf.Path.IsValidIdentifier(name)}
    taken: set[str] = set()
    unique = []
    for name in names:
        mended = make_prim_name(name, prefix="" if name[:1].isidentifier() else "_")
        first_of_valid = name in valid and name not in taken
        unique.append(name if first_of_valid else make_unique(mended, taken | valid))
        taken.add(unique[-1])
    return tuple(unique)


def build_joint_paths(names: Sequence[str], parents: Sequence[int]) -> tuple[str, ...]:
    """Give the joint tokens UsdSkel wants: paths of valid names, each name used once in the skeleton.

    Parameters
    ----------
    names
        Joint names as a file writes them, length J.
    parents
        Parent index of each joint, before its children; -1 for a root.

    Returns
    -------
    tuple of str
        Such as ``"Hips/Spine"``. Names are made unique over the whole skeleton, not only among siblings, so that the
        last name alone tells joints apart.
    """
    paths: list[str] = []
    for name, parent in zip(make_unique_names(names), parents, strict=True):
        paths.append(name if parent < 0 else f"{paths[parent]}/{name}")
    return tuple(paths)
