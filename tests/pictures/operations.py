"""Draw what every edit does to the sample walks, one picture for each operation.

    python -m tests.pictures.operations -o sample_stages/pictures/edits

Everything is drawn from sample_stages/takes.usda, so anyone can draw it again.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

import mtex_usd
from mtex_usd import edit
from mtex_usd.motion import quaternion
from mtex_usd.motion.clip import Clip
from tests.pictures.panels import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    VERMILION,
    cut,
    draw_curve,
    draw_figures,
    draw_way,
    label,
    make_figure,
    place_joint,
    read_channel,
    save,
)

PROJECT = Path(__file__).resolve().parents[2]
KNEE, ARM, ELBOW = "LeftLeg.rx", "LeftArm.ry", "LeftForeArm.ry"


def read_take(name: str, *, seconds: float = 10.0) -> Clip:
    """The first seconds of a sample take."""
    clip = mtex_usd.read_clip(PROJECT / "sample_stages" / "takes.usda", f"/Takes/{name}")
    return cut(clip, 0, min(clip.frame_count, round(seconds * clip.rate)) - 1)


def turn_joint(clip: Clip, name: str, degrees: np.ndarray, *, axis: int) -> Clip:
    """Turn a joint further about one of its own axes, by degrees [F]."""
    joint = next(index for index, path in enumerate(clip.joints) if path.rpartition("/")[2] == name)
    rotations = np.array(clip.rotations)
    turns = quaternion.exp(np.radians(degrees)[:, None] * np.eye(3)[axis])
    rotations[:, joint] = quaternion.multiply(rotations[:, joint], turns)
    return replace(clip, rotations=rotations)


def compare(axes: plt.Axes, before: Clip, afters: Sequence[tuple[str, Clip, str]], token: str) -> None:
    """Draw a channel before and after edits."""
    draw_curve(axes, before, read_channel(before, token), GREY, label="before")
    for name, clip, colour in afters:
        draw_curve(axes, clip, read_channel(clip, token), colour, label=name)


def draw_filter() -> plt.Figure:
    """Low-, high- and band-pass."""
    walk = read_take("walk_natural", seconds=5.0)
    low = edit.lowpass(walk, frequency=2.0)
    figure, panels = make_figure("lowpass, highpass, bandpass (grey: before)", "lhb/fff/fff")
    for key, name, clip, colour in (
        ("l", "lowpass 2 Hz", low, BLUE),
        ("h", "highpass 2 Hz, about the mean", edit.highpass(walk, frequency=2.0), VERMILION),
        ("b", "bandpass 0.5 to 1.5 Hz", edit.bandpass(walk, frequencies=(0.5, 1.5)), GREEN),
    ):
        compare(panels[key], walk, [("after", clip, colour)], KNEE)
        label(panels[key], name, y="left knee rx [deg]")
    frames = range(10, 74, 9)
    draw_figures(panels["f"], walk, frames, GREY)
    draw_figures(panels["f"], low, frames, BLUE)
    label(panels["f"], "lowpass 2 Hz: knees bend less, planted feet slide by 3 cm", "way [cm]", "height [cm]")
    return figure


def draw_equalize() -> plt.Figure:
    """Bands made stronger and weaker."""
    walk = read_take("walk_natural", seconds=8.0)
    upper = ["*Arm", "*ForeArm", "Spine*"]
    strong = edit.equalize(walk, gains=[0.0, 0.0, 6.0, 6.0], channels=upper)
    weak = edit.equalize(walk, gains=[0.0, 0.0, -12.0, -12.0], channels=upper)
    figure, panels = make_figure("equalize: bands 3 and 4 of spine and arms, the rest at 0 dB", "cc/sw/sw")
    compare(panels["c"], walk, [("+6 dB", strong, VERMILION), ("-12 dB", weak, BLUE)], ARM)
    label(panels["c"], "left upper arm", y="ry [deg]", legend=True)
    frames = range(24, 72, 8)
    for key, name, clip, colour in (
        ("s", "+6 dB: arms swing wider, feet keep their bits", strong, VERMILION),
        ("w", "-12 dB: arms hang, feet keep their bits", weak, BLUE),
    ):
        draw_figures(panels[key], walk, frames, GREY)
        draw_figures(panels[key], clip, frames, colour)
        label(panels[key], name, "way [cm]", "height [cm]")
    return figure


def draw_robust() -> plt.Figure:
    """Median and robust mean beside each other on spikes."""
    walk = read_take("walk_natural", seconds=4.0)
    spikes = np.zeros(walk.frame_count)
    spikes[[20, 21, 47, 70]] = -35.0, -35.0, 30.0, -45.0
    spoilt = turn_joint(walk, "LeftForeArm", spikes, axis=1)
    figure, panels = make_figure("median and robustMean: spikes put into a forearm, and out again", "m/r")
    for key, name, operation, colour in (
        ("m", "median", edit.median, BLUE),
        ("r", "robustMean", edit.robust_mean, VERMILION),
    ):
        clean = operation(spoilt, window_s=0.25, channels=["LeftForeArm"])
        compare(panels[key], spoilt, [("after", clean, colour)], ELBOW)
        draw_curve(panels[key], walk, read_channel(walk, ELBOW), "black", linestyle=":", label="without spikes")
        label(panels[key], f"{name}, window 0.25 s", y="left forearm ry [deg]", legend=True)
    return figure


def draw_waveshape() -> plt.Figure:
    """A curve about the mean, and soft limits about rest."""
    walk = read_take("walk_natural", seconds=5.0)
    points = [(-20.0, -36.0), (0.0, 0.0), (10.0, 18.0), (20.0, 24.0)]
    wider = edit.waveshape(walk, points=points, channels=[ARM])
    limits = edit.make_soft_limits(-5.0, 40.0, softness=12.0)
    held = edit.waveshape(walk, points=limits, channels=[KNEE], about="rest")
    figure, panels = make_figure("waveshape: values through a curve", "aab/ccd")
    compare(panels["a"], walk, [("after", wider, BLUE)], ARM)
    label(panels["a"], "arm made to swing wider about its mean, forward less so", y="left arm ry [deg]", legend=True)
    compare(panels["c"], walk, [("after", held, VERMILION)], KNEE)
    panels["c"].axhline(40.0, color="black", linewidth=0.7, linestyle=":")
    label(panels["c"], "knee held below 40 degrees by soft limits, about rest", y="left knee rx [deg]", legend=True)
    for key, before, after, colour in (("b", walk, wider, BLUE), ("d", walk, held, VERMILION)):
        token = ARM if key == "b" else KNEE
        panels[key].scatter(read_channel(before, token), read_channel(after, token), s=4, color=colour)
        panels[key].axline((0.0, 0.0), slope=1.0, color=GREY, linewidth=0.8)
        label(panels[key], "the curve", "before [deg]", "after [deg]")
    return figure


def draw_shift() -> plt.Figure:
    """One arm late, and what is at the ends."""
    walk = read_take("walk_natural", seconds=4.0)
    late = edit.shift_time(walk, shift_s=0.25, channels=["LeftArm", "LeftForeArm"])
    stride = edit.join(walk, walk).clip
    figure, panels = make_figure("shiftTime: an arm 0.25 s later; a closed stride 0.4 s later, by its ends", "ab/ff/ff")
    compare(panels["a"], walk, [("left arm 0.25 s later", late, BLUE)], ARM)
    label(panels["a"], "one arm alone", y="left arm ry [deg]", legend=True)
    draw_curve(panels["b"], stride, read_channel(stride, KNEE), GREY, label="before")
    for name, colour, style in (("extrapolate", GREEN, "-"), ("loop", VERMILION, "-"), ("hold", BLUE, "--")):
        shifted = edit.shift_time(stride, shift_s=0.4, ends=name)
        draw_curve(panels["b"], shifted, read_channel(shifted, KNEE), colour, label=name, linestyle=style)
    label(panels["b"], "what comes before the first frame", y="left knee rx [deg]", legend=True)
    frames = range(4, 92, 8)
    draw_figures(panels["f"], walk, frames, GREY)
    draw_figures(panels["f"], late, frames, BLUE)
    label(panels["f"], "the left arm drags behind, the feet keep their bits", "way [cm]", "height [cm]")
    return figure


def draw_scale() -> plt.Figure:
    """Gleicher's aliasing example: a shake sped up, beside every third frame taken as it is."""
    walk = read_take("walk_natural", seconds=6.0)
    shake = 8.0 * np.where(np.arange(walk.frame_count) % 2, -1.0, 1.0)
    shaking = turn_joint(walk, "Head", shake, axis=0)
    naive, fast = cut_every(shaking, 3), edit.scale_time(shaking, factor=1.0 / 3.0)
    slow = edit.scale_time(walk, factor=2.0)
    figure, panels = make_figure("scaleTime: three times as fast without aliasing, twice as slow", "as/bs/cs")
    for key, name, clip, colour in (
        ("a", "a head that shakes at 12 Hz, as recorded at 24 frames/s", shaking, GREY),
        ("b", "every third frame: a shake at 12 Hz that never was, should be 36 Hz", naive, VERMILION),
        ("c", "scaleTime 1/3: what the frames cannot carry is gone", fast, BLUE),
    ):
        draw_curve(panels[key], clip, read_channel(clip, "Head.rx"), colour)
        panels[key].set(xlim=(0.0, 2.0), ylim=(-16.0, 16.0))
        label(panels[key], name, "time [s]" if key == "c" else "", "head rx [deg]")
    draw_curve(panels["s"], walk, place_joint(walk, "LeftFoot")[:, 1], GREY, label="before")
    draw_curve(panels["s"], slow, place_joint(slow, "LeftFoot")[:, 1], GREEN, label="factor 2")
    panels["s"].set_xlim(0.0, 6.0)
    label(
        panels["s"], "twice as slow: steps as long and as high, feet as still", y="left ankle height [cm]", legend=True
    )
    return figure


