"""The edit that leaves few keys: as curves, or as poses."""

from collections.abc import Callable

from mtex_usd.edit.keys import ReducedKeys, ReducedPoses, reduce_keys, reduce_poses
from mtex_usd.edit.stack.edit import ContactFinder, Edit, Outcome
from mtex_usd.motion.clip import Clip

__all__ = ["run_reduce_keys"]

_FORMS: dict[str, Callable[..., ReducedKeys | ReducedPoses]] = {"curves": reduce_keys, "poses": reduce_poses}


def run_reduce_keys(clip: Clip, edit: Edit, find_contacts: ContactFinder) -> Outcome:
    """Run ``reduceKeys``; the borders of contacts stay keys.

    Parameters
    ----------
    clip, edit
        The motion and the edit.
    find_contacts
        Asked for the borders of contacts, unless ``contacts`` is off.
    """
    form = edit.settings.get("form", "curves")
    chosen = edit.pick(tolerance_deg="tolerance", tolerance_m="distance", channels="channels", robust="robust")
    count = edit.settings.get("keyCount", 0)
    contacts = edit.settings.get("contacts", "declared")
    frames = set(edit.whole_frames("keys", clip))
    if contacts != "off":
        frames |= set(find_contacts(clip, contacts))
    keys = _FORMS[form](clip, key_count=count or None, contact_frames=sorted(frames), **chosen)
    return Outcome(clip=keys.evaluate(), keys=keys, notes=(_describe(keys, clip),))


def _describe(keys: ReducedKeys | ReducedPoses, clip: Clip) -> str:
    within = f"within {keys.max_degrees:.2g} degrees and {keys.max_metres * 1000.0:.2g} mm"
    if isinstance(keys, ReducedPoses):
        return f"{len(keys.frames)} poses for {clip.frame_count} frames, {within}"
    samples = len(keys.curves) * clip.frame_count
    return f"{keys.key_count} keys on {len(keys.curves)} curves for {samples} samples, {within}"
