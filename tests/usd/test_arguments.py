"""What Python callers are likely to get wrong: taken where it is plain, else refused in words."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd

import mtex_usd
from mtex_usd.errors import InputError
from mtex_usd.motion.arguments import as_number, as_whole_number
from mtex_usd.usd.arguments import as_file_path, as_prim_path

SAMPLES = Path(__file__).resolve().parents[2] / "sample_stages"
SKETCH = "/Humanoid/Sketch"


@pytest.fixture
def shot(tmp_path: Path) -> Path:
    for name in ("humanoid.usda", "takes.usda", "walk.usda"):
        shutil.copy(SAMPLES / name, tmp_path)
    return tmp_path / "walk.usda"


@pytest.mark.parametrize("anim", [SKETCH, Sdf.Path(SKETCH), [SKETCH], (Sdf.Path(SKETCH),)])
def test_one_sketch_may_be_given_as_it_is(shot: Path, anim: object) -> None:
    (result,) = mtex_usd.process(str(shot), anim=anim, paths=np.int64(2), dry_run=True)
    assert (result.anim, len(result.variants)) == (SKETCH, 2)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"anim": 5}, "bad anim; expected the path of a prim; found 5"),
        ({"anim": [None]}, "bad anim; expected the path of a prim; found None"),
        ({"paths": True}, "bad paths; expected a whole number of at least 1; found True"),
        ({"paths": 2.0}, r"bad paths; expected a whole number of at least 1; found 2\.0"),
        ({"paths": "5"}, "bad paths; expected a whole number of at least 1; found '5'"),
        ({"candidates": 0}, "bad candidates; expected a whole number of at least 1; found 0"),
        ({"out": ""}, "bad out; expected the path of a file; found ''"),
        ({"out": 5}, "bad out; expected the path of a file; found 5"),
        ({"select": 3}, "gets no variant 3; expected one of original, path_01"),
    ],
)
def test_options_of_process(shot: Path, options: dict[str, object], reason: str) -> None:
    before = sorted(shot.parent.iterdir())
    with pytest.raises(InputError, match=reason):
        mtex_usd.process(shot, **{"paths": 1} | options)
    assert sorted(shot.parent.iterdir()) == before


def test_process_takes_no_open_stage(shot: Path) -> None:
    with pytest.raises(InputError, match="bad stage; expected the path of a file; found a Stage"):
        mtex_usd.process(Usd.Stage.Open(str(shot)))
    with pytest.raises(InputError, match="bad stage; expected the path of a file; found ''"):
        mtex_usd.process("")


def test_clips_by_sdf_path(shot: Path, tmp_path: Path) -> None:
    clip = mtex_usd.read_clip(shot, Sdf.Path(SKETCH))
    written = mtex_usd.write_clip(clip, str(tmp_path / "clip.usd"), Sdf.Path("/Takes/walk"))
    assert written == "/Takes/walk"
    with pytest.raises(InputError, match="bad prim_path; expected the path of a prim; found a Prim"):
        mtex_usd.read_clip(shot, Usd.Stage.Open(str(shot)).GetPrimAtPath(SKETCH))
    with pytest.raises(InputError, match="bad file_path; expected the path of a file; found a Stage"):
        mtex_usd.write_clip(clip, Usd.Stage.CreateInMemory(), "/walk")
    with pytest.raises(InputError, match="bad stage or file; expected the path of a file; found a Clip"):
        mtex_usd.read_clip(clip, "/walk")


@pytest.mark.parametrize("wrap", [str, Path, lambda file_path: [str(file_path)]])
def test_one_file_may_be_imported_as_it_is(shot: Path, tmp_path: Path, wrap: object) -> None:
    result = mtex_usd.import_takes(wrap(shot.with_name("takes.usda")), out=tmp_path / "library.usd")
    assert len(result.takes) == 5


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"meters_per_unit": "x"}, "bad metres per unit; expected a finite number above 0; found 'x'"),
        ({"meters_per_unit": None}, "bad metres per unit; expected a finite number above 0; found None"),
        ({"skip_frames": 1.5}, r"bad number of frames to skip; expected a whole number of at least 0; found 1\.5"),
        ({"rate": "120"}, "bad rate; expected frames per second from 0.001 to 100000; found '120'"),
        ({"style": 5}, "bad style; expected a text; found 5"),
        ({"licence": b"x"}, "bad licence; expected a text; found b'x'"),
        ({"out": None}, "bad out; expected the path of a file; found None"),
    ],
)
def test_options_of_import_takes(shot: Path, tmp_path: Path, options: dict[str, object], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        mtex_usd.import_takes(shot.with_name("takes.usda"), **{"out": tmp_path / "library.usd"} | options)
    assert not (tmp_path / "library.usd").exists()


def test_numbers_and_paths_come_back_as_pythons_own() -> None:
    assert (as_number(np.float32(0.5), "x"), as_number(3, "x")) == (0.5, 3.0)
    assert type(as_whole_number(np.int16(3), "x", least=1)) is int
    assert as_prim_path(Sdf.Path("/A"), "x") == "/A"
    assert as_file_path("a", "x") == Path("a")
    for bad in (0.0, -1.0, np.nan, np.inf, True):
        with pytest.raises(InputError, match="bad x; expected a finite number above 0"):
            as_number(bad, "x")
