"""Steps on the viewer's pages that several tests take."""

DOTS = "document.querySelectorAll('.camera-view .dots circle')"
DRAWN = f"{DOTS}.length > 0"


def open_page(page, link, query=""):
    page.goto(link + query)
    page.wait_for_function(DRAWN)
    return page


def slide(page, name, value):
    """Move a slider of the pose bar as a person does, and wait for the next picture."""
    before = int(page.locator(".dome-view").first.get_attribute("data-drawn"))
    page.locator(f".pose-bar input[name={name}]").fill(str(value))
    page.wait_for_function(f"Number(document.querySelector('.dome-view').dataset.drawn) > {before}")


def choose(page, name, entry):
    """Choose an entry of a select; where it takes text, by typing."""
    box = page.get_by_test_id(name)
    box.click()
    if box.is_editable():
        box.fill(entry)
    page.get_by_role("option", name=entry, exact=True).click()


def fault(page, code, name="fault"):
    """Wait for an error of this code in its place; the sentence that is seen."""
    place = page.locator(f"[data-testid={name}][data-code~='{code}']:visible")
    place.wait_for()
    return place.inner_text()


def wait_for_state(page, state, **more):
    page.locator(f"[data-testid=status][data-state={state}]").wait_for(**more)


def numbers(page, name):
    """Numbers in the text of an element."""
    return page.evaluate(f"({_NUMBERS})('{name}')")


def wait_for_numbers(page, name, values):
    """Wait until the numbers in the text of an element are these."""
    page.wait_for_function(f"JSON.stringify(({_NUMBERS})('{name}')) === JSON.stringify({values})")


_NUMBERS = r"""name => [...document.querySelector(`[data-testid=${name}]`).textContent
    .matchAll(/-?\d+(\.\d+)?/g)].map(found => Number(found[0]))"""


def dots(page):
    """Centres of the camera view's dots, px."""
    return page.evaluate(f"[...{DOTS}].map(c => [Number(c.getAttribute('cx')), Number(c.getAttribute('cy'))])")


def wait_for_dots(page, count):
    page.wait_for_function(f"{DOTS}.length === {count}")


def wait_for_motion(page, before, number, least_px):
    """Wait until one dot has left its place."""
    x, y = before[number]
    page.wait_for_function(
        f"(c => c && Math.hypot(c.cx.baseVal.value - {x}, c.cy.baseVal.value - {y}) > {least_px})({DOTS}[{number}])"
    )


def farthest(before, after):
    return max(((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5 for a, b in zip(before, after, strict=True))


def colours(page):
    """How many different colours the middle of the 3-D picture has."""
    return page.evaluate(
        """() => { const c = document.querySelector('.dome-view canvas');
        const d = document.createElement('canvas'); d.width = c.width; d.height = c.height;
        const x = d.getContext('2d'); x.drawImage(c, 0, 0);
        const p = x.getImageData(0, 0, c.width, c.height).data; const seen = new Set();
        for (let i = 0; i < p.length; i += 64) if (p[i + 3]) seen.add(p[i] + ',' + p[i + 1] + ',' + p[i + 2]);
        return seen.size; }"""
    )
