"""The player as a person meets it, in a headless browser: what is on the page after what is done to it.

Needs playwright and Chromium (CONTRIBUTING.md); skipped without them.
"""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ccgen.runtime import Run, simulate

from ..support.rigid_polygon import bouncing
from ..support.touching_scenes import cradle
from ..support.workshop import Workshop

pytestmark = pytest.mark.slow

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
WIDE, NARROW = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
WIDEST_WORDS = """(() => {
  const follow = document.getElementById("follow"), style = getComputedStyle(follow);
  const brush = document.createElement("canvas").getContext("2d");
  brush.font = style.font;
  const words = brush.measureText(follow.options[0].label).width;
  return words + parseFloat(style.paddingLeft) + parseFloat(style.paddingRight) + 12;  // and the arrow of the list
})()"""
"""How wide the list of what is followed has to be for its first entry."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install 'ccgen[browser]'"
    )
    if CHROMIUM is None:
        pytest.skip("no chromium on PATH: apt install chromium")
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture(scope="module")
def falling(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bouncing().animate(tmp_path_factory.mktemp("falling") / "falling.html")


@pytest.fixture(scope="module")
def swinging(workshop: Workshop) -> Run:
    return simulate(workshop.model(cradle(3, 0.0)), until=1.0)


class Page:
    """A page in a window of its own; what goes wrong in it fails the test."""

    def __init__(self, browser: Any, file: Path, at: str = "t=0", size: dict[str, int] = WIDE, **options: Any) -> None:
        self.context = browser.new_context(viewport=size, **options)
        self.page = self.context.new_page()
        self.faults: list[str] = []
        self.asked: list[str] = []
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("console", lambda message: self.faults.append(message.text) if message.type == "error" else None)
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(f"{file.as_uri()}#{at}")

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: object) -> None:
        self.context.close()
        assert self.faults == []

    def of(self, script: str) -> Any:
        """The value of an expression of the page's."""
        return self.page.evaluate(script)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def text(self, name: str) -> str:
        return str(self.page.inner_text(f"#{name}"))

    @property
    def time(self) -> float:
        return float(self.of("time"))

    @property
    def middle(self) -> tuple[int, int]:
        """The pixel in the middle of the picture on the screen."""
        box = self.page.locator("#canvas").bounding_box()
        return round(box["x"] + box["width"] / 2), round(box["y"] + box["height"] / 2)

    def world(self, x: float, y: float) -> list[float]:
        """What place of the plane is at this place of the window."""
        box = self.page.locator("#canvas").bounding_box()
        x, y = x - box["x"], y - box["y"]
        return list(self.of(f"[centre[0] + ({x} - width / 2) / scale, centre[1] - ({y} - height / 2) / scale]"))


def test_it_plays_pauses_and_steps(browser: Any, falling: Path) -> None:
    with Page(browser, falling, "") as page:
        assert page.of("playing")  # at once
        page.page.wait_for_function("time > 0.1")
        page.press("Space")
        stopped = page.time
        assert not page.of("playing") and page.text("play").endswith("Play")
        page.press("ArrowRight")
        assert page.time > stopped and page.time in page.of("run.t")
        page.press("ArrowLeft", "ArrowLeft")
        assert page.time <= stopped
        page.press("End")
        assert page.time == 1.25 and page.text("clock") == "t = 1.2500 s"
        page.press("Home")
        assert page.time == 0.0 and page.asked == [page.page.url.partition("#")[0]]  # nothing from elsewhere


def test_a_run_of_one_row_is_shown(browser: Any, workshop: Workshop, tmp_path: Path) -> None:
    """No fault of the page, and numbers on it, where no time passes."""
    run = simulate(workshop.model(cradle(3, 0.0)), until=0.0)
    for at in ("", "t=0"):
        with Page(browser, run.animate(tmp_path / "start.html"), at) as page:
            page.press("Space", "ArrowRight", "ArrowLeft", "End", "Home")
            assert page.time == 0.0 and page.text("clock") == "t = 0.0000 s"
            assert "NaN" not in page.page.inner_text("body")


