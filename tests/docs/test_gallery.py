"""The gallery's page is that of its table, its pictures are small, its answers those of independent computations."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from types import ModuleType

import pytest
from PIL import Image

from ccgen.generator import load_scene

from ..oracles.gallery import ANSWERS
from ..support.folders import ROOT

GALLERY = ROOT / "docs" / "gallery"
LONG = ("woodpecker", "five-bar", "three-rrr-circle")
"""Entries whose answers take seconds: tests/hard/test_gallery.py has them."""
BALANCES = ("chain-over-edge",)
"""Entries whose answer is a balance of the run."""


@pytest.fixture
def gallery(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """docs/scripts/gallery.py."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "scripts"))
    return importlib.import_module("gallery")


def test_the_page_is_current(gallery: ModuleType) -> None:
    page = (GALLERY / "index.md").read_text(encoding="utf-8")
    assert page == gallery.index(gallery.entries()), "run python docs/scripts/gallery.py --index"


def test_links_of_the_page_lead_somewhere() -> None:
    page = (GALLERY / "index.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)]+)\)", page)
    assert links and all((GALLERY / link).is_file() for link in links)


def test_every_entry_has_a_number_an_answer_and_a_scene_of_its_name(gallery: ModuleType) -> None:
    rows = gallery.entries()
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    assert set(names) == set(gallery.gallery_numbers.NUMBERS) == {*ANSWERS, *BALANCES}
    for row in rows:
        assert Path(row.scene).stem == row.name and row.question.rstrip(".").find("?") > 0
    own = {path.stem for path in (ROOT / "scenes" / "gallery").glob("*.toml")}
    assert own <= set(names), "a scene of the gallery that it does not show"


def test_pictures_move_and_are_small(gallery: ModuleType) -> None:
    sizes = []
    for row in gallery.entries():
        path = GALLERY / row.picture
        sizes.append(path.stat().st_size)
        with Image.open(path) as picture:
            assert getattr(picture, "n_frames", 1) > 20, row.name
    assert max(sizes) <= gallery.MOST and sum(sizes) <= 6_000_000
    assert {path.name for path in GALLERY.glob("*.gif")} == {row.picture for row in gallery.entries()}


@pytest.mark.parametrize("name", sorted(set(ANSWERS) - set(LONG)))
def test_answers_are_what_is_said(name: str, gallery: ModuleType) -> None:
    (row,) = [row for row in gallery.entries() if row.name == name]
    assert row.answer == pytest.approx(ANSWERS[name](), abs=row.within / 5.0)


@pytest.mark.sample(4)
@pytest.mark.parametrize("path", sorted((ROOT / "scenes" / "gallery").glob("*.toml")), ids=lambda path: path.stem)
def test_scenes_of_the_gallery_are_read_without_remarks(path: Path) -> None:
    scene = load_scene(path)
    assert scene.name == path.stem and not scene.remarks


def test_a_thinned_picture_lasts_as_long(gallery: ModuleType, tmp_path: Path) -> None:
    frames = [Image.new("RGB", (40, 30), "white") for _ in range(20)]
    for k, frame in enumerate(frames):
        frame.paste((200, 60, 0), (2 * k, 0, 2 * k + 2, 30))
    path = tmp_path / "a.gif"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=40, loop=0)
    gallery.thin(path, 4)
    with Image.open(path) as picture:
        assert picture.n_frames == 5 and picture.info["duration"] == 160
        for k in range(5):
            picture.seek(k)
            seen = picture.convert("RGB")
            assert seen.getpixel((8 * k, 9)) == (200, 60, 0) and seen.getpixel((8 * k + 4, 9)) == (255, 255, 255)
    with pytest.raises(ValueError, match=r"a\.gif: found more than 400000 bytes at 6 frames a second; show less of it"):
        gallery.thin(path, 2)


def test_a_slowed_clock_shows_the_same_motion(gallery: ModuleType) -> None:
    class Run:
        t = (0.0, 0.5, 2.0)
        impacts = ()
        model = None

        @staticmethod
        def at(t: float) -> float:
            return 10.0 * t

    shown = gallery.Shown(Run(), 3.0, True)
    assert list(shown.t) == [0.0, 1.5, 6.0]
    assert shown.at(3.0) == pytest.approx(10.0) and shown.at(6.0 + 1e-12) == 20.0
