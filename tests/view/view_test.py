"""The page of `c3rt view` in a headless Chromium (tests/view.sh)."""

import contextlib

import pytest
from page import PICTURES, browser, c3rt, click_words, going, keep_picture, text_of, tick_cameras, until, view
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

GREEN = [40, 220, 80]  # of an outline


@contextlib.contextmanager
def service(scenario, folder, *words):
    up = c3rt("up", scenario, "--out", folder, *words)
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


def test_a_slider_gives_the_planner_another_weight_and_a_button_takes_it_back(tmp_path):
    with service("circle_slow", tmp_path / "out", "--set", "planner.weights.adjustable_by=100"), view(), browser() as driver:
        assert until(lambda: "robot: move" in text_of(driver)), text_of(driver)
        click_words(driver, "Weights")
        click_words(driver, "Phase roll")
        assert until(lambda: driver.find_elements(By.XPATH, "//*[@role='slider']")), text_of(driver)
        slider = driver.find_element(By.XPATH, "//*[@role='slider']")  # of Q.ball_velocity, which is 0.1
        slider.send_keys(Keys.ARROW_LEFT)
        assert until(lambda: "planner: roll.Q.ball_velocity 0.0891251" in text_of(driver)), text_of(driver)  # 10^-0.05 times
        keep_picture(driver, "weights", slider)
        assert c3rt("weights", "set", "roll.Q.ball_xy=1e5").stdout == "planner: roll.Q.ball_xy 100000\n"
        click_words(driver, "The scenario's weights")
        assert until(lambda: "planner: the scenario's own" in text_of(driver)), text_of(driver)


def test_without_room_for_other_weights_the_page_says_how_to_give_it(tmp_path):
    with service("circle_slow", tmp_path / "out"), view(), browser() as driver:
        click_words(driver, "Weights")
        assert until(lambda: "planner.weights.adjustable_by" in text_of(driver)), text_of(driver)
