"""Timelines of the sample shots: written as ``usdmtex --timeline`` does, edited, and looked at."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import opentimelineio as otio
from pxr import Sdf

from mtex_usd.conforming import describe_timeline
from mtex_usd.editorial.files import write_timeline_text
from mtex_usd.processing import finish_job
from mtex_usd.usd.check import check_override
from mtex_usd.usd.finished import build_result
from mtex_usd.usd.override import write_override
from mtex_usd.usd.shot import find_cast, read_jobs
from mtex_usd.usd.source_stage import open_source

__all__ = ["read_samples", "read_timeline", "write_shot", "write_timeline"]

Samples = dict[str, dict[float, np.ndarray]]


def write_shot(shot: str, *, timeline: str = "edit.otio", band: int | None = None) -> None:
    """Process a shot into its ``.mtex.usd`` and write its timeline."""
    source, target = open_source(Path(shot)), Path(shot).with_suffix(".mtex.usd")
    cast = find_cast(source.stage, only=(), previous=target)
    finished = []
    for job in read_jobs(source.stage, cast.wanted):
        recipe = job.recipe if band is None else replace(job.recipe, match_band=band)
        finished.append(finish_job(job, recipe))
    built = [build_result(each) for each in finished]
    _, root = write_override(source.stage, built, target)
    check_override(root, built)
    write_timeline_text(Path(timeline), describe_timeline(source, finished))


def read_timeline(file_path: str = "edit.otio") -> otio.schema.Timeline:
    """Read a timeline as another application would."""
    return otio.adapters.read_from_file(file_path)


def write_timeline(timeline: otio.schema.Timeline, file_path: str = "edit.otio") -> None:
    """Write a timeline as another application would."""
    otio.adapters.write_to_file(timeline, file_path)


def read_samples(layer_path: str, model: str, variant: str, *, variant_set: str = "mtex") -> Samples:
    """Read everything a variant's animation holds in a layer: bytes by attribute and time code; NaN for the default."""
    layer = Sdf.Layer.OpenAsAnonymous(layer_path)
    spec = layer.GetPrimAtPath(model).variantSets[variant_set].variants[variant].primSpec
    (output,) = [child for child in spec.nameChildren if child.typeName == "SkelAnimation"]
    found: Samples = {}
    for attribute in output.attributes:
        times = layer.ListTimeSamplesForPath(attribute.path)
        values = {time: np.array(layer.QueryTimeSample(attribute.path, time)) for time in times}
        found[attribute.name] = values or {-1.0: np.array(attribute.default)}
    return found
