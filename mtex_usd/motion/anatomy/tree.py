"""The hierarchy of a skeleton, asked from above and from below."""

from dataclasses import dataclass
from functools import cached_property

from mtex_usd.motion.anatomy.words import strip_numbering
from mtex_usd.motion.skeleton import Skeleton

__all__ = ["Tree"]


@dataclass(frozen=True, eq=False)
class Tree:
    """Names and kinship of the joints of a skeleton.

    Parameters
    ----------
    skeleton
        The skeleton.
    """

    skeleton: Skeleton

    @cached_property
    def names(self) -> list[str]:
        """Last names, without a running number behind all of them, length J."""
        return strip_numbering([joint.rpartition("/")[2] for joint in self.skeleton.joints])

    @cached_property
    def parents(self) -> list[int]:
        """Parent of each joint, -1 for a root."""
        return [int(parent) for parent in self.skeleton.parents]

    @cached_property
    def children(self) -> list[list[int]]:
        """Children of each joint, by path, so that the order of siblings makes no difference."""
        children: list[list[int]] = [[] for _ in self.parents]
        for joint in sorted(range(len(self.parents)), key=lambda joint: self.skeleton.joints[joint]):
            if self.parents[joint] >= 0:
                children[self.parents[joint]].append(joint)
        return children

    @cached_property
    def sizes(self) -> list[int]:
        """How many joints hang from each joint, itself included."""
        sizes = [1] * len(self.parents)
        for joint in reversed(range(len(self.parents))):
            if self.parents[joint] >= 0:
                sizes[self.parents[joint]] += sizes[joint]
        return sizes

    def chain(self, joint: int) -> list[int]:
        """Joints from the root down to a joint, itself included."""
        return self.skeleton.chain(joint)

    def below(self, upper: int, lower: int) -> list[int]:
        """Joints from below an upper joint down to a lower one, itself included; empty where it is not below."""
        chain = self.chain(lower)
        return chain[chain.index(upper) + 1 :] if upper in chain else []

    def is_above(self, upper: int, lower: int) -> bool:
        """Tell whether a joint is a true ancestor of another."""
        return bool(self.below(upper, lower))

    def meet(self, a: int, b: int) -> int | None:
        """Give the last joint that both hang from or are, None where they have different roots."""
        shared = [x for x, y in zip(self.chain(a), self.chain(b), strict=False) if x == y]
        return shared[-1] if shared else None
