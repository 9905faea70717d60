"""Run inside a Python that has bpy: reduce rotations with Blender's Decimate and tell what came of it.

``python blender_decimate.py IN.npz OUT.npz ERROR`` reads unit quaternions ``rotations`` [F, J, 4], makes an F-curve of
every component of every joint, runs the operator in mode ERROR on all of them, and writes what the curves then are a
number of times a frame (``per_frame`` of the input), ``played`` [T, J, 4], how many ``keys`` are left, and the
``seconds`` of processor time the operator took.
"""

import sys
import time

import bpy
import numpy as np


def make_bones(count):
    """An armature of so many bones in a row."""
    figure = bpy.data.objects.new("figure", bpy.data.armatures.new("figure"))
    bpy.context.collection.objects.link(figure)
    bpy.context.view_layer.objects.active = figure
    bpy.ops.object.mode_set(mode="EDIT")
    for number in range(count):
        bone = figure.data.edit_bones.new(f"b{number}")
        bone.head, bone.tail = (number, 0.0, 0.0), (number, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="POSE")
    for bone in figure.pose.bones:
        bone.rotation_mode = "QUATERNION"
        (bone if hasattr(bone, "select") else bone.bone).select = True
    return figure


def make_channels(figure):
    """Where F-curves go: a layered action where there are such, else the action itself."""
    action = bpy.data.actions.new("motion")
    figure.animation_data_create().action = action
    if not hasattr(action, "slots"):
        return action
    slot = action.slots.new("OBJECT", "figure")
    figure.animation_data.action_slot = slot
    return action.layers.new("layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)


def make_curves(channels, rotations):
    """One curve a component, a Bezier key a frame, as Blender's own importers make them."""
    curves = []
    for joint in range(rotations.shape[1]):
        for index in range(4):
            curve = channels.fcurves.new(f'pose.bones["b{joint}"].rotation_quaternion', index=index)
            points = np.stack([np.arange(len(rotations)), rotations[:, joint, index]], axis=1)
            curve.keyframe_points.add(len(points))
            curve.keyframe_points.foreach_set("co", points.ravel())
            for key in curve.keyframe_points:
                key.interpolation, key.select_control_point = "BEZIER", True
                key.handle_left_type = key.handle_right_type = "AUTO_CLAMPED"
            curve.update()
            curves.append(curve)
    return curves


def decimate(error):
    """Run the operator on all selected keys; processor time in seconds."""
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type = "GRAPH_EDITOR"
    region = next(region for region in area.regions if region.type == "WINDOW")
    area.spaces[0].dopesheet.show_only_selected = False
    with bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region):
        start = time.process_time()
        done = bpy.ops.graph.decimate(mode="ERROR", remove_error_margin=error)
        seconds = time.process_time() - start
    if done != {"FINISHED"}:
        raise RuntimeError(f"Decimate did not finish: {done}")
    return seconds


def main(in_path, out_path, error):
    """Do it all."""
    given = np.load(in_path)
    rotations, per_frame = given["rotations"], int(given["per_frame"])
    curves = make_curves(make_channels(make_bones(rotations.shape[1])), rotations)
    seconds = decimate(float(error))
    times = np.arange((len(rotations) - 1) * per_frame + 1) / per_frame
    played = np.array([[curve.evaluate(frame) for frame in times] for curve in curves]).T
    keys = sum(len(curve.keyframe_points) for curve in curves)
    np.savez(out_path, played=played.reshape(len(times), -1, 4), keys=keys, seconds=seconds)


main(*sys.argv[1:])
