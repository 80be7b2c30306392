"""The moving picture of a run as a video, which ffmpeg writes.

matplotlib's writer starts ffmpeg and hands it the pictures; nobody keeps a better encoder, and no Python package of its
size has one.
"""

from __future__ import annotations

from pathlib import Path
from subprocess import CalledProcessError
from tempfile import TemporaryDirectory
from typing import Any

from ..extras import needed
from ..files import write_whole
from ..record.record import Record
from .gif import drawn_frames

RATE = 30  # frames per second, in real time
PIXELS = 960  # the longer side
PURPOSE = "a video"
SAME_BYTES = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-threads", "1", "-f", "mp4"]
"""For ffmpeg: neither its version nor how many processors there are is seen in the file."""


def no_ffmpeg() -> str:
    """What is missing for videos; empty where ffmpeg is there."""
    if needed("matplotlib.animation", PURPOSE).FFMpegWriter.isAvailable():
        return ""
    return (
        "found no ffmpeg on PATH, expected the program that writes videos; install it (apt install ffmpeg, "
        "brew install ffmpeg), or write a .gif"
    )


def write_video(run: Record, path: Path) -> Path:
    """Write the motion to `path` as H.264 in MP4, in real time, with each impact glowing where it strikes.

    Raises ``OSError`` where ffmpeg is not on PATH or cannot do it.
    """
    animation: Any = needed("matplotlib.animation", PURPOSE)
    if missing := no_ffmpeg():
        raise FileNotFoundError(f"video: {missing}")
    pictures = drawn_frames(run, RATE, PIXELS, PURPOSE)
    figure = next(pictures)
    with TemporaryDirectory() as folder:
        made = Path(folder) / "video.mp4"
        writer = animation.FFMpegWriter(fps=RATE, codec="h264", extra_args=SAME_BYTES)
        try:
            with writer.saving(figure, str(made), dpi=figure.dpi):
                for _ in pictures:
                    writer.grab_frame()
        except (CalledProcessError, BrokenPipeError) as error:
            raise OSError(f"ffmpeg cannot write a video here: {error}; try ffmpeg -codecs, or write a .gif") from error
        write_whole(path, lambda part: part.write(made.read_bytes()))
    return path
