"""Take the pictures of the README from the explorer itself.

    python docs/images/explorer.py results/best

starts the viewer on a result folder, looks at it with Chromium (`pip install playwright pillow`, `apt-get install
chromium`), and writes beside this file:

* press.gif: a press in 3-D beside what the camera sees;
* explorer.png, compare.png, design.png: the pages.
"""

import io
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont
from playwright.sync_api import Page, sync_playwright

HERE = Path(__file__).parent
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
READY = "document.querySelectorAll('.camera-view .dots circle').length > 0"
POSE = "metric=rmse_jitter_deg&tilt=9&azimuth=25&depth={depth}"
COMPARE = "tilt=9&azimuth=25&depth=5.6&colour=stress&design=1&other=5"
IMAGES, PER_S, COLOURS = 26, 12, 240
HEIGHT = 300
"""Pixels of the animation; wide enough for a README, small enough to load at once."""


def main() -> None:
    """Start the viewer, take every picture, stop it."""
    words = [sys.executable, "-c", "from palpate.cli import main; main()", "view", sys.argv[1], "--port", "0"]
    server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    try:
        link = server.stdout.readline().removeprefix("Open ").strip()
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            take_pages(page, link)
            take_press(page, link)
            browser.close()
    finally:
        server.terminate()


def take_pages(page: Page, link: str) -> None:
    """The explorer with one design and with two, and the design page."""
    for name, query in (("explorer", "?" + POSE.format(depth=5.6)), ("compare", "?" + COMPARE), ("design", "design")):
        page.goto(link + query)
        page.wait_for_function(READY)
        page.wait_for_timeout(4000)  # the resting picture has smooth edges
        picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        picture.quantize(COLOURS, palette=picture.quantize(COLOURS)).save(HERE / f"{name}.png", optimize=True)


def take_press(page: Page, link: str) -> None:
    """A press, down and up, as an animation."""
    page.set_viewport_size({"width": 1280, "height": 800})
    page.goto(link + "?" + POSE.format(depth=0) + "&wall=1")
    page.wait_for_function(READY)
    page.add_style_tag(content=".dome-legend, .views { display: none !important } .dome-view { border-radius: 0 }")
    page.wait_for_timeout(1000)
    pictures = []
    deepest = float(page.locator(".pose-bar input[name=depth]").get_attribute("max") or 8)
    for i in range(IMAGES):
        depth = deepest * (1 - abs(1 - 2 * i / IMAGES))
        page.locator(".pose-bar input[name=depth]").fill(f"{depth:.2f}")
        page.wait_for_timeout(350)
        pictures.append(beside(page, depth))
    palette = pictures[IMAGES // 2].quantize(COLOURS)
    drawn = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    drawn[0].save(
        HERE / "press.gif",
        save_all=True,
        append_images=drawn[1:],
        duration=1000 // PER_S,
        loop=0,
        optimize=True,
    )


def beside(page: Page, depth: float) -> Image.Image:
    """The dome, and right of it what the camera sees, with the depth."""
    parts = []
    for place in (".dome-view", ".camera-view"):
        picture = Image.open(io.BytesIO(page.locator(place).first.screenshot())).convert("RGB")
        if place == ".dome-view":
            picture = picture.crop((0, int(picture.height * 0.16), picture.width, int(picture.height * 0.86)))
        parts.append(
            picture.resize((round(picture.width * HEIGHT / picture.height), HEIGHT), Image.Resampling.LANCZOS)
        )
    whole = Image.new("RGB", (sum(part.width for part in parts) + 8, HEIGHT), "white")
    whole.paste(parts[0], (0, 0))
    whole.paste(parts[1], (parts[0].width + 8, 0))
    font = ImageFont.load_default(15)
    ImageDraw.Draw(whole).text((12, 10), f"depth {depth:.1f} mm", fill="#1f2933", font=font)
    ImageDraw.Draw(whole).text((parts[0].width + 20, 10), "the camera below", fill="#1f2933", font=font)
    return whole


if __name__ == "__main__":
    main()