def cut_every(clip: Clip, step: int) -> Clip:
    """Take every so manyeth frame as it is."""
    return replace(
        clip, rotations=clip.rotations[::step], translations=clip.translations[::step], scales=clip.scales[::step]
    )


def draw_warp() -> plt.Figure:
    """Footfalls moved."""
    walk = read_take("walk_natural", seconds=5.0)
    pairs = [(0, 0), (27, 27), (55, 75), (82, 92), (119, 129)]
    warped = edit.warp_time(walk, pairs=pairs)
    times, speeds = edit.TimeWarp(np.array(pairs, dtype=float)).source_times(np.arange(warped.frame_count, dtype=float))
    figure, panels = make_figure("warpTime: one stride drawn out, the next hurried", "th/sh")
    panels["t"].plot(np.arange(len(times)) / walk.rate, times / walk.rate, color=BLUE)
    panels["t"].scatter(*(np.array(pairs)[:, ::-1].T / walk.rate), color="black", s=14, zorder=3)
    label(panels["t"], "the warp and its pairs", "time of the result [s]", "time of the clip [s]")
    draw_curve(panels["s"], warped, speeds, VERMILION)
    label(panels["s"], "how fast the clip runs: never backwards", "time of the result [s]", "times recorded")
    panels["s"].set_ylim(0.0)
    for offset, foot, colour in ((0.0, "LeftFoot", BLUE), (30.0, "RightFoot", VERMILION)):
        draw_curve(panels["h"], walk, place_joint(walk, foot)[:, 1] + offset, GREY)
        draw_curve(panels["h"], warped, place_joint(warped, foot)[:, 1] + offset, colour, label=f"{foot} + {offset:g}")
    label(panels["h"], "footfalls move in time; the feet stand where they stood", y="ankle height [cm]", legend=True)
    return figure


