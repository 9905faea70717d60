"""What Blender makes of stages: run by a Python that has ``bpy``, this writes where every bone is, as JSON.

``python read_bones.py OUT.json 0,10,20 STAGE...`` writes
``{stage: {parent of the armature: {frame: {bone: [x, y, z]}}}}``, positions of the bones' heads in Blender's world,
which is in metres and Z up. To a file, since Blender's own messages go to standard output, at any time.
"""

import json
import sys
from pathlib import Path

import bpy


def read_stage(stage_path: str, frames: list[int]) -> dict[str, dict[int, dict[str, list[float]]]]:
    """Import a stage into an empty scene and read all its armatures."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=stage_path, import_skeletons=True, set_frame_range=True)
    armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    found: dict[str, dict[int, dict[str, list[float]]]] = {armature.parent.name: {} for armature in armatures}
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        for armature in armatures:
            found[armature.parent.name][frame] = read_pose(armature)
    return found


def read_pose(armature: "bpy.types.Object") -> dict[str, list[float]]:
    """Read where the bones of an armature are in the frame that is set."""
    posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return {bone.name: list(posed.matrix_world @ bone.matrix.translation) for bone in posed.pose.bones}


if __name__ == "__main__":
    out, wanted, *stages = sys.argv[1:]
    frame_numbers = [int(frame) for frame in wanted.split(",")]
    Path(out).write_text(json.dumps({stage: read_stage(stage, frame_numbers) for stage in stages}))
