"""Suggested match channels and bands, written as overs on sketches into a layer of their own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Usd, Vt

from mtex_usd.errors import StageError
from mtex_usd.usd.atomic import mark_layer, write_layer
from mtex_usd.usd.stage_rate import stage_rate

__all__ = ["MatchRecipe", "check_overridable", "write_recipes"]

_UNIFORM = Sdf.VariabilityUniform


@dataclass(frozen=True)
class MatchRecipe:
    """The part of a recipe that says what to match on.

    Parameters
    ----------
    match
        Channel tokens of ``mtex:match``.
    break_channel
        Channel token of ``mtex:break``.
    band
        Of ``mtex:matchBand``.
    """

    match: tuple[str, ...]
    break_channel: str
    band: int

    @property
    def lines(self) -> tuple[str, ...]:
        """What to paste into the sketch, in USD's own text."""
        names = ", ".join(f'"{name}"' for name in self.match)
        return (
            f"uniform token[] mtex:match = [{names}]",
            f'uniform token mtex:break = "{self.break_channel}"',
            f"uniform int mtex:matchBand = {self.band}",
        )


def check_overridable(stage: Usd.Stage, prim_paths: Sequence[Sdf.Path]) -> None:
    """Make sure that overs on sketches have an effect.

    Parameters
    ----------
    stage
        The shot.
    prim_paths
        The sketches.

    Raises
    ------
    StageError
        Where a sketch is inside an instance, which nothing outside can change.
    """
    for prim_path in prim_paths:
        if stage.GetPrimAtPath(prim_path).IsInstanceProxy():
            raise StageError(
                f"{prim_path} is inside an instance, where a layer over the shot changes nothing",
                expected="a sketch outside instances",
                fix="Paste the lines into the asset that holds the sketch.",
            )


def write_recipes(stage: Usd.Stage, recipes: Mapping[Sdf.Path, MatchRecipe], file_path: Path) -> None:
    """Write what sketches are to match on into a layer of overs; among a shot's sublayers the first wins.

    Parameters
    ----------
    stage
        The shot, whose rate the layer gets.
    recipes
        By path of the sketch.
    file_path
        A file that is not there, or one this function wrote.
    """
    layer = Sdf.Layer.CreateAnonymous(f"recipe{file_path.suffix or '.usda'}")
    mark_layer(layer, "recipe")
    layer.timeCodesPerSecond = stage.GetTimeCodesPerSecond()
    layer.framesPerSecond = stage_rate(stage).rate
    for prim_path, recipe in recipes.items():
        prim = Sdf.CreatePrimInLayer(layer, prim_path)
        kinds = Sdf.ValueTypeNames
        _author(prim, "mtex:match", kinds.TokenArray, Vt.TokenArray(list(recipe.match)))
        _author(prim, "mtex:break", kinds.Token, recipe.break_channel)
        _author(prim, "mtex:matchBand", kinds.Int, recipe.band)
    write_layer(layer, file_path)


def _author(prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    Sdf.AttributeSpec(prim, name, type_name, _UNIFORM).default = value
