"""One damaged file each: made from a seed, read, and judged."""

import contextlib
import io
import random
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from mtex_usd.cli.usdmtex_import import main as run_import
from mtex_usd.errors import MtexError
from mtex_usd.formats.amc import read_amc
from mtex_usd.formats.asf import read_asf
from mtex_usd.formats.bvh import read_bvh
from mtex_usd.formats.detect import detect_format
from mtex_usd.formats.gltf import read_gltf
from mtex_usd.formats.recording import Recording
from mtex_usd.importing import list_takes
from mtex_usd.usd.take_library import TakeLibrary
from mtex_usd.usd.usd_process import UsdReader
from mtex_usd.usd.usd_takes import read_usd
from tests.fuzz.corpus import KNOWN_GOOD, USD_KINDS, Specimen, collect
from tests.fuzz.mutations import mutate

__all__ = ["Case", "DefectError", "close_stages", "import_case", "make_case", "measure", "read_case", "read_usd_here"]

_LONGEST_MESSAGE = 2000


class DefectError(Exception):
    """A reader gave something that it must not."""


@dataclass(frozen=True)
class Case:
    """A damaged file.

    Parameters
    ----------
    kind, seed, number
        Which it is: the same three make the same file.
    specimen
        What it was before.
    content
        What it is now.
    """

    kind: str
    seed: int
    number: int
    specimen: Specimen
    content: bytes

    def write(self, folder: Path) -> Path:
        """Write the file and what lies beside it; give the file that a user would import."""
        for name, content in self.specimen.companions.items():
            (folder / name).write_bytes(content)
        damaged = folder / f"damaged.{self.kind}"
        damaged.write_bytes(self.content)
        return damaged


@cache
def _specimens(kind: str) -> tuple[Specimen, ...]:
    return collect(kind)


def make_case(kind: str, seed: int, number: int) -> Case:
    """Make a damaged file."""
    rng = random.Random(f"{kind}/{seed}/{number}")
    specimen = rng.choice(_specimens(kind))
    return Case(kind, seed, number, specimen, mutate(specimen.content, kind, rng))


def read_case(case: Case, folder: Path) -> bool:
    """Read a damaged file and put what it gives into a library; tell whether anything could be read.

    Raises
    ------
    DefectError
        Where the result or the message is none that users should see; any other exception is a defect as well.
    """
    damaged = case.write(folder)
    try:
        detect_format(damaged)
    except MtexError as error:
        _check_message(error)
    try:
        recordings, failures = _READERS[case.kind](damaged)
    except MtexError as error:
        _check_message(error)
        return False
    for failure in failures:
        _check_message(failure)
    for recording in recordings:
        _check_recording(recording)
        TakeLibrary(meters_per_unit=0.01).add(recording)
    return bool(recordings)


def _read_text(
    reader: Callable[[Path], Recording],
) -> Callable[[Path], tuple[Sequence[Recording], Sequence[MtexError]]]:
    return lambda damaged: ((reader(damaged),), ())


def _read_skeleton(damaged: Path) -> tuple[Sequence[Recording], Sequence[MtexError]]:
    read_asf(damaged)
    return (read_amc(damaged.with_name("take.amc"), skeleton=damaged),), ()


_STAGES = UsdReader()


def _read_stage(damaged: Path) -> tuple[Sequence[Recording], Sequence[MtexError]]:
    takes = _STAGES.read(damaged)
    return takes.recordings, takes.failures


def _read_stage_here(damaged: Path) -> tuple[Sequence[Recording], Sequence[MtexError]]:
    takes = read_usd(damaged)
    return takes.recordings, takes.failures


_READERS: dict[str, Callable[[Path], tuple[Sequence[Recording], Sequence[MtexError]]]] = {
    "bvh": _read_text(read_bvh),
    "asf": _read_skeleton,
    "amc": _read_text(read_amc),
    "gltf": lambda damaged: (read_gltf(damaged), ()),
    "glb": lambda damaged: (read_gltf(damaged), ()),
    "usda": _read_stage,
    "usdc": _read_stage,
    "usdz": _read_stage,
}


def close_stages() -> None:
    """End the process that reads stages."""
    _STAGES.close()


def read_usd_here() -> None:
    """Read stages in this process from now on, without what protects it, to see what USD does alone."""
    _READERS.update(dict.fromkeys(USD_KINDS, _read_stage_here))


