"""Timelines that anything may have happened to are followed or refused; nothing else comes of them."""

import copy
import json
import random
from pathlib import Path

import pytest

from mtex_usd.editorial.placing import place_track
from mtex_usd.editorial.reading import read_timeline
from mtex_usd.errors import InputError
from tests.editorial.tracks import FRAGMENTS, GRIDS, LIMIT, SHOT, media, write

VALUES = (None, 0, -1, 1, 1e308, -1e308, 1e-320, float("nan"), float("inf"), 2**63, True, "", "x", [], {}, [1])
SCHEMAS = (
    "Gap.1",
    "Clip.1",
    "Stack.1",
    "Transition.1",
    "FreezeFrame.1",
    "MissingReference.1",
    "Track.1",
    "RationalTime.1",
)
EACH = 100


def list_places(value: object) -> list[tuple]:
    """Every place in nested values, as what holds it and its key."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place for key, inner in items for place in [(value, key), *list_places(inner)]]


def damage(content: dict, chance: random.Random) -> None:
    """Change, remove, copy or add something somewhere."""
    for _ in range(chance.choice((1, 1, 2))):
        places = list_places(content)
        (holder, key), (other, other_key) = chance.choice(places), chance.choice(places)
        kind = chance.choice(("set", "set", "remove", "copy"))
        if kind == "remove":
            del holder[key]
        elif kind == "copy":
            holder[key] = copy.deepcopy(other[other_key])
        else:
            holder[key] = copy.deepcopy(chance.choice(SCHEMAS if key == "OTIO_SCHEMA" else VALUES))


@pytest.mark.parametrize("group", range(5))
def test_damaged_timelines_are_refused_or_followed(tmp_path: Path, group: int) -> None:
    at_shot = {name: pair[1] for name, pair in GRIDS.items()}
    file = write(tmp_path, FRAGMENTS, SHOT, media(GRIDS, 0), at_shot)
    whole = json.loads(file.read_text())
    refused = 0
    for seed in range(group * EACH, (group + 1) * EACH):
        content = copy.deepcopy(whole)
        damage(content, random.Random(seed))
        file.write_text(json.dumps(content))
        try:
            for track in read_timeline(file).tracks:
                placed = place_track(track, SHOT, media(GRIDS, 1), max_stretch=LIMIT)
                assert placed.fragments[-1].last == SHOT.frame_count - 1
        except InputError as error:
            refused += 1
            assert str(error)
    assert 0.3 * EACH < refused < EACH
