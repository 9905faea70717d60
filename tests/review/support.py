"""Reviews to test with: a sample stage worked on as the command does it, and what UsdSkel plays of the result."""

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Usd, UsdSkel

import mtex_usd
from mtex_usd.processing import finish_job
from mtex_usd.review.shot import Review
from mtex_usd.reviewing import build_review
from mtex_usd.usd.shot import find_cast, read_jobs
from mtex_usd.usd.source_stage import open_source

__all__ = ["COMMAND", "SAMPLES", "Written", "copy_samples", "make_review", "play", "write_result"]

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"
COMMAND = "usdmtex walk.usda --report review.html"


def copy_samples(folder: Path) -> Path:
    """Copy the sample stages; gives the folder."""
    for file in SAMPLES.glob("*.usda"):
        shutil.copy(file, folder)
    return folder


def make_review(shot: Path, *, title: str = "", **options: object) -> Review:
    """Work on a shot and gather what is shown of it; options are fields of the recipe."""
    source = open_source(shot)
    cast = find_cast(source.stage, only=[], previous=shot.with_name("none.usd"))
    jobs = list(read_jobs(source.stage, cast.wanted))
    finished = [finish_job(job, replace(job.recipe, **options)) for job in jobs]
    return build_review(finished, title=title or shot.name, command=COMMAND)


@dataclass(frozen=True)
class Written:
    """A result on disk: its thin root, the model with the variants, and the Skeleton."""

    stage_path: Path
    model: str
    skeleton: str


def write_result(shot: Path) -> Written:
    """Run `process` on a copy of a sample stage."""
    (result,) = mtex_usd.process(shot)
    return Written(result.stage, result.model, f"{result.model}/Skeleton")


def play(written: Written, variant: str, time_codes: list[float]) -> np.ndarray:
    """Joint positions in skeleton space as UsdSkel computes them for a variant, shape [N, J, 3]."""
    stage = Usd.Stage.Open(str(written.stage_path))
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        assert stage.GetPrimAtPath(written.model).GetVariantSet("mtex").SetVariantSelection(variant)
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath(written.skeleton)))
    return np.array([np.array(query.ComputeJointSkelTransforms(time))[:, 3, :3] for time in time_codes])
