"""The page of `c3rt view` in a headless Chromium (tests/view.sh)."""

import contextlib

import pytest
from page import PICTURES, browser, c3rt, going, keep_picture, text_of, tick_cameras, until, view

GREEN = [40, 220, 80]  # of an outline


@contextlib.contextmanager
def service(scenario, folder):
    up = c3rt("up", scenario, "--out", folder)
    assert up.returncode == 0, up.stderr
    try:
        yield
    finally:
        c3rt("down")


def outlines(driver, cameras=3):
    """Size of each picture, and its pixels of an outline, once there are some in all of them."""
    def seen():
        pictures = driver.execute_script(PICTURES, GREEN)
        return pictures if len(pictures) == cameras and all(count > 5 for _, _, count in pictures) else None

    return until(seen)


@pytest.mark.parametrize("scenario", ["circle_vision", "push_t_cameras"])
def test_beside_a_service_each_camera_has_its_picture_with_the_object_marked(scenario, tmp_path):
    with service(scenario, tmp_path / "out"), view(), browser() as driver:
        assert until(lambda: "robot: move" in text_of(driver)), text_of(driver)
        assert driver.execute_script(PICTURES, GREEN) == []  # nobody has asked for them
        tick_cameras(driver)
        pictures = outlines(driver)
        keep_picture(driver, scenario)
        assert pictures, text_of(driver)
        assert [picture[:2] for picture in pictures] == [[320, 240]] * 3
        assert " px" in text_of(driver)


def test_beside_a_replay_the_pictures_are_those_of_the_recording(tmp_path):
    run = c3rt("run", "circle_vision", "--in-process", "--duration", "6", "--no-pictures", "--set", "criteria=[]", "--out", tmp_path / "run")
    assert run.returncode in (0, 1), run.stderr
    with going("replay", tmp_path / "run" / "run.mcap", "--rate", "0.05"), view(), browser() as driver:
        tick_cameras(driver)
        pictures = outlines(driver)
        keep_picture(driver, "replay")
        assert pictures, text_of(driver)


def test_a_scenario_without_cameras_says_so(tmp_path):
    with service("circle_slow", tmp_path / "out"), view(), browser() as driver:
        assert until(lambda: "This scenario has no cameras" in text_of(driver)), text_of(driver)
        assert "Show what they see" not in text_of(driver)