def test_keys_of_impacts_and_speed(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        first = page.of("run.impacts[0].t")
        page.press("]")
        assert page.time == first and page.text("event").startswith("impact 1 of 4 at t = ")
        page.press("]", "[")
        assert page.time == first
        page.press(",")
        assert page.of("speed") == 0.5 and page.page.input_value("#speed") == "0.5"
        page.press(".", ".")
        assert page.of("speed") == 2


PENDULUM = """
name = "pendulum"
[chain]
links = 1
hinged = true
[gravity]
[[event]]
name = "early"
when = "t - 0.25"
set = { "gravity.g" = 5 }
[[event]]
name = "later"
when = "t - 0.75"
[run]
until = 1
"""


def test_events_have_marks_with_names_and_are_gone_to(browser: Any, workshop: Workshop, tmp_path: Path) -> None:
    run = simulate(workshop.model(PENDULUM))
    with Page(browser, run.animate(tmp_path / "events.html")) as page:
        assert page.text("event") == "" and page.page.locator("#marks").is_visible()
        page.press("]")
        assert page.time == 0.25
        assert page.text("event") == "event early, rising, at t = 0.250000 s: gravity.g from 9.81 to 5"
        page.press("]")
        assert page.time == 0.75 and page.text("event") == "event later, rising, at t = 0.750000 s"
        page.press("]", "[")
        assert page.time == 0.25
        box = page.page.locator("#marks").bounding_box()
        page.page.mouse.click(box["x"] + 0.75 * box["width"] + 5, box["y"] + 5)
        assert page.time == 0.75
        page.page.mouse.move(box["x"] + 0.25 * box["width"] - 5, box["y"] + 5)
        assert page.of("marks.title").startswith("event early, rising, ")
        row = "[...markPen.getImageData(0, 4, marks.width, 1).data].filter((_, k) => k % 4 === 3)"
        inked = [k / len(found) for found in [page.of(row)] for k, ink in enumerate(found) if ink > 100]
        for t in (0.25, 0.75):  # a wedge, and a name beside it
            assert any(abs(k - t) < 0.002 for k in inked) and any(t + 0.005 < k < t + 0.03 for k in inked)


def test_zoom_keeps_the_place_under_the_pointer(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        x, y = page.middle[0] + 150, page.middle[1] - 90
        before, scale = page.world(x, y), page.of("scale")
        page.page.mouse.move(x, y)
        page.page.mouse.wheel(0, -300)
        page.page.wait_for_function(f"scale > {scale}")
        assert page.of("scale") == pytest.approx(scale * math.exp(0.45))
        assert page.world(x, y) == pytest.approx(before, abs=1e-9)
        page.page.mouse.dblclick(x, y)
        assert page.of("[scale, ...view.shift]") == pytest.approx([scale, 0, 0])
        page.press("+")
        page.page.click("#closer")
        assert page.of("scale") == pytest.approx(1.69 * scale)
        page.press("-", "f")
        assert page.of("scale") == pytest.approx(scale)


def test_a_drag_moves_the_view_with_the_pointer(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        x, y = page.middle
        held = page.world(x, y)
        page.page.mouse.move(x, y)
        page.page.mouse.down()
        page.page.mouse.move(x + 60, y - 45, steps=3)
        page.page.mouse.up()
        assert page.world(x + 60, y - 45) == pytest.approx(held, abs=1e-9)
        page.page.mouse.move(x, y)  # let go
        assert page.world(x + 60, y - 45) == pytest.approx(held, abs=1e-9)


def test_two_fingers_zoom_and_move(browser: Any, falling: Path) -> None:
    with Page(browser, falling, size=NARROW, has_touch=True, is_mobile=True) as page:
        x, y = page.middle
        scale, held = page.of("scale"), page.world(x, y)
        touch = page.context.new_cdp_session(page.page)

        def fingers(kind: str, *places: tuple[float, float]) -> None:
            points = [{"x": a, "y": b, "id": k} for k, (a, b) in enumerate(places)]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        fingers("touchStart", (x - 40, y), (x + 40, y))
        for part in (0.25, 0.5, 0.75, 1.0):
            fingers("touchMove", (x - 40 - 40 * part, y + 30 * part), (x + 40 + 40 * part, y + 30 * part))
        fingers("touchEnd")
        page.page.wait_for_function("!pointers.size")
        assert page.of("scale") == pytest.approx(2 * scale, rel=1e-6)
        assert page.world(x, y + 30) == pytest.approx(held, abs=1e-6)


def test_the_view_follows_a_link(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        page.page.select_option("#follow", label="link_2")
        for t in (0.0, 0.3, 1.1):
            page.of(f"seek({t})")
            assert page.of("centre") == pytest.approx(page.of("placed(blend(run.poses, time), 2, [0.5, 0])"))
        assert page.of("scale") > page.of("fitting()")  # nearer: the mechanism fills the window
        page.press("l")
        assert page.of("view.follow") == 3
        page.press("L", "L", "L", "L")
        assert page.of("view.follow") == -1 and page.page.input_value("#follow") == "-1"


def test_points_are_traced(browser: Any, swinging: Run, tmp_path: Path) -> None:
    """A tip's way is where the run says that the point is; the list offers points, joints and mass centres."""
    file = swinging.animate(tmp_path / "a.html")
    with Page(browser, file, "t=0.8") as page:
        page.page.click("#trace")
        names = page.page.locator("#list label").all_inner_texts()
        assert {"ball_0.C", "hook_1", "mass centre of ball_2", "mass centre of all"} <= {n.strip() for n in names}
        page.page.check("#list input[value='ball_0.C']")
        page.page.check("#list input[value='mass centre of all']")
        page.page.click("#done")
        assert page.of("traced") == ["ball_0.C", "mass centre of all"] and page.text("trace") == "Trace (2)"
        end = page.of("wayOf('ball_0.C')")[-1]
        assert end == pytest.approx(swinging.point("ball_0.C", 0.8).position, abs=1e-4)
        centres = [swinging.point(f"ball_{k}.C", 0.8).position for k in range(3)]
        assert page.of("wayOf('mass centre of all')")[-1] == pytest.approx(sum(centres) / 3, abs=1e-4)
        page.press("t")
        assert len(page.of("traced")) <= 1


def test_outputs_are_chosen_and_read(browser: Any, swinging: Run, tmp_path: Path) -> None:
    file = swinging.save_player(tmp_path / "a.html", ["ball_0.angle", "hook_0.force"])
    with Page(browser, file, "t=0.15") as page:
        found = page.page.locator("#values > span").all_inner_texts()
        expected = swinging.values("ball_0.angle", "hook_0.force", t=0.15)
        for text, (name, value), unit in zip(found, expected.items(), ("rad", "N"), strict=True):
            shown, _, number = text.partition(" = ")
            assert (shown.strip(), number.split(" ", 1)[1]) == (name, unit)
            assert float(number.split()[0]) == pytest.approx(float(value), rel=2e-3)
        assert page.of("strips.map(strip => strip.unit)") == ["rad", "N"]
        page.press("p")
        page.page.fill("#search", "ball_1.angular")
        assert page.page.locator("#list label:visible").count() == 1
        page.page.check("#list input[value='ball_1.angular_velocity']")
        page.page.click("#done")
        assert page.of("plotted") == ["ball_0.angle", "hook_0.force", "ball_1.angular_velocity"]
        assert page.of("strips.length") == 3


def test_one_time_has_one_energy(browser: Any, falling: Path) -> None:
    """What stands above the motion is what stands below it, between frames and at impacts too."""
    with Page(browser, falling, "plot=energy,kinetic_energy,potential_energy") as page:
        page.of("playing = false")
        for t in (0.0, 0.2113, 0.4997, 0.5, page.of("run.impacts[0].t"), 1.0, 1.25):
            page.of(f"seek({t})")
            told = dict(re.findall(r"(\w+) = (\S+) J", page.text("values")))
            above = re.findall(r"-?\d[\d.e+-]*", page.text("energy"))
            assert above == [told["energy"], told["kinetic_energy"], told["potential_energy"]]


def test_the_chart_goes_to_a_time(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        box = page.page.locator("#chart").bounding_box()
        left, wide = box["x"] + page.of("SIDE.left"), box["width"] - page.of("SIDE.left + SIDE.right")
        page.page.mouse.move(left + 0.25 * wide, box["y"] + 30)
        page.page.mouse.down()
        assert page.time == pytest.approx(0.25 * 1.25, abs=2e-3)
        page.page.mouse.move(left + 0.5 * wide, box["y"] + 30)
        page.page.mouse.up()
        assert page.time == pytest.approx(0.5 * 1.25, abs=2e-3)
        page.page.mouse.move(left, box["y"] + 30)
        assert page.time > 0.6


def test_impacts_flash_where_they_strike_as_large_as_they_are(browser: Any, swinging: Run, tmp_path: Path) -> None:
    """Of touching discs between them; what is no impulse does not flash."""
    file = swinging.animate(tmp_path / "a.html")
    with Page(browser, file) as page:
        strike = page.of("run.impacts[0].t")
        flashes = page.of(f"flashesAt({strike})")
        assert len(flashes) == sum(impulse > 1e-9 for impulse in swinging.impacts[0].impulses) > 0
        for flash in flashes:
            number = int(flash["point"][5])
            places = [swinging.point(f"ball_{number + k}.C", swinging.impacts[0].t).position for k in (0, 1)]
            assert flash["at"] == pytest.approx(sum(places) / 2, abs=1e-4)
        page.of("run.impacts[0].contacts.forEach(contact => { contact.impulse = 0; })")
        page.of("weighImpacts()")
        assert page.of(f"flashesAt({strike})") == []


def test_larger_impulses_have_larger_marks(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        impulses = page.of("run.impacts.map(impact => impact.contacts[0].impulse)")
        sizes = page.of("run.impacts.map(impact => flashesAt(impact.t).at(-1).radius)")
        assert sorted(range(4), key=impulses.__getitem__) == sorted(range(4), key=sizes.__getitem__)
        assert len(set(sizes)) == 4


def test_help_lists_the_keys_and_closes(browser: Any, falling: Path) -> None:
    with Page(browser, falling) as page:
        page.press("?")
        assert page.page.is_visible("#help") and page.page.locator("#keys tr").count() >= 15
        page.press("Escape")
        assert not page.page.is_visible("#help")
        page.press("d")
        assert page.of("document.documentElement.classList.contains('dark')")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_on_a_telephone(browser: Any, falling: Path, scheme: str) -> None:
    with Page(browser, falling, size=NARROW, is_mobile=True, has_touch=True, color_scheme=scheme) as page:
        assert page.of("document.documentElement.scrollWidth") <= 390
        assert page.of("[...document.querySelectorAll('#bar > *')].every(e => e.getBoundingClientRect().right <= 390)")
        assert page.of(WIDEST_WORDS) <= page.of("document.getElementById('follow').clientWidth")  # none is cut off
        assert (
            page.of("height") > 250
            and page.of("document.querySelector('footer').getBoundingClientRect().bottom") <= 844
        )
        assert page.of("document.documentElement.classList.contains('dark')") == (scheme == "dark")


def test_frames_of_a_notebook_do_not_know_of_each_other(browser: Any, tmp_path: Path) -> None:
    """Two runs on one page, as a notebook shows them: each has its own time, and the page around its own keys."""
    file = tmp_path / "notebook.html"
    file.write_text(f"<!DOCTYPE html><h1>runs</h1>{bouncing()._repr_html_()}{bouncing(until=0.3)._repr_html_()}")
    with Page(browser, file, "") as page:
        one, other = page.page.frames[1:]
        one.wait_for_function("run.t.length > 0")
        other.wait_for_function("run.t.length > 0")
        assert one.evaluate("[framed, playing, last]") == [True, False, 1.25]
        one.evaluate("seek(0.7)")
        assert (one.evaluate("time"), other.evaluate("[time, last]")) == (0.7, [0, 0.3])
        assert page.of("typeof run") == "undefined"