def draw_align() -> plt.Figure:
    """A slow walk brought into step with a natural one."""
    slow, walk = read_take("walk_slow", seconds=7.6), read_take("walk_natural", seconds=6.3)
    found = edit.align(slow, walk)
    stepping = edit.warp_time(slow, pairs=found.pairs, frame_count=walk.frame_count)
    figure, panels = make_figure("align: walk_slow brought into step with walk_natural", "pb/pa")
    panels["p"].plot(*(found.path.T / walk.rate), color=GREY, linewidth=3.0, label="path through frames")
    panels["p"].plot(*(found.pairs.T / walk.rate), color=BLUE, marker=".", markersize=3, label="pairs of the warp")
    label(panels["p"], "which times correspond", "time of walk_slow [s]", "time of walk_natural [s]", legend=True)
    for key, clip, name in (("b", slow, "before"), ("a", stepping, "after")):
        draw_curve(panels[key], walk, read_channel(walk, KNEE), GREY, label="walk_natural")
        draw_curve(panels[key], clip, read_channel(clip, KNEE), BLUE, label="walk_slow")
        panels[key].set_xlim(0.0, walk.frame_count / walk.rate)
        label(panels[key], f"{name}: left knees", y="angle [deg]", legend=key == "b")
    return figure


def draw_blend() -> plt.Figure:
    """A slow walk to a brisk one and beyond; both have as many strides."""
    slow, brisk = read_take("walk_slow", seconds=5.5), read_take("walk_brisk", seconds=3.9)
    brisk = edit.warp_time(brisk, pairs=edit.align(brisk, slow).pairs, frame_count=slow.frame_count)
    figure, panels = make_figure("blend of walk_slow and walk_brisk, aligned first", "ab/cd")
    names = {0.0: "weight 0: walk_slow", 1.0: "weight 1: walk_brisk in walk_slow's time", 1.5: "weight 1.5: beyond it"}
    for key, weight, colour in (("a", 0.0, GREY), ("b", 0.5, BLUE), ("c", 1.0, GREY), ("d", 1.5, VERMILION)):
        mixed = edit.blend(slow, brisk, weights=weight).clip
        draw_figures(panels[key], mixed, range(0, 64, 8), colour)
        way = np.ptp(place_joint(mixed, "Hips")[:, 2]) * mixed.skeleton.meters_per_unit
        speed = way * mixed.rate / (mixed.frame_count - 1)
        label(panels[key], f"{names.get(weight, f'weight {weight:g}')}, {speed:.2f} m/s", "", "")
        panels[key].set(xlim=(-60.0, 420.0), xlabel="way [cm]", ylabel="height [cm]")
    return figure


