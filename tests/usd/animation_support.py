"""Small stages with animations whose every number is known."""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdSkel, Vt

JOINTS = ("Hips", "Hips/LeftLeg", "Hips/Spine")


def author_skeleton(stage, prim_path, *, joints=JOINTS, heights=None):
    """Define a Skeleton whose joints sit above their parents."""
    skeleton = UsdSkel.Skeleton.Define(stage, prim_path)
    heights = heights if heights is not None else range(1, len(joints) + 1)
    rest = [Gf.Matrix4d().SetTranslate(Gf.Vec3d(0, height, 0)) for height in heights]
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateRestTransformsAttr(rest)
    return skeleton.GetPrim()


def author_animation(
    layer, prim_path, times, *, joints=JOINTS, seed=1, scales=True, translations=True, recipe=False, takes=()
):
    """Define a SkelAnimation with random rotations [S, J, 4] and translations [S, J, 3] at the times; gives both."""
    prim_path = Sdf.Path(prim_path)
    for parent in prim_path.GetParentPath().GetPrefixes():
        define(layer, parent, layer.GetPrimAtPath(parent).typeName if layer.GetPrimAtPath(parent) else "Scope")
    spec = define(layer, prim_path, "SkelAnimation")
    Sdf.AttributeSpec(spec, "joints", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform).default = list(joints)
    rng = np.random.default_rng(seed)
    quaternions = rng.standard_normal((len(times), len(joints), 4)).astype(np.float32)
    quaternions /= np.linalg.norm(quaternions, axis=-1, keepdims=True)
    offsets = rng.standard_normal((len(times), len(joints), 3)).astype(np.float32)
    kinds = Sdf.ValueTypeNames
    set_samples(spec, "rotations", kinds.QuatfArray, times, [to_quatf(pose) for pose in quaternions])
    if translations:
        set_samples(spec, "translations", kinds.Float3Array, times, [Vt.Vec3fArray.FromNumpy(pose) for pose in offsets])
    if scales:
        attribute = Sdf.AttributeSpec(spec, "scales", kinds.Half3Array)
        attribute.default = Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(joints))
    if recipe:
        apply_recipe(spec, takes)
    return quaternions, offsets


def one_animation(times, *, prim_path="/Anim", metadata=None, **options):
    """Give a stage with one animation, its prim, rotations and translations."""
    layer = new_layer(**(metadata or {}))
    rotations, translations = author_animation(layer, prim_path, times, **options)
    stage = stage_of(layer)
    return stage, stage.GetPrimAtPath(prim_path), rotations, translations


def apply_recipe(spec, takes):
    """Make an animation a sketch that names takes."""
    spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["MtexSketchAPI"]))
    relationship = Sdf.RelationshipSpec(spec, "mtex:takes", False, Sdf.VariabilityUniform)
    relationship.targetPathList.explicitItems = [Sdf.Path(take) for take in takes]


def define(layer, prim_path, type_name):
    spec = Sdf.CreatePrimInLayer(layer, prim_path)
    spec.specifier = Sdf.SpecifierDef
    if type_name:
        spec.typeName = type_name
    return spec


def set_samples(spec, name, type_name, times, values):
    attribute = Sdf.AttributeSpec(spec, name, type_name)
    for time, value in zip(times, values, strict=True):
        spec.layer.SetTimeSample(attribute.path, time, value)


def to_quatf(pose):
    """Make a VtArray of [J, 4] real-first numbers, by USD's own constructors."""
    return Vt.QuatfArray([Gf.Quatf(*map(float, q)) for q in pose])


def new_layer(tag="layer.usda", **metadata):
    layer = Sdf.Layer.CreateAnonymous(tag)
    for name, value in metadata.items():
        setattr(layer, name, value)
    return layer


def stage_of(layer):
    return Usd.Stage.Open(layer)


def bits(array):
    """Give the bits of float32 numbers, to compare exactly."""
    return np.ascontiguousarray(array, dtype=np.float32).view(np.uint32)


def read_directly(prim, name, time_code):
    """Read one value as plain USD does, real part first."""
    value = prim.GetAttribute(name).Get(time_code)
    if name == "rotations":
        return np.array([[q.real, *q.imaginary] for q in value], dtype=np.float32)
    return np.array(value, dtype=np.float32)
