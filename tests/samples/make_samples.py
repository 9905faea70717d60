"""Make the stages in sample_stages/, byte for byte the same on every machine.

``python tests/samples/make_samples.py`` writes them; with ``--check`` it compares them with what it would write, and
exits with 1 where they differ.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.samples import content, humanoid, sketch, writer  # noqa: E402
from tests.samples.contacts import Motion  # noqa: E402
from tests.samples.gait import FRAME_RATE  # noqa: E402

__all__ = ["differing", "main", "make_stages", "write_stages"]

FOLDER = ROOT / "sample_stages"

_UPPER_BODY = ("Spine*", "Neck", "Head", "*Shoulder", "*Arm", "*Hand")
_LOWER_BODY = ("Hips", "*Leg", "*Foot")
_KNEE_AND_HIP = ("LeftUpLeg.rx", "LeftLeg.rx")
_HIPS = ("LeftUpLeg.rx", "RightUpLeg.rx")


def _library() -> str:
    takes = content.takes()
    body = ['def Scope "Takes"', "{", *writer.indent(writer.skeleton("guide"))]
    for take in takes:
        body += ["", *writer.indent(_take(take))]
    body.append("}")
    return writer.layer("Takes", len(takes[0].motion.root) - 1, FRAME_RATE, body, "Takes: three walks and two phrases.")


def _take(take: content.Take) -> list[str]:
    properties = [
        f"uniform timecode mtex:take:end = {len(take.motion.root) - 1}",
        "rel mtex:take:skeleton = </Takes/Skeleton>",
        "uniform timecode mtex:take:start = 0",
        f'uniform token mtex:take:style = "{take.style}"',
    ]
    header = ['prepend apiSchemas = ["MtexTakeAPI"]']
    return writer.animation(take.name, take.motion, humanoid.NAMES, header, properties)


def _recipe(match: Sequence[str], texture: Sequence[str], synthesize: Sequence[str]) -> list[str]:
    return [
        f"uniform token[] mtex:match = {writer.tokens(match)}",
        f"uniform token[] mtex:synthesize = {writer.tokens(synthesize)}",
        "rel mtex:takes = </Takes>",
        f"uniform token[] mtex:texture = {writer.tokens(texture)}",
    ]


def _segment(name: str, start: int, end: int, match: Sequence[str]) -> list[str]:
    return [
        f"uniform timecode mtex:segment:{name}:end = {end}",
        f"uniform token[] mtex:segment:{name}:match = {writer.tokens(match)}",
        f"uniform timecode mtex:segment:{name}:start = {start}",
    ]


def _shot(motion: Motion, apis: Sequence[str], recipe: Sequence[str], doc: str) -> str:
    header = [f"prepend apiSchemas = {writer.tokens(apis)}"]
    animation = writer.animation("Sketch", motion, sketch.SKETCHED, header, recipe)
    body = [
        *writer.shot_character(animation),
        "",
        'def Scope "Takes" (',
        "    prepend references = @./takes.usda@",
        ")",
        "{",
        "}",
    ]
    return writer.layer("Humanoid", len(motion.root) - 1, FRAME_RATE, body, doc)


def _stop_recipe(end: int) -> list[str]:
    return [
        *_recipe(_KNEE_AND_HIP, _LOWER_BODY, _UPPER_BODY),
        "uniform bool mtex:scale = 1",
        *_segment("stride", 0, content.STOP_FRAME - 1, _KNEE_AND_HIP),
        *_segment("stop", content.STOP_FRAME, end, _HIPS),
    ]


def _phrase_recipe() -> list[str]:
    return [*_recipe(("*Leg.rx", "Hips.ry"), (), _UPPER_BODY), "uniform int mtex:matchBand = 5"]


def make_stages() -> dict[str, str]:
    """Make the text of every stage, by file name."""
    motions = content.sketch_motions()
    stop_apis = ("MtexSketchAPI", "MtexSegmentAPI:stride", "MtexSegmentAPI:stop")
    walk_recipe = _recipe(_KNEE_AND_HIP, _LOWER_BODY, _UPPER_BODY)
    stop_recipe = _stop_recipe(len(motions["walk_to_stop"].root) - 1)
    doc = "The character: 21 joints, T-pose, centimetres."
    return {
        "humanoid.usda": writer.layer("Humanoid", 0, FRAME_RATE, writer.character(), doc),
        "takes.usda": _library(),
        "walk.usda": _shot(motions["walk"], stop_apis[:1], walk_recipe, "A walk, sketched on pelvis and legs."),
        "walk_to_stop.usda": _shot(motions["walk_to_stop"], stop_apis, stop_recipe, "A walk that slows to a stop."),
        "phrase.usda": _shot(motions["phrase"], stop_apis[:1], _phrase_recipe(), "A free-form phrase on planted feet."),
    }


def write_stages(folder: Path) -> None:
    """Write every stage into a folder."""
    for name, text in make_stages().items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def differing(folder: Path) -> list[str]:
    """Names of the stages that are absent from a folder or have other bytes there."""
    stages = make_stages()
    return [name for name, text in stages.items() if not _equals(folder / name, text)]


def _equals(file_path: Path, text: str) -> bool:
    return file_path.is_file() and file_path.read_bytes() == text.encode("utf-8")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check the sample stages; the exit code."""
    parser = argparse.ArgumentParser(description="Make the stages in sample_stages/.")
    parser.add_argument("--check", action="store_true", help="compare instead of writing; exit 1 where they differ")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where the stages are")
    options = parser.parse_args(arguments)
    if not options.check:
        write_stages(options.folder)
        return 0
    changed = differing(options.folder)
    for name in changed:
        print(f"{options.folder / name} is not what make_samples.py writes; run it without --check", file=sys.stderr)
    return 1 if changed else 0


if __name__ == "__main__":
    sys.exit(main())