def draw_join() -> plt.Figure:
    """A walk going over into a brisk one, and a stride closed to a loop."""
    walk, brisk = read_take("walk_natural", seconds=5.0), read_take("walk_brisk", seconds=5.0)
    at = edit.find_transition(walk, brisk, frames=(60, 110), other_frames=(10, 60))
    joined = edit.join(walk, brisk, transition=at)
    loop = edit.join(walk, walk).clip
    cycles = edit.scale_time(loop, factor=1.0, frame_count=4 * loop.frame_count, ends="loop")
    figure, panels = make_figure(
        "transition (join): walk_natural into walk_brisk, and a stride closed to a loop", "ff/ff/kl"
    )
    around = range(joined.first - 36, min(joined.last + 45, joined.clip.frame_count), 6)
    is_between = [joined.first <= frame <= joined.last for frame in around]
    for colour, chosen in ((GREY, False), (BLUE, True)):
        frames = [frame for frame, between in zip(around, is_between, strict=True) if between == chosen]
        draw_figures(panels["f"], joined.clip, frames, colour)
    label(
        panels["f"],
        f"every sixth frame; blue: {joined.first} to {joined.last}, between the two",
        "way [cm]",
        "height [cm]",
    )
    draw_curve(panels["k"], joined.clip, read_channel(joined.clip, KNEE), GREY)
    window = slice(joined.first - 1, joined.last + 2)
    times = np.arange(joined.clip.frame_count)[window] / walk.rate
    panels["k"].plot(times, read_channel(joined.clip, KNEE)[window], color=BLUE, linewidth=2.5)
    label(panels["k"], "over the transition (blue)", y="left knee rx [deg]")
    draw_curve(panels["l"], cycles, read_channel(cycles, KNEE), BLUE)
    for seam in range(0, cycles.frame_count, loop.frame_count - 1):
        panels["l"].axvline(seam / loop.rate, color=GREY, linewidth=0.8, linestyle=":")
    label(panels["l"], f"a loop of {loop.frame_count - 1} frames played on; dotted: its seams", y="left knee rx [deg]")
    return figure


def draw_displace() -> plt.Figure:
    """An arm raised over a second, and down again."""
    walk = read_take("walk_natural", seconds=5.0)
    key = edit.PoseChange(frame=60, rotations={"LeftArm": (0.0, -100.0, 0.0), "LeftForeArm": (0.0, -30.0, 0.0)})
    raised = edit.displace(walk, edit.Displacement(keys=[key], scope=24))
    figure, panels = make_figure(
        "displace: a pose changed at one frame, splined over 24 frames to either side", "a/f/f"
    )
    panels["a"].axvspan(36 / walk.rate, 84 / walk.rate, color=ORANGE, alpha=0.2, linewidth=0, label="scope")
    compare(panels["a"], walk, [("after", raised, VERMILION)], ELBOW)
    panels["a"].axvline(60 / walk.rate, color="black", linewidth=0.8, label="key")
    label(panels["a"], "left forearm: changed smoothly, its own swing stays", y="ry [deg]", legend=True)
    frames = range(30, 96, 6)
    draw_figures(panels["f"], walk, frames, GREY)
    draw_figures(panels["f"], raised, frames, VERMILION)
    label(panels["f"], "every sixth frame; the feet keep their bits", "way [cm]", "height [cm]")
    return figure


