"""c3rt.view: what the page draws from."""

import contextlib
import os
import pathlib
import subprocess
import time
from types import SimpleNamespace

import numpy as np
import pytest

from c3rt.view.cameras import Cameras, mark, words_of
from c3rt.view.robot import Robot
from c3rt.view.weights import Weights

PROGRAM = os.environ.get("C3RT_PROGRAM")


@pytest.fixture
def two_links(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "tip.stl").write_text("solid tip\nendsolid tip\n")
    file = tmp_path / "urdf" / "two.urdf"
    file.parent.mkdir()
    file.write_text("""<robot name="two">
      <link name="base"/><link name="first"/>
      <link name="tip"><collision><geometry><mesh filename="package://somewhere/meshes/tip.stl"/></geometry></collision></link>
      <joint name="a" type="revolute"><parent link="base"/><child link="first"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
      <joint name="b" type="fixed"><parent link="first"/><child link="tip"/><origin xyz="2 0 0" rpy="0 0 1.5707963267948966"/></joint>
    </robot>""")
    return file


def test_a_link_is_where_the_joints_before_it_put_it(two_links):
    poses = Robot(two_links).links([np.pi / 2])
    np.testing.assert_allclose(poses["tip"][:3, 3], [0, 2, 1], atol=1e-12)
    np.testing.assert_allclose(poses["tip"][:3, :3], [[-1, 0, 0], [0, -1, 0], [0, 0, 1]], atol=1e-12)


def test_a_mesh_is_found_from_the_folders_above_the_urdf(two_links):
    robot = Robot(two_links)
    assert robot.meshes["tip"][0] == two_links.parents[1] / "meshes" / "tip.stl"
    assert "first" not in robot.meshes


@pytest.mark.skipif(not PROGRAM, reason="C3RT_PROGRAM names no c3rt that could make a recording")
def test_the_panda_s_flange_carries_the_end_effector_that_the_plant_tells(tmp_path):
    log = pytest.importorskip("c3rt.log", exc_type=ImportError)
    subprocess.run([PROGRAM, "run", "push_t", "--in-process", "--duration", "1", "--no-pictures", "--out", tmp_path / "run"],
                   capture_output=True, check=False)
    state = log.read(tmp_path / "run" / "run.mcap", topics=["robot/state"])["robot/state"]
    urdf = os.environ.get("C3RT_PANDA_URDF")
    if not urdf or not pathlib.Path(urdf).is_file():
        pytest.skip("C3RT_PANDA_URDF names no URDF")
    robot = Robot(urdf)
    offsets = []
    for i in range(0, len(state), 100):
        flange = robot.links(state.loc[i, [f"q_rad_{j}" for j in range(7)]])["panda_link7"]
        p_WE = state.loc[i, [f"p_WE_m_{j}" for j in range(3)]].to_numpy(float)
        offsets.append(flange[:3, :3].T @ (p_WE - flange[:3, 3]))
    offsets = np.array(offsets)
    assert np.ptp(offsets, axis=0).max() < 1e-9
    np.testing.assert_allclose(offsets[0][:2], 0, atol=1e-9)  # along the flange's axis


# ---- the cameras' pictures

BALL_RADIUS = 0.0315
GREEN, RED = (40, 220, 80), (220, 50, 50)


