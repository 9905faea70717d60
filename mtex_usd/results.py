"""What :func:`mtex_usd.process` gives back: frozen objects with the names of the JSON file and of ``customData``."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from mtex_usd.constraints.retargeting import FittedTake, JointMap
from mtex_usd.motion.clip import Clip
from mtex_usd.texture.result import TexturedMotion, Variant

if TYPE_CHECKING:
    from mtex_usd.edit import ReducedKeys, ReducedPoses

__all__ = ["EditResult", "Fragment", "PathVariant", "Result", "Retarget", "list_retargets"]


@dataclass(frozen=True, eq=False)
class Fragment(Mapping[str, Any]):
    """Where one stretch of a variant comes from; readable as an object and as a mapping.

    Parameters
    ----------
    start, end
        Time codes on the sketch, both included.
    take
        Path of the take.
    takeStart, takeEnd
        Time codes on the take, both included: what ``Get`` on the composed stage takes.
    distance
        Matching distance, degrees squared summed over frames.
    scale
        Factor on the copied data, 1 unless scaling is on.
    """

    start: float
    end: float
    take: str
    takeStart: float  # noqa: N815 - the names in the layer and in the JSON file
    takeEnd: float  # noqa: N815
    distance: float
    scale: float

    def __getitem__(self, name: str) -> Any:
        """Give a value by its name."""
        if name not in self.__dict__:
            raise KeyError(name)
        return getattr(self, name)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return (field.name for field in fields(self))

    def __len__(self) -> int:
        """Count the names."""
        return len(fields(self))


@dataclass(frozen=True, eq=False)
class PathVariant:
    """One variant of a result.

    Parameters
    ----------
    name
        Name of the variant, such as ``path_01``.
    motion
        The motion with the joined path it was made from.
    custom_data
        What the variant carries as ``customData["mtex"]`` in the layer, and in the JSON file.
    """

    name: str
    motion: Variant
    custom_data: dict[str, Any]

    @property
    def rank(self) -> int:
        """1 is the best."""
        return self.motion.rank

    @property
    def distance(self) -> float:
        """Sum of the matching distances of its fragments."""
        return self.motion.distance

    @property
    def zeroCostJoins(self) -> int:  # noqa: N802
        """How many joins were consecutive in their take."""
        return self.motion.zero_cost_joins

    @property
    def rotationOrders(self) -> dict[str, str]:  # noqa: N802
        """Euler order by joint path."""
        return dict(self.custom_data["rotationOrders"])

    @property
    def fragments(self) -> tuple[Fragment, ...]:
        """Where each stretch comes from."""
        return tuple(Fragment(**fragment) for fragment in self.custom_data["fragments"])

    @property
    def clip(self) -> Clip:
        """The result on all joints of the skeleton."""
        return self.motion.clip

    @property
    def joined(self) -> npt.NDArray[np.float64]:
        """The joined path before texturing and synthesis, shape [F, C]; columns are the result's ``channels``."""
        return self.motion.joined

    @property
    def curves(self) -> npt.NDArray[np.float64]:
        """The finished curves in the same columns, shape [F, C]."""
        return self.motion.curves


@dataclass(frozen=True, kw_only=True)
class Retarget:
    """How takes of another skeleton were brought onto the character's.

    Parameters
    ----------
    takes
        Paths of the takes this holds for.
    takeConvention, convention
        Whose joint names the takes and the character have.
    scale
        Length of the character's legs in those of the takes'.
    mapped
        Joints of the take, with the weight of each, by joint of the character.
    unmapped
        Joints of the character that no take moves.
    unused
        Joints of the takes that move nothing.
    """

    takes: tuple[str, ...]
    takeConvention: str  # noqa: N815 - the names in the JSON file
    convention: str
    scale: float
    mapped: Mapping[str, Mapping[str, float]]
    unmapped: tuple[str, ...]
    unused: tuple[str, ...]

    def __str__(self) -> str:
        """Say it in one line."""
        first, *others = self.takes
        takes = f"{first} and {len(others)} more" if others else first
        names = f"joints {_known(self.takeConvention)} to {_known(self.convention)}"
        count = f"{len(self.mapped)} of {len(self.mapped) + len(self.unmapped)} joints follow"
        return f"take {takes} retargeted, {names}: {count}, legs {self.scale:.3g} times as long"


def _known(convention: str) -> str:
    """How joints were recognised, in words."""
    return "told by shape" if convention == "hierarchy" else f"named as {convention}"


def list_retargets(takes: Sequence[FittedTake]) -> tuple[Retarget, ...]:
    """Give what takes were retargeted, those with the same map together."""
    groups: dict[JointMap, list[str]] = {}
    for take in takes:
        if take.joint_map is not None:
            groups.setdefault(take.joint_map, []).append(take.clip.name)
    return tuple(_describe_map(joint_map, names) for joint_map, names in groups.items())


def _describe_map(joint_map: JointMap, takes: Sequence[str]) -> Retarget:
    found, wanted = joint_map.anatomies
    return Retarget(
        takes=tuple(takes),
        takeConvention=found.convention,
        convention=wanted.convention,
        scale=joint_map.scale,
        mapped=joint_map.mapped,
        unmapped=joint_map.unmapped,
        unused=joint_map.unused,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Result:
    """One sketch on one character.

    Parameters
    ----------
    anim
        Path of the sketch.
    model
        Path of the prim with the variant set.
    variantSet
        Name of the variant set.
    variants
        Best first; ``original`` is not among them.
    texturing
        All the method found, to check its laws by.
    layer, stage
        The files written; with ``dry_run`` those that would be.
    retargets
        What was brought from other skeletons onto the character's.
    notes
        What a user should know about this sketch.
    left_out
        Sketches of the shot that could not be worked on, and why; the same for all results of a run.
    """

    anim: str
    model: str
    variantSet: str  # noqa: N815
    variants: tuple[PathVariant, ...]
    texturing: TexturedMotion
    layer: Path
    stage: Path
    retargets: tuple[Retarget, ...]
    notes: tuple[str, ...]
    left_out: tuple[str, ...] = ()

    @property
    def channels(self) -> tuple[str, ...]:
        """Full tokens of the copied channels, length C."""
        return self.texturing.channels


@dataclass(frozen=True, eq=False, kw_only=True)
class EditResult:
    """One animation that was edited on one character.

    Parameters
    ----------
    anim
        Path of the animation.
    model
        Path of the prim with the variant set.
    variantSet
        Name of the variant set; ``original`` is in it as well.
    variant
        Name of the edited variant.
    clip
        The result on all joints of the skeleton.
    custom_data
        What the variant carries as ``customData["mtex"]``.
    residuals
        How far each constraint is from met, metres or radians, by name.
    layer, stage
        The files written; with ``dry_run`` those that would be.
    notes
        What a user should know.
    keys
        The result by few keys, where the last edit reduced them.
    """

    anim: str
    model: str
    variantSet: str  # noqa: N815
    variant: str
    clip: Clip
    custom_data: Mapping[str, object]
    residuals: Mapping[str, float]
    layer: Path
    stage: Path
    notes: tuple[str, ...] = ()
    keys: "ReducedKeys | ReducedPoses | None" = None
