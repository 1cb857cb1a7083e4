"""c3rt and its page, and a browser that looks at it."""

import contextlib
import os
import pathlib
import signal
import subprocess
import tempfile
import threading
import time

from selenium import webdriver
from selenium.webdriver.common.by import By

PROGRAM = os.environ["C3RT_PROGRAM"]
PORT = 8099
PATIENCE_S = 90.0
# width and height of each camera's picture, in the page's order, and how many of its pixels are of a colour
PICTURES = """
const [colour] = arguments;
const found = [];
for (const image of document.querySelectorAll('img')) {
  if (!image.complete || image.naturalWidth < 300) continue;
  const canvas = document.createElement('canvas');
  canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  const data = context.getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let i = 0; i < data.length; i += 4)
    if (colour.every((value, k) => Math.abs(data[i + k] - value) < 40)) ++count;
  found.push([canvas.width, canvas.height, count]);
}
return found;
"""


def c3rt(*words):
    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)


@contextlib.contextmanager
def going(*words):
    """A program of c3rt that goes on until the block ends."""
    process = subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=PATIENCE_S)


@contextlib.contextmanager
def view(*words):
    """c3rt view; it has told its address."""
    end = time.monotonic() + PATIENCE_S
    while True:
        with going("view", "--port", PORT, *words) as process:
            said = ""
            for line in process.stdout:
                said += line
                if line.startswith("http://"):
                    # what it says later is read, so that it never waits for us
                    threading.Thread(target=process.stdout.read, daemon=True).start()
                    yield process
                    return
        # whom it is to show may not have begun
        assert "no instance of yours" in said and time.monotonic() < end, said
        time.sleep(0.5)


@contextlib.contextmanager
def browser(width=600, height=700):  # it draws without a graphics card
    options = webdriver.ChromeOptions()
    with tempfile.TemporaryDirectory() as profile:
        for word in ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", f"--user-data-dir={profile}",
                     f"--window-size={width},{height}", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader"):
            options.add_argument(word)
        service = webdriver.ChromeService("/usr/bin/chromedriver")
        driver = webdriver.Chrome(options=options, service=service)
        try:
            driver.get(f"http://127.0.0.1:{PORT}")
            yield driver
        finally:
            driver.quit()


def text_of(driver):
    return driver.find_element(By.TAG_NAME, "body").text


def until(condition, seconds=PATIENCE_S):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.2)
    return condition()


def tick_cameras(driver):
    """Ticks the box of the cameras' pictures."""
    assert until(lambda: "Show what they see" in text_of(driver)), text_of(driver)
    words = driver.find_element(By.XPATH, "//*[text()='Show what they see']")
    box = words.find_element(By.XPATH, "./following::input[@type='checkbox'][1]")
    driver.execute_script("arguments[0].click()", box)


def click_words(driver, words):
    """On a folder's title or a button."""
    path = f"//*[normalize-space(text())=\"{words}\"]"
    assert until(lambda: driver.find_elements(By.XPATH, path)), text_of(driver)
    driver.execute_script("arguments[0].scrollIntoView(); arguments[0].click()", driver.find_element(By.XPATH, path))


def keep_picture(driver, name, about=None):
    """Where C3RT_VIEW_PICTURES names a folder. about: an element that is to be seen; else a camera's picture"""
    folder = os.environ.get("C3RT_VIEW_PICTURES")
    if folder:
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
        if about is not None:
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", about)
        else:
            driver.execute_script("for (const i of document.querySelectorAll('img')) if (i.naturalWidth >= 300) { i.scrollIntoView(); break; }")
        time.sleep(1.0)
        driver.save_screenshot(str(pathlib.Path(folder) / f"{name}.png"))