@pytest.mark.parametrize("width", [640, 320])
def test_a_ball_is_in_the_picture_where_the_camera_s_model_has_its_outline(width):
    """The outline of a sphere is an ellipse whose centre is not the image of the sphere's: t z / (z² - r²)."""
    renderer = pytest.importorskip("c3rt._cameras").Cameras("circle_vision", ["vision.pixel_noise=0"], 1, width)
    assert renderer.names == ["front", "left", "right"]
    p_WB = np.array([0.45, 0.15, -0.0245 + BALL_RADIUS])
    renderer.expose([0, 0, 0, -1.5, 0, 1.5, 0.8], [[*p_WB, 1, 0, 0, 0]])
    for camera in range(3):
        fx, fy, cx, cy, full_width, full_height = renderer.intrinsics(camera)
        picture = renderer.picture(camera).astype(int)
        assert picture.shape == (full_height * width // full_width, width, 3)
        x, y, z = (np.linalg.inv(renderer.pose(camera)) @ [*p_WB, 1])[:3]
        expected = np.array([fx * x, fy * y]) * z / (z * z - BALL_RADIUS**2) + [cx, cy]
        rows, columns = np.nonzero(picture[..., 0] - picture[..., 2] > 80)
        binning = full_width / width
        seen = (np.array([columns.min() + columns.max(), rows.min() + rows.max()]) / 2 + 0.5) * binning - 0.5
        np.testing.assert_allclose(seen, expected, atol=1.5 * binning)


def test_what_cannot_be_shown_is_named():
    make = pytest.importorskip("c3rt._cameras").Cameras
    renderer = make("circle_slow")
    assert renderer.names == []
    with pytest.raises(ValueError, match="no cameras"):
        renderer.expose(np.zeros(7), [[0.5, 0, 0, 1, 0, 0, 0]])
    with pytest.raises(ValueError, match="width: expected 32 to 2048"):
        make("circle_vision", width=1)
    renderer = make("circle_vision")
    with pytest.raises(ValueError, match="expose"):
        renderer.picture(0)
    with pytest.raises(ValueError, match=r"objects: expected the shape \(1, 7\)"):
        renderer.expose(np.zeros(7), np.zeros((2, 7)))
    with pytest.raises(ValueError, match="camera: expected 0 to 2, got 3"):
        renderer.picture(3)


def test_a_mark_is_at_the_detection_s_pixel():
    picture = np.zeros((60, 80, 3), np.uint8)
    mark(picture, 80.5, 40.5, 20.0, 2.0, GREEN)  # of an image of 160 x 120
    rows, columns = np.nonzero(picture.any(axis=2))
    assert (columns.min() + columns.max()) / 2 == 40 and (rows.min() + rows.max()) / 2 == 20
    assert np.abs(np.hypot(columns - 40, rows - 20) - 10).max() <= 1
    assert (picture[20, 50] == GREEN).all()
    picture[:] = 0
    mark(picture, 80.5, 40.5, 0.0, 2.0, RED)  # a tag has a place alone
    assert (picture[20, 40] == RED).all()
    mark(picture, -500.0, -500.0, 3.0, 2.0, RED)  # outside: nothing


class Handle(SimpleNamespace):
    pass


class Panel:
    """What cameras.py needs of viser, and the readers of a client."""

    def __init__(self):
        self.images, self.texts, self.box, self.browsers = [], [], None, {}
        self.topics = {}  # what is subscribed, and with samples to come
        self.gui = self

    def add_folder(self, name):
        return contextlib.nullcontext()

    def add_markdown(self, content, visible=True):
        self.texts.append(Handle(content=content, visible=visible))
        return self.texts[-1]

    def add_checkbox(self, label, value):
        self.box = Handle(value=value)
        return self.box

    def add_image(self, image, label, format, visible):
        self.images.append(Handle(image=image, label=label, visible=visible))
        return self.images[-1]

    def get_clients(self):
        return self.browsers

    def reader(self, topic, depth):
        self.topics[topic] = []
        return Handle(take=lambda: [self.topics[topic].pop(0) for _ in range(len(self.topics[topic]))],
                      close=lambda: self.topics.pop(topic))


class Renderer:
    def expose(self, q, objects):
        self.objects = objects

    def picture(self, camera):
        return np.full((240, 320, 3), 10 * (camera + 1), np.uint8)


SCENE = {"cameras": [{"name": name, "width_px": 640, "height_px": 480} for name in ("front", "left")],
         "objects": [{"name": "ball"}], "file": "", "overrides": [], "seed": 1}


def found(camera, at_ns, **fields):
    return SimpleNamespace(camera=camera, object_index=0, exposure_ns=at_ns, found=True, used=True, u_px=320.5, v_px=240.5, radius_px=30.0,
                           **fields)


def exposed(at_ns):
    body = SimpleNamespace(p_WB_m=[0.5, 0, 0], q_WB=[1, 0, 0, 0])
    return SimpleNamespace(exposure=True, q_rad=[0] * 7, object_count=1, objects=[body] * 8, header=SimpleNamespace(time_ns=at_ns))


def await_true(condition):
    end = time.monotonic() + 10
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    assert condition()


def test_nothing_is_subscribed_until_somebody_looks_and_nothing_afterwards():
    panel = Panel()
    cameras = Cameras(panel, panel, SCENE, Renderer)
    cameras.follow()
    assert panel.topics == {}
    panel.box.value = True  # nobody has the page open
    cameras.follow()
    assert panel.topics == {}
    panel.browsers = {1: None}
    cameras.follow()
    assert panel.topics.keys() == {"object/detection", "sim/scene"}
    panel.box.value = False
    cameras.follow()
    assert panel.topics == {} and not any(image.visible for image in panel.images)
    cameras.stop()


def test_the_picture_is_of_the_exposure_in_which_vision_found_what_is_marked():
    panel = Panel()
    renderer = Renderer()
    cameras = Cameras(panel, panel, SCENE, lambda: renderer)
    panel.box.value, panel.browsers = True, {1: None}
    cameras.follow()
    panel.topics["sim/scene"] += [exposed(1000), exposed(2000), exposed(3000)]
    rejected = found(1, 2000)
    rejected.used = False
    panel.topics["object/detection"] += [found(0, 1000), found(0, 2000), rejected]
    cameras._next = 0.0
    cameras.follow()
    await_true(lambda: all(image.visible for image in panel.images))
    cameras.stop()
    front, left = (image.image for image in panel.images)
    assert front.shape == (240, 320, 3) and (front[0, 0] == 10).all() and (left[0, 0] == 20).all()
    assert (front[120, 175] == GREEN).all() and (left[120, 175] == RED).all()  # the outline, at half the size
    assert [text.content for text in panel.texts[1:]] == ["ball: 320, 240 px", "ball: 320, 240 px (rejected)"]


def test_without_scenes_the_detections_are_on_dark_pictures_and_the_page_says_so():
    panel = Panel()
    cameras = Cameras(panel, panel, SCENE, Renderer)
    panel.box.value, panel.browsers = True, {1: None}
    cameras.follow()
    panel.topics["object/detection"].append(found(0, 1000))
    cameras._next, cameras._heard = 0.0, time.monotonic() - 2.0
    cameras.follow()
    cameras.stop()
    assert "sim/scene" in panel.texts[0].content
    picture = panel.images[0].image
    assert picture.shape == (360, 480, 3) and (picture[0, 0] == 40).all() and (picture == GREEN).all(axis=2).any()


def test_a_scenario_without_cameras_is_told_of():
    panel = Panel()
    cameras = Cameras(panel, panel, {**SCENE, "cameras": []})
    cameras.follow()
    assert panel.box is None and "no cameras" in panel.texts[0].content
    assert panel.topics == {}
    cameras.stop()


# ---- sliders


class Sliders(Panel):
    """What weights.py needs of viser."""

    def __init__(self):
        super().__init__()
        self.sliders, self.buttons, self.folders = {}, {}, []

    def add_folder(self, name, expand_by_default=True):
        self.folders.append(name)
        return contextlib.nullcontext()

    def add_button(self, label):
        self.buttons[label] = Handle(on_click=lambda call: setattr(self.buttons[label], "press", lambda: call(None)))
        return self.buttons[label]

    def add_slider(self, label, min, max, step, initial_value, hint):
        panel = self
        label = f"{label}: {hint}"

        class Slider(Handle):
            def on_update(self, call):
                self.call = call

            def __setattr__(self, name, value):
                super().__setattr__(name, value)
                if name == "value" and "call" in self.__dict__:
                    self.call(None)  # viser calls it, whoever sets the value

        panel.sliders[label] = Slider(min=min, max=max, step=step, value=initial_value)
        return panel.sliders[label]


WEIGHTS = {"weights": [{"name": "roll.Q.ball_xy", "value": 5e5, "min": 5e4, "max": 5e6}, {"name": "roll.R", "value": 0.01, "min": 1e-3, "max": 0.1},
                       {"name": "return.R", "value": 0.02, "min": 2e-3, "max": 0.2}]}


XY = "Q.ball_xy: 500000 times a power of ten, from 50000 to 5e+06"
ROLL_R, RETURN_R = "R: 0.01 times a power of ten, from 0.001 to 0.1", "R: 0.02 times a power of ten, from 0.002 to 0.2"


@pytest.fixture
def sliders():
    pytest.importorskip("cyclonedds", exc_type=ImportError)
    panel, asked = Sliders(), []
    weights = Weights(panel, WEIGHTS, lambda some: asked.append(some) or "planner: done")
    yield panel, weights, asked
    weights.stop()


def test_each_weight_has_a_slider_in_decades_of_its_own_value(sliders):
    panel, _, asked = sliders
    assert panel.folders == ["Weights", "Phase roll", "Phase return"]
    assert list(panel.sliders) == [XY, ROLL_R, RETURN_R]
    for slider in panel.sliders.values():
        assert (slider.min, slider.max, slider.value) == (-1, 1, 0)
        assert slider.min / slider.step == pytest.approx(round(slider.min / slider.step))  # 0 is one of its steps
    assert asked == []


def test_what_is_moved_is_asked_and_never_beyond_its_range(sliders):
    panel, _, asked = sliders
    panel.sliders[ROLL_R].value = 0.3
    await_true(lambda: asked)
    assert asked[0] == {"roll.R": pytest.approx(0.01 * 10**0.3)}
    panel.sliders[XY].value = 1.0
    await_true(lambda: len(asked) == 2)
    assert asked[1]["roll.Q.ball_xy"] <= 5e6
    await_true(lambda: panel.texts[0].content == "planner: done")


def test_the_scenario_s_weights_come_back_at_once_with_all_sliders_in_the_middle(sliders):
    panel, _, asked = sliders
    panel.sliders[RETURN_R].value = -0.5
    await_true(lambda: asked)
    panel.buttons["The scenario's weights"].press()
    await_true(lambda: len(asked) == 2)
    assert asked[1] == {} and all(slider.value == 0 for slider in panel.sliders.values())


def test_a_planner_that_was_started_anew_has_the_scenario_s_and_nothing_is_asked(sliders):
    panel, weights, asked = sliders
    weights.follow(None)
    weights.follow(SimpleNamespace(pid=7))
    panel.sliders[RETURN_R].value = -0.5
    await_true(lambda: asked)
    weights.follow(SimpleNamespace(pid=7))
    assert panel.sliders[RETURN_R].value == -0.5
    weights.follow(SimpleNamespace(pid=8))
    assert panel.sliders[RETURN_R].value == 0 and "anew" in panel.texts[0].content
    time.sleep(0.1)
    assert len(asked) == 1


def test_a_scenario_that_allows_no_other_weights_says_how_it_would():
    panel = Sliders()
    weights = Weights(panel, {"weights": []}, None)
    assert panel.sliders == {} and "adjustable_by" in panel.texts[0].content
    weights.follow(SimpleNamespace(pid=1))
    weights.stop()


def test_what_was_not_found_is_said():
    lost = found(0, 1)
    lost.found = False
    assert words_of([lost], ["T"]) == "T: not found"
