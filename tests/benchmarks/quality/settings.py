"""The settings that are compared, and how a method is run on a fold."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mtex_usd.texture.engine import texture_motion
from mtex_usd.texture.recipe import Recipe
from mtex_usd.texture.result import TexturedMotion
from tests.benchmarks.quality.cases import Case, Fold

__all__ = ["DEFAULT", "LITERAL", "SETTINGS", "make_recipe", "run_method"]

LITERAL = "literal PB"
DEFAULT = "default: band and below, continuity"

# The last is what the recipe falls back to; nothing is set there.
SETTINGS: Mapping[str, Mapping[str, Any]] = {
    LITERAL: {"match_lower": False, "path_cost": "consecutive"},
    "band and below": {"match_lower": True, "path_cost": "consecutive"},
    "literal band, continuity": {"match_lower": False, "path_cost": "continuity"},
    DEFAULT: {},
}


def make_recipe(case: Case, **settings: Any) -> Recipe:
    """The recipe of a case: upper body synthesized, match channels and band of the table, all else by default."""
    recipe = Recipe(match=case.match, match_band=case.band, synthesize=case.rig.synthesized)
    return replace(recipe, **settings)


def run_method(fold: Fold, **settings: Any) -> TexturedMotion:
    """Run the method on a fold with the defaults, except for the settings given."""
    return texture_motion(fold.sketch, fold.takes, make_recipe(fold.case, **settings))
