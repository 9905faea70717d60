"""``usdmtex-import --clean``: steps by name, the report, and the exit code."""

import pytest

from mtex_usd.cli.usdmtex_import import main
from tests.cleaning_support import dirty_clip, write_bvh


@pytest.fixture
def source(tmp_path):
    return write_bvh(dirty_clip(), tmp_path / "walk.bvh")


def run(source, tmp_path, *options):
    return main([str(source), "-o", str(tmp_path / "takes.usda"), *options])


def test_auto_reports_what_it_changed_where(source, tmp_path, capsys):
    assert run(source, tmp_path, "--clean", "auto") == 0
    lines = capsys.readouterr().out.splitlines()
    assert "/Takes/walk\tcleaned\tleading: frame 0: taken off, the pose jumps after it" in lines
    assert any(line.startswith("/Takes/walk\tcleaned\tflips: LeftUpLeg frames 101-106: turned back") for line in lines)


def test_steps_by_name(source, tmp_path, capsys):
    assert run(source, tmp_path, "--clean", "leading, floor") == 0
    out = capsys.readouterr().out
    assert "leading: frame 0" in out
    assert "flips" not in out


def test_nothing_to_change_is_said(source, tmp_path, capsys):
    assert run(source, tmp_path, "--clean", "spikes") == 0
    assert "/Takes/walk\tcleaned\tnothing to change" in capsys.readouterr().out


def test_quiet_says_nothing(source, tmp_path, capsys):
    assert run(source, tmp_path, "--clean", "auto", "-q") == 0
    assert capsys.readouterr().out == ""


def test_unknown_step_is_exit_2(source, tmp_path, capsys):
    assert run(source, tmp_path, "--clean", "flip") == 2
    assert "unknown step of the clean-up: flip; expected auto or any of leading, gaps" in capsys.readouterr().err
    assert not (tmp_path / "takes.usda").exists()
