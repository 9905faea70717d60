"""Clean-up of recorded motion in separate steps (Gleicher 2000, section 1.3), off unless asked for.

Every step is a pure function from a clip to a :class:`CleaningResult`: the clip after it, what was changed where, and
what was found and left. Frames and joints that a step does not name keep their bits.
"""

from mtex_usd.edit.cleaning.auto import CLEANING_STEPS, check_steps, clean_auto, clean_clip
from mtex_usd.edit.cleaning.flips import repair_flips
from mtex_usd.edit.cleaning.floor import report_floor
from mtex_usd.edit.cleaning.gaps import fill_gaps
from mtex_usd.edit.cleaning.jumps import report_jumps
from mtex_usd.edit.cleaning.leading import trim_leading
from mtex_usd.edit.cleaning.noise import smooth_noise
from mtex_usd.edit.cleaning.report import CleaningResult, Finding
from mtex_usd.edit.cleaning.spikes import SpikeFilter, repair_spikes

__all__ = [
    "CLEANING_STEPS",
    "CleaningResult",
    "Finding",
    "SpikeFilter",
    "check_steps",
    "clean_auto",
    "clean_clip",
    "fill_gaps",
    "repair_flips",
    "repair_spikes",
    "report_floor",
    "report_jumps",
    "smooth_noise",
    "trim_leading",
]
