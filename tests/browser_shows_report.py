"""Opens a report's page in headless Chromium, and checks what a reader sees and does.

    python tests/browser_shows_report.py REPORT_FOLDER [FOLDER_FOR_SCREENSHOTS]

Needs Chromium and its driver (Debian: chromium, chromium-driver) and the packages of browser_requirements.txt. Each check
is held against a page with a planted fault, too, which it must not pass.
"""

import json
import re
import shutil
import sys
import tempfile
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.select import Select
from selenium.webdriver.support.wait import WebDriverWait

TELEPHONE, SCREEN = 390, 1280


def browser(profile):
    options = webdriver.ChromeOptions()
    for flag in ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
                 "--disable-background-networking", "--disable-component-update", "--disable-sync",
                 "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={profile}"]:
        options.add_argument(flag)
    options.binary_location = shutil.which("chromium")
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
    return driver


def open_page(driver, page, width=SCREEN):
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width == TELEPHONE})
    # from elsewhere, so that it is not the page before whose end is seen
    driver.get("about:blank")
    driver.get(page.resolve().as_uri())
    here = f"return location.href === {json.dumps(page.resolve().as_uri())} && document.readyState === 'complete'"
    WebDriverWait(driver, 60).until(lambda driver: driver.execute_script(here))


# runs before anything of a page, and keeps what goes wrong in it
WATCH = """
    window.said = [];
    for (const word of ['error', 'warn', 'log']) console[word] = (...words) => said.push(words.join(' '));
    addEventListener('error', event => said.push(event.message ?? `${event.target.src}`), true);
    addEventListener('unhandledrejection', event => said.push(`${event.reason}`));
    addEventListener('securitypolicyviolation', event => said.push(`blocked: ${event.blockedURI}`));
"""


def console(driver, page):
    """Nothing goes wrong, nothing is said on the console, and nothing but the page itself is asked for."""
    open_page(driver, page)
    driver.execute_async_script("setTimeout(arguments[0], 300)")
    asked = "performance.getEntriesByType('resource').map(entry => entry.name)"
    return driver.execute_script(f"return [...said, ...{asked}]")


def figures(driver, page):
    """Every figure of the folder is shown, with something drawn in it and its words beside it."""
    open_page(driver, page)
    shown = driver.execute_script("""
        return [...document.querySelectorAll('.figure')].map(figure => {
            const box = figure.querySelector('svg')?.getBoundingClientRect();
            const drawn = figure.querySelectorAll('polyline, polygon, path, circle, line').length;
            return box && box.width > 200 && box.height > 100 && drawn > 10 && figure.getAttribute('aria-label') !== '';
        })""")
    expected = len(list((page.parent / "figures").glob("*.svg")))
    return [] if shown == [True] * expected else [f"{shown} of {expected} figures"]


def picker(driver, page):
    """The picked pair is the one that is drawn and told, at the speed that is asked for."""
    open_page(driver, page)
    curves = json.loads(driver.execute_script("return document.getElementById('curves').textContent"))
    pairs, wrong = Select(driver.find_element(By.ID, "pair")), []
    names = [option.text for option in pairs.options]
    if names != [pair["name"] for pair in curves["pairs"]]:
        wrong.append("pairs are not those of the curves")
    seen = set()
    for index in {0, min(1, len(names) - 1), len(names) // 2, len(names) - 1}:
        pairs.select_by_index(index)
        for place in [0, len(curves["speeds"]) // 2, len(curves["speeds"]) - 1]:
            driver.execute_script("""
                const slider = document.getElementById('speed');
                slider.value = arguments[0];
                slider.dispatchEvent(new Event('input'));""", place)
            told = driver.find_element(By.ID, "answer").text
            e = curves["pairs"][index]["restitution"][place]
            expected = f"e_n = {e:.4f}" if e > 0 else "no rebound"
            if expected not in told or f"v = {curves['speeds'][place]:.2f} m/s" not in told:
                wrong.append(f"{names[index]}: {told!r}, expected {expected!r}")
        drawn = driver.execute_script("return document.getElementById('curve').innerHTML")
        marks = drawn.count('class="rebound"') + drawn.count('class="stuck"')
        pair = curves["pairs"][index]
        if marks != len(pair["rebounds"]) + len(pair["stuck"]) or "NaN" in drawn or 'class="curve' not in drawn:
            wrong.append(f"{names[index]}: {marks} marks")
        seen.add(re.search(r'class="curve[^"]*" points="([^"]*)"', drawn)[1])
    return wrong + ([] if len(seen) == 1 == len(names) or len(seen) > 1 else ["every pair is drawn alike"])


def sideways(driver, page):
    """Nothing is wider than the window, on a telephone or a screen."""
    wrong = []
    for width in [TELEPHONE, SCREEN]:
        open_page(driver, page, width)
        across, window = driver.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
        if across > window or window != width:
            wrong.append(f"{across} px in a window of {window} px")
    return wrong


def by_night(driver, page):
    """Text and paper change places where the reader prefers dark."""
    lightness = []
    for scheme in ["light", "dark"]:
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                               {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
        open_page(driver, page)
        colours = driver.execute_script("const s = getComputedStyle(document.body); return [s.color, s.backgroundColor]")
        lightness.append([sum(map(int, re.findall(r"\d+", colour)[:3])) for colour in colours])
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    (text, paper), (text_by_night, paper_by_night) = lightness
    right = paper - text > 300 and text_by_night - paper_by_night > 300
    return [] if right else [f"lightness of text and paper: {lightness}"]


# each check with a fault that it must find
CHECKS = [
    (console, "</main>", '</main><script>console.error("planted")</script>'),
    (console, "</main>", '</main><script>nothing.here()</script>'),
    (console, "</main>", '</main><img src="https://example.org/x.png">'),
    (figures, '<span class="figure"', '<span class="figure" style="display:none"'),
    (picker, "pair.restitution[place];", "pairs[0].restitution[place];"),
    (sideways, "</main>", '</main><div style="width:2000px">planted</div>'),
    (by_night, "prefers-color-scheme: dark", "prefers-color-scheme: no"),
]


def main(folder, screenshots=None):
    page = Path(folder) / "report.html"
    with tempfile.TemporaryDirectory() as profile, browser(profile) as driver:
        failed = [f"{check.__name__}: {wrong}" for check in dict.fromkeys(check for check, *_ in CHECKS)
                  for wrong in check(driver, page)]
        planted = page.with_name("planted.html")
        try:
            for check, sound, fault in CHECKS:
                text = page.read_text(encoding="utf-8")
                assert sound in text, sound
                planted.write_text(text.replace(sound, fault, 1), encoding="utf-8")
                if not check(driver, planted):
                    failed.append(f"{check.__name__} does not find {fault}")
        finally:
            planted.unlink(missing_ok=True)
        if screenshots:
            for name, width, scheme in [("screen", SCREEN, "light"), ("night", SCREEN, "dark"), ("telephone", TELEPHONE, "light")]:
                driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                       {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
                open_page(driver, page, width)
                height = min(6000, driver.execute_script("return document.documentElement.scrollHeight"))
                driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                       {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
                driver.save_screenshot(f"{screenshots}/{name}.png")
    print("\n".join(failed) if failed else f"{page}: {len(CHECKS)} faults found, none in the page itself")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