def draw_reduce() -> plt.Figure:
    """Cubic curves with few keys, and few poses."""
    walk = read_take("walk_natural", seconds=4.0)
    curves = edit.reduce_keys(walk, tolerance_deg=1.0, tolerance_m=0.01)
    poses = edit.reduce_poses(walk, key_count=32)
    figure, panels = make_figure("reduceKeys: cubic curves channel by channel, or sparse poses", "c/p")
    samples = walk.frame_count * len(curves.curves)
    name = f"cubic curves: {curves.key_count} keys for {samples} samples"
    found = next(curve for curve in curves.curves if curve.joint.endswith("LeftLeg") and curve.kind == "rx")
    compare(panels["c"], walk, [(name, curves.evaluate(), BLUE)], KNEE)
    panels["c"].scatter(found.frames / walk.rate, found.values, color=BLUE, s=14, zorder=3)
    off = f"{curves.max_degrees:.1f} deg, {100.0 * curves.max_metres:.1f} cm"
    label(panels["c"], f"at most {off} off; this channel's own keys", y="left knee rx [deg]", legend=True)
    played = poses.evaluate()
    name = f"pose keys: {poses.key_count} poses for {walk.frame_count} frames"
    compare(panels["p"], walk, [(name, played, VERMILION)], KNEE)
    keyed = read_channel(played, KNEE)[poses.frames]
    panels["p"].scatter(poses.frames / walk.rate, keyed, color=VERMILION, s=14, zorder=3)
    off = f"{poses.max_degrees:.1f} deg, {100.0 * poses.max_metres:.1f} cm"
    label(panels["p"], f"at most {off} off; all joints have keys together", y="left knee rx [deg]", legend=True)
    return figure


def draw_mirror() -> plt.Figure:
    """A walk that bends to the left, and to the right."""
    walk = read_take("walk_natural")
    mirrored = edit.mirror(walk)
    figure, panels = make_figure("mirror: left and right exchanged", "wll/wrr")
    draw_way(panels["w"], walk, GREY, label="before")
    draw_way(panels["w"], mirrored, BLUE, label="plane rest")
    draw_way(panels["w"], edit.mirror(walk, plane="facing"), VERMILION, label="plane facing", linestyle="--")
    label(panels["w"], "the hips' way from above", "x [m]", "z [m]", legend=True)
    panels["w"].legend(fontsize=7, frameon=False, loc="lower left")
    for key, before, after in (("l", ARM, "RightArm.ry"), ("r", KNEE, "RightLeg.rx")):
        first = cut(walk, 0, 95), cut(mirrored, 0, 95)
        draw_curve(panels[key], first[0], read_channel(first[0], before), GREY, linewidth=3.5, label=f"{before} before")
        values = read_channel(first[1], after) * (-1.0 if after.endswith("y") else 1.0)
        draw_curve(panels[key], first[1], values, BLUE, label=f"{'-' if after.endswith('y') else ''}{after} after")
        label(panels[key], "what the left did the right does", y="angle [deg]", legend=True)
    return figure


DRAWINGS: dict[str, Callable[[], plt.Figure]] = {
    "filter": draw_filter,
    "equalize": draw_equalize,
    "robust": draw_robust,
    "waveshape": draw_waveshape,
    "shiftTime": draw_shift,
    "scaleTime": draw_scale,
    "warpTime": draw_warp,
    "align": draw_align,
    "blend": draw_blend,
    "transition": draw_join,
    "displace": draw_displace,
    "reduceKeys": draw_reduce,
    "mirror": draw_mirror,
}


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the pictures")
    parser.add_argument(
        "operations", nargs="*", metavar="OPERATION", help=f"any of {', '.join(DRAWINGS)}; none for all"
    )
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    for name in given.operations or DRAWINGS:
        save(DRAWINGS[name](), given.output / f"{name}.png")


if __name__ == "__main__":
    main()
