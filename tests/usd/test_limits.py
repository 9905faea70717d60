"""Joint limits on a Skeleton, and that what is solved keeps them."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, Vt

import mtex_usd
from mtex_usd.constraints.planting import JointRange
from mtex_usd.errors import InputError
from mtex_usd.motion import quaternion
from mtex_usd.usd.limits import read_limits
from mtex_usd.usd.skeletons import read_skeleton
from tests.usd.schema_support import open_text

SKELETON = """def Skeleton "Skeleton"
{{
    uniform token[] joints = ["Hips", "Hips/Leg"]
    uniform matrix4d[] restTransforms = [
        ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
        ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, -1, 0, 1))
    ]
    {body}
}}
"""


def read_text(body: str) -> tuple[JointRange, ...]:
    stage = open_text(SKELETON.format(body=body))
    prim = stage.GetPrimAtPath("/Skeleton")
    return read_limits(prim, read_skeleton(prim))


def test_no_limits() -> None:
    assert read_text("") == ()


def test_limits_by_channel() -> None:
    body = "double2 mtex:limits:Leg:rx = (-10, 120)\ndouble2 mtex:limits:Leg:rz = (0, 0)"
    (limit,) = read_text(body)
    assert limit.joint == 1
    np.testing.assert_array_equal(limit.lower, [-10.0, -np.inf, 0.0])
    np.testing.assert_array_equal(limit.upper, [120.0, np.inf, 0.0])
    np.testing.assert_array_equal(limit.axes, [1.0, 0.0, 0.0, 0.0])


def test_limits_about_their_own_axes() -> None:
    stage = open_text(SKELETON.format(body="double2 mtex:limits:Leg:rx = (-10, 120)"))
    prim = stage.GetPrimAtPath("/Skeleton")
    axes = np.array([[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]])
    data = Vt.QuatdArray.FromNumpy(np.ascontiguousarray(axes[:, [1, 2, 3, 0]]))
    prim.SetCustomDataByKey("mtex:limitAxes", data)
    (limit,) = read_limits(prim, read_skeleton(prim))
    np.testing.assert_array_equal(limit.axes, axes[1])


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("double2 mtex:limits:Arm:rx = (0, 1)", r"mtex:limits:Arm:rx limits nothing; .*Hips, Leg"),
        ("double2 mtex:limits:Leg:tx = (0, 1)", r"mtex:limits:Leg:tx limits nothing"),
        ("double2 mtex:limits:Leg:rx = (1, 0)", r"mtex:limits:Leg:rx is no range; expected double2, lower and upper"),
        ("double mtex:limits:Leg:rx = 1", r"mtex:limits:Leg:rx is no range"),
        ("double2 mtex:limits:Leg:rx = (nan, 1)", r"mtex:limits:Leg:rx is no range"),
    ],
)
def test_bad_limits(body: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_text(body)


def test_limits_come_back_from_an_asf_import(tmp_path: Path, data_dir: Path) -> None:
    library = tmp_path / "takes.usd"
    mtex_usd.import_takes([data_dir / "cmu_asfamc" / "91" / "91_02.amc"], out=library)
    stage = Usd.Stage.Open(str(library))
    prim = next(prim for prim in stage.Traverse() if prim.IsA("Skeleton"))
    skeleton = read_skeleton(prim)
    limits = {skeleton.joints[limit.joint].rpartition("/")[2]: limit for limit in read_limits(prim, skeleton)}
    np.testing.assert_array_equal(limits["lfemur"].lower, [-160.0, -70.0, -60.0])
    np.testing.assert_array_equal(limits["lfemur"].upper, [20.0, 70.0, 70.0])
    assert quaternion.angle_between(limits["lfemur"].axes, np.array([1.0, 0.0, 0.0, 0.0])) > 0.1
