"""Which variant a set selects: as asked for, else as the user left it, else the best path."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Usd

from mtex_usd.errors import InputError
from mtex_usd.usd.atomic import is_ours
from mtex_usd.usd.diagnostics import open_layer
from mtex_usd.usd.thin_root import thin_root_path

__all__ = ["Selections", "check_selection", "read_selections"]


def check_selection(asked: str | None, names: Sequence[str], prim_path: Sdf.Path) -> None:
    """Refuse to select a variant that there is not going to be.

    Parameters
    ----------
    asked
        The variant; None where nothing is asked for.
    names
        Those there are going to be.
    prim_path
        Of the animation or the model, for the message.

    Raises
    ------
    InputError
        Naming what there is.
    """
    if asked is not None and asked not in names:
        raise InputError(f"{prim_path} gets no variant {asked!r}", expected=f"one of {', '.join(names)}")


@dataclass(frozen=True, kw_only=True)
class Selections:
    """What earlier runs and the user left selected.

    Parameters
    ----------
    layers
        Strongest first.
    asked
        The variant to select in every set, whatever was selected; None to leave it to the layers.
    """

    layers: tuple[Sdf.Layer, ...]
    asked: str | None

    def choose(self, model: Sdf.Path, variant_set: str, names: Sequence[str]) -> str:
        """Choose the variant that a set selects.

        Parameters
        ----------
        model, variant_set
            The set; `model` names it in messages too.
        names
            The variants it is going to have; the first is taken where nothing else is said.

        Raises
        ------
        InputError
            Where the one asked for is none of them; lists them.
        """
        if self.asked is None:
            return self.keep(model, variant_set, names)
        check_selection(self.asked, sorted(names), model)
        return self.asked

    def keep(self, model: Sdf.Path, variant_set: str, names: Sequence[str]) -> str:
        """Give the variant that was selected, whatever is asked for now.

        Parameters
        ----------
        model, variant_set
            The set.
        names
            The variants it is going to have; the first is taken where none was selected or it is gone. Path variants
            are the same by number: ``path_02`` is ``path_002`` where there are a hundred or more.
        """
        had = self._had(model, variant_set)
        same = (name for name in names if had and _number(name) == _number(had))
        return next(same, names[0])

    def _had(self, model: Sdf.Path, variant_set: str) -> str:
        specs = (layer.GetPrimAtPath(model) for layer in self.layers)
        selections = (spec.variantSelections.get(variant_set) for spec in specs if spec)
        return next((selection for selection in selections if selection), "")


def _number(variant: str) -> str:
    """Give a variant's name without the zeros it is padded with."""
    head, _, digits = variant.rpartition("_")
    return f"{head}_{int(digits)}" if head and digits.isdecimal() else variant


def read_selections(stage: Usd.Stage, out: Path, asked: str | None) -> Selections:
    """Gather the layers that may say what is selected.

    Parameters
    ----------
    stage
        The shot, our own layers muted; they and the thin roots beside them count before the shot's layers, which they
        were stacked over.
    out
        The override layer about to be written; what is there now and its thin root count first.
    asked
        What the user asks for now.
    """
    overrides = [out, *map(Path, stage.GetMutedLayers())]
    files = [file_path for override in overrides for file_path in (thin_root_path(override), override)]
    layers = [open_layer(file_path) for file_path in filter(is_ours, files)]
    return Selections(layers=(*layers, *stage.GetLayerStack(includeSessionLayers=False)), asked=asked)
