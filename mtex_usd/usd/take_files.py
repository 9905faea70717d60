"""Where takes come from: the files that hold their samples."""

from pathlib import Path

from pxr import Ar, Usd

__all__ = ["find_take_file"]


def find_take_file(stage: Usd.Stage, prim_path: str) -> Path:
    """Give the file that holds a take's samples.

    Parameters
    ----------
    stage
        The shot.
    prim_path
        The take.

    Returns
    -------
    Path
        That of the strongest layer that says how the take turns, else of the strongest that says anything; inside a
        package the package; the shot itself where neither is a file.
    """
    prim = stage.GetPrimAtPath(prim_path)
    rotations = prim.GetAttribute("rotations").GetPropertyStack(Usd.TimeCode.Default())
    names = [spec.layer.realPath for spec in (*rotations, *prim.GetPrimStack())]
    name = next((name for name in names if name), stage.GetRootLayer().realPath)
    return Path(Ar.SplitPackageRelativePathOuter(name)[0]).absolute()
