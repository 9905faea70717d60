"""Which take a clip's media is.

Other applications keep of a clip what they know of: its media's file and name at least. So the media tells, by our
metadata on it where that was kept, else by its name, else by a file that holds one take alone. The clip's own name and
metadata say what it was when it was written, and relinking a clip leaves them as they were; but a clip that says it is
of a take nobody knows is refused, whatever its media.
"""

from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from urllib.parse import unquote, urlsplit

import opentimelineio as otio

from mtex_usd.editorial.records import TakeMedia, mark_of
from mtex_usd.errors import InputError

__all__ = ["find_take"]


def find_take(clip: otio.schema.Clip, where: str, takes: Mapping[str, TakeMedia]) -> TakeMedia:
    """Find the take of the recipe that a clip's media reference stands for.

    Parameters
    ----------
    clip
        The clip.
    where
        What messages call it: its name and time.
    takes
        The takes of the recipe, by prim path.

    Raises
    ------
    InputError
        Where there is none, or it could be several; lists the takes there are.
    """
    own = mark_of(clip.metadata).get("take")
    if own is not None and str(own) not in takes:
        raise _refuse(where, f"{own} in the clip's metadata", takes.values())
    media = clip.media_reference
    if not isinstance(media, otio.schema.ExternalReference):
        raise _refuse(where, "it has no media", takes.values())
    in_file = [take for take in takes.values() if _is_file_of(media.target_url, take)]
    said = _said_take(media)
    if said:
        found = [take for take in in_file if said == take.prim_path] or [take for take in in_file if said == take.name]
    else:
        found = in_file if len(in_file) == 1 else [take for take in in_file if take.name == clip.name]
    if len(found) != 1:
        raise _refuse(where, f"{said or 'no name'} in {media.target_url or 'no file'}", takes.values())
    return found[0]


def _said_take(media: otio.schema.ExternalReference) -> str:
    said = mark_of(media.metadata).get("take")
    return said if isinstance(said, str) else media.name


def _is_file_of(url: str, take: TakeMedia) -> bool:
    """Whether a URL names a take's file, which may have moved to another folder with the whole project."""
    return not url or PurePosixPath(unquote(urlsplit(url).path)).name == take.file_path.name


def _refuse(where: str, found: str, takes: Iterable[TakeMedia]) -> InputError:
    return InputError(
        f"{where}: unknown take",
        expected=f"one of the recipe's takes: {', '.join(take.prim_path for take in takes)}",
        found=found,
    )
