"""How fast a stage plays."""

from dataclasses import dataclass

import numpy as np
from pxr import Usd

from mtex_usd.errors import StageError

__all__ = ["StageRate", "stage_rate"]


@dataclass(frozen=True, kw_only=True)
class StageRate:
    """How fast a stage plays.

    Parameters
    ----------
    rate
        Frames per second.
    time_codes_per_second
        Time codes per second.
    """

    rate: float
    time_codes_per_second: float

    @property
    def time_codes_per_frame(self) -> float:
        """How far one frame is in time codes."""
        return self.time_codes_per_second / self.rate


def stage_rate(stage: Usd.Stage) -> StageRate:
    """Read how fast a stage plays.

    Frames per second count only where the root or session layer authors them; otherwise a frame is one time code.
    (``UsdStage.GetFramesPerSecond`` falls back to 24 even on a stage with 120 time codes per second.)

    Raises
    ------
    StageError
        Where a rate is not positive.
    """
    time_codes_per_second = float(stage.GetTimeCodesPerSecond())
    rate = time_codes_per_second
    for layer in (stage.GetSessionLayer(), stage.GetRootLayer()):
        if layer and layer.HasFramesPerSecond():
            rate = float(layer.framesPerSecond)
            break
    if not (0.0 < rate < np.inf and 0.0 < time_codes_per_second < np.inf):
        raise StageError(
            f"{stage.GetRootLayer().identifier}: bad rate",
            expected="framesPerSecond and timeCodesPerSecond above 0",
            found=f"{rate:g} and {time_codes_per_second:g}",
        )
    return StageRate(rate=rate, time_codes_per_second=time_codes_per_second)