def _check_message(error: MtexError) -> None:
    message = str(error)
    if not message.strip() or len(message) > _LONGEST_MESSAGE or "Traceback" in message:
        raise DefectError(f"no message for users: {message[:300]!r}, {len(message)} characters") from error


def _check_recording(recording: Recording) -> None:
    joints, frames = len(recording.names), recording.frame_count
    shapes = {
        "rotations": (frames, joints, 4),
        "translations": (frames, joints, 3),
        "scales": (frames, joints, 3),
        "rest": (joints, 4, 4),
        "bind": (joints, 4, 4),
        "offsets": (joints, 3),
    }
    for name, shape in shapes.items():
        values = getattr(recording, name)
        if values is None:
            continue
        if values.shape != shape:
            raise DefectError(f"{name} have shape {values.shape}, expected {shape}")
        with np.errstate(over="ignore"):
            kept = values.astype(np.float16 if name == "scales" else np.float32)
        if not np.all(np.isfinite(kept)):
            raise DefectError(f"{name} are not finite in the precision that USD keeps")
    _check_frames(recording)


def _check_frames(recording: Recording) -> None:
    if recording.frame_count < 1 or not recording.names:
        raise DefectError(f"{recording.frame_count} frames of {len(recording.names)} joints")
    if not all(-1 <= parent < joint for joint, parent in enumerate(recording.parents)):
        raise DefectError("a parent comes after its child")
    if not np.allclose(np.linalg.norm(recording.rotations, axis=-1), 1.0, atol=1e-5):
        raise DefectError("a rotation is not of unit length")
    if not (np.isfinite(recording.rate) and recording.rate > 0.0):
        raise DefectError(f"rate {recording.rate}")


def import_case(case: Case, folder: Path) -> bool:
    """Import a damaged file by the command, alone and beside a good one; tell whether anything of it was read."""
    damaged = case.write(folder)
    motion = folder / "take.amc" if case.kind == "asf" else damaged
    options = ["--skeleton", str(damaged)] if case.kind == "asf" else []
    before = {path.name for path in folder.iterdir()}
    alone, beside = folder / "alone.usd", folder / "beside.usd"
    code = _run_command([str(motion), *options, "-o", str(alone)])
    if code not in {0, 2}:
        raise DefectError(f"exit code {code}")
    if code == 0 and not list_takes(alone):
        raise DefectError("exit code 0 and no take")
    if code == 2 and alone.exists() and not list_takes(alone):
        raise DefectError("exit code 2 and an empty library")
    good = folder / "known_good.bvh"
    good.write_text(KNOWN_GOOD)
    both = _run_command([str(motion), str(good), *options, "-o", str(beside)])
    if both != code:
        raise DefectError(f"exit code {code} alone and {both} beside a good file")
    if "/Takes/known_good" not in {entry.prim_path for entry in list_takes(beside)}:
        raise DefectError("the good file is lost")
    left = {path.name for path in folder.iterdir()} - before - {"alone.usd", "beside.usd", "known_good.bvh"}
    if left:
        raise DefectError(f"left behind: {sorted(left)}")
    return code == 0


def _run_command(arguments: list[str]) -> int:
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        code = run_import([*arguments, "--quiet"])
    if "Traceback" in said.getvalue():
        raise DefectError(f"the command shows a traceback: {said.getvalue()[-1500:]}")
    return code


def measure(function: Callable[[Case, Path], bool], case: Case, folder: Path) -> tuple[bool, float, int]:
    """Give what a function gives, its seconds, and by how many bytes memory grew at its peak."""
    _reset_peak()
    before, start = _peak(), time.perf_counter()
    found = function(case, folder)
    return found, time.perf_counter() - start, max(0, _peak() - before)


def _watched() -> list[Path]:
    """Give where the system shows this process and the one that reads stages."""
    processes = ("self", _STAGES.process_id)
    return [Path(f"/proc/{process}") for process in processes if process is not None]


def _reset_peak() -> None:
    for process in _watched():
        with contextlib.suppress(OSError):
            (process / "clear_refs").write_text("5")


def _peak() -> int:
    """Give the most memory the processes have held, in bytes, since the reset where the system has one."""
    try:
        lines = [line for process in _watched() for line in (process / "status").read_text().splitlines()]
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return sum(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM"))
