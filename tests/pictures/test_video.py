"""Videos of runs: by ffmpeg, where it is."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from ccgen.runtime.pictures import video

from ..support.rigid_polygon import bouncing


def test_a_video_is_written_the_same_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    if shutil.which("ffmpeg") is None:
        pytest.skip("no ffmpeg on PATH: apt install ffmpeg")
    monkeypatch.setattr(video, "PIXELS", 240)
    run = bouncing(until=0.2)
    first, again = (run.save_video(tmp_path / name).read_bytes() for name in ("a.mp4", "b.mp4"))
    assert first == again and first[4:8] == b"ftyp" and b"avc1" in first
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mp4", "b.mp4"]


def test_what_is_missing_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError, match=r"video: found no ffmpeg on PATH, expected .*; install it"):
        bouncing(until=0.1).save_video(tmp_path / "a.mp4")
    with pytest.raises(ValueError, match=r"a video is saved as \.mp4, found 'a\.avi'"):
        bouncing(until=0.1).save_video(tmp_path / "a.avi")
    assert not list(tmp_path.iterdir())
