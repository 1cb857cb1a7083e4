"""The page: what it shows of the newest samples, and what its buttons ask."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, List, Optional, Tuple

import numpy as np

try:
    import trimesh
    import viser
    from viser import uplot
except ImportError as error:
    raise ImportError("c3rt.view needs the package viser: pip install './python[view]'") from error

import c3rt.v2 as types
from c3rt.client import Client, NoAnswer, Refused

from .cameras import Cameras
from .robot import Robot
from .weights import Weights

RATE_HZ = 20.0
WINDOW_S = 20.0  # of the plots
SILENT_S = 1.0  # what has not come for so long is shown as gone
METRES_PER_NEWTON = 0.01
BLUE, GREEN, ORANGE, RED, GREY = (60, 120, 220), (40, 160, 80), (240, 140, 20), (220, 50, 50), (120, 120, 120)
COLOURS = (ORANGE, BLUE, GREEN, (160, 80, 200), (200, 170, 40), (60, 180, 180), (220, 90, 140), GREY)
PUSH_N_S = 0.05


def mesh_of(shape: Dict[str, Any]) -> "trimesh.Trimesh":
    """The triangles of a shape as `c3rt view` writes it."""
    kind = shape["kind"]
    if kind == "sphere":
        return trimesh.creation.icosphere(subdivisions=3, radius=shape["radius"])
    if kind == "box":
        return trimesh.creation.box(extents=2 * np.array(shape["half_sizes"]))
    if kind == "capsule":
        return trimesh.creation.capsule(height=2 * shape["half_length"], radius=shape["radius"])
    if kind == "cylinder":
        return trimesh.creation.cylinder(radius=shape["radius"], height=2 * shape["half_length"])
    if kind == "convex_mesh":
        return trimesh.convex.convex_hull(np.array(shape["vertices"]))
    if kind == "union":
        parts = []
        for part in shape["parts"]:
            mesh = mesh_of(part["shape"])
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = np.array(part["R_BP"]), part["p_BP"]
            mesh.apply_transform(pose)
            parts.append(mesh)
        return trimesh.util.concatenate(parts)
    raise ValueError(f"kind: expected a shape, got {kind!r}")


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    return trimesh.transformations.quaternion_from_matrix(rotation)


class _Newest:
    """The newest sample of a topic, and when it came."""

    def __init__(self, client: Client, topic: str, depth: int = 1) -> None:
        self._reader = client.reader(topic, depth)
        self.sample: Any = None
        self.heard = -np.inf

    def take(self) -> List[Any]:
        samples = self._reader.take()
        if samples:
            self.sample, self.heard = samples[-1], time.monotonic()
        return samples

    @property
    def fresh(self) -> bool:
        return time.monotonic() - self.heard < SILENT_S


class _Plot:
    """A line for each name over the last seconds."""

    def __init__(self, server: viser.ViserServer, title: str, names: List[str]) -> None:
        self._rows: Deque[Tuple[float, ...]] = deque(maxlen=int(WINDOW_S * RATE_HZ))
        self._count = len(names)
        series = [uplot.Series(label="seconds")]
        for name, colour in zip(names, COLOURS):
            series.append(uplot.Series(label=name, stroke=f"rgb{colour}", width=2))
        empty = tuple(np.array([0.0, 1.0]) for _ in range(1 + len(names)))
        self._handle = server.gui.add_uplot(empty, tuple(series), title=title, aspect=2.2,
                                            scales={"x": uplot.Scale(time=False)})

    def add(self, now: float, *values: float) -> None:
        self._rows.append((now, *values))

    def show(self) -> None:
        if len(self._rows) > 1:
            table = np.array(self._rows).T
            self._handle.data = (table[0] - table[0][-1], *table[1:])


class Page:
    """Serves the page and keeps it up to date until stop().

    scene: {"objects": [{"name", "shape"}], "tip_radius_m", "table_height_m", "urdf", "scenario", and those of cameras.py and
    weights.py}, as `c3rt view` writes it."""

    def __init__(self, client: Client, scene: Dict[str, Any], host: str = "127.0.0.1", port: int = 8080) -> None:
        self._client = client
        self._scene = scene
        self._server = viser.ViserServer(host=host, port=port, verbose=False, label="c3rt")
        self._newest = {topic: _Newest(client, topic) for topic in
                        ("robot/state", "robot/command", "robot/contact", "plan", "planner/debug", "sim/scene")}
        self._estimates = _Newest(client, "object/estimate", 32)
        self._statuses: Dict[str, Any] = {}
        self._asking = threading.Lock()  # buttons and sliders ask from threads of their own, and an answer has one reader
        self._clicking: Optional[Callable[..., None]] = None
        self._robot = Robot(scene["urdf"]) if scene.get("urdf") else None
        self._build_scene()
        self._build_panel()

    @property
    def port(self) -> int:
        return self._server.get_port()

    def stop(self) -> None:
        self._cameras.stop()
        self._weights.stop()
        self._server.stop()

    def run(self, until: Callable[[], bool]) -> None:
        """Follows the bus, RATE_HZ times a second, until it is enough."""
        begun = time.monotonic()
        next_words = begun
        while not until():
            now = time.monotonic()
            self._follow(now - begun)
            self._cameras.follow()
            if now >= next_words:
                next_words = now + 0.5
                self._tell()
            time.sleep(max(0.0, 1.0 / RATE_HZ - (time.monotonic() - now)))

    # ---- what is seen

    def _build_scene(self) -> None:
        scene = self._server.scene
        table = float(self._scene.get("table_height_m", 0.0))
        scene.set_up_direction("+z")
        scene.set_environment_map(None)  # its picture fades in for half a minute where there is no graphics card
        scene.add_light_hemisphere("/light", intensity=1.5)
        scene.set_background_image(np.full((2, 2, 3), 40, np.uint8))
        scene.add_grid("/table", width=1.0, height=1.0, cell_size=0.05, section_size=0.25, position=(0.5, 0.0, table))
        scene.add_frame("/W", axes_length=0.1, axes_radius=0.003)
        self._links: Dict[str, Any] = {}
        if self._robot is not None:
            for name, (file, pose) in self._robot.meshes.items():
                mesh = trimesh.load(file, force="mesh")
                mesh.apply_transform(pose)
                self._links[name] = scene.add_mesh_simple(f"/arm/{name}", mesh.vertices, mesh.faces, color=(150, 160, 175))
        tip = float(self._scene.get("tip_radius_m", 0.0195))
        self._tip = scene.add_icosphere("/end_effector", radius=tip, color=(70, 70, 70))
        self._objects: List[Any] = []
        self._truths: List[Any] = []
        for index, body in enumerate(self._scene["objects"]):
            mesh = mesh_of(body["shape"])
            name = f"{index}_{body['name']}"
            self._objects.append(scene.add_mesh_simple(f"/estimates/{name}", mesh.vertices, mesh.faces, flat_shading=True,
                                                       color=COLOURS[index % len(COLOURS)], visible=False))
            self._truths.append(scene.add_mesh_simple(f"/truth/{name}", mesh.vertices, mesh.faces, color=GREY, wireframe=True,
                                                      visible=False))
        nothing = np.zeros((1, 2, 3))
        self._plan_line = scene.add_line_segments("/plan", nothing, colors=BLUE, thickness=0.003)
        self._force_line = scene.add_line_segments("/force", nothing, colors=RED, thickness=0.004)
        self._target_mark = scene.add_icosphere("/target", radius=0.006, color=GREEN, visible=False)
        self._candidates = scene.add_point_cloud("/candidates", np.zeros((1, 3), np.float32), colors=(255, 255, 255),
                                                 point_size=0.008, point_shape="circle", precision="float32")

        @self._server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            client.camera.position = (1.35, -0.75, 0.65)
            client.camera.look_at = (0.5, 0.0, 0.1)

    def _build_panel(self) -> None:
        gui = self._server.gui
        gui.add_markdown(f"**{self._scene.get('scenario', 'c3rt')}**")
        self._state = gui.add_markdown("waits for samples")
        with gui.add_folder("Tasks"):
            for label, action in (("Stop", self._client.stop), ("Recover", self._client.recover),
                                  ("Hold", lambda: self._client.target("hold")),
                                  ("The scenario's task", lambda: self._client.target("scenario"))):
                self._button(label, action)
            self._button("Push the object", lambda: self._client.fault("plant", "push-object", value=self._push()))
            aim = gui.add_button("Target: click on the table")
            aim.on_click(lambda _: self._aim())
            self._answer = gui.add_markdown("")
        with gui.add_folder("Figures"):
            self._tracking = _Plot(self._server, "end effector from the plan [mm]", ["distance"])
            self._solve = _Plot(self._server, "solve [ms]", ["solve"])
            self._force = _Plot(self._server, "force from outside [N]", ["x", "y", "z"])
        self._cameras = Cameras(self._server, self._client, self._scene)
        self._weights = Weights(self._server, self._scene,
                                lambda weights: self._words("weights", lambda: self._client.weights(weights)))
        with gui.add_folder("Processes"):
            self._processes = gui.add_markdown("nothing heard")

    def _button(self, label: str, action: Callable[[], Any]) -> None:
        self._server.gui.add_button(label).on_click(lambda _: self._ask(label, action))

    def _ask(self, label: str, action: Callable[[], Any]) -> None:
        self._answer.content = self._words(label, action)

    def _words(self, label: str, action: Callable[[], Any]) -> str:
        """What comes of asking."""
        try:
            with self._asking:
                reply = action()
            replies = reply if isinstance(reply, list) else [reply]
            words = "; ".join(f"{one.process}: {one.text or 'done'}" for one in replies)
        except (Refused, ValueError) as refused:
            words = f"refused: {refused}"
        except NoAnswer as silence:
            words = str(silence)
        return f"*{label}*: {words}"

    def _push(self) -> List[float]:
        angle = np.random.default_rng().uniform(0, 2 * np.pi)
        return [PUSH_N_S * np.cos(angle), PUSH_N_S * np.sin(angle), 0.0]

    def _aim(self) -> None:
        self._answer.content = "click where the object is to go"
        if self._clicking is not None:
            return

        @self._server.scene.on_pointer_event(event_type="click")
        def clicked(event: viser.ScenePointerEvent) -> None:
            at = self._on_table(event)
            if at is not None:
                self._ask(f"Target {at[0]:.3f}, {at[1]:.3f}",
                          lambda: self._client.target("pose", goals_m=[[at[0], at[1]]], position_tolerance_m=0.02, hold_s=1.0))
            self._server.scene.remove_pointer_callback()
            self._clicking = None

        self._clicking = clicked

    def _on_table(self, event: viser.ScenePointerEvent) -> Optional[np.ndarray]:
        if event.ray_origin is None or event.ray_direction is None or event.ray_direction[2] >= 0.0:
            return None
        origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
        return origin + (float(self._scene.get("table_height_m", 0.0)) - origin[2]) / direction[2] * direction

    # ---- what is followed

    def _follow(self, now: float) -> None:
        for newest in self._newest.values():
            newest.take()
        estimates = self._estimates.take()
        with self._server.atomic():
            self._show_arm()
            self._show_objects(estimates)
            self._show_plan(now)
            self._show_forces(now)

    def _show_arm(self) -> None:
        state = self._newest["robot/state"].sample
        if state is None:
            return
        self._tip.position = np.array(state.p_WE_m)
        if self._robot is None:
            return
        poses = self._robot.links(state.q_rad)
        for name, handle in self._links.items():
            if name in poses:
                handle.position = poses[name][:3, 3]
                handle.wxyz = _quaternion(poses[name])

    def _show_objects(self, estimates: List[Any]) -> None:
        for sample in estimates:
            if sample.object_index < len(self._objects):
                handle = self._objects[sample.object_index]
                handle.position, handle.wxyz = np.array(sample.p_WB_m), np.array(sample.q_WB)
                handle.visible = sample.valid
        truth = self._newest["sim/scene"]
        for index, handle in enumerate(self._truths):
            handle.visible = truth.fresh and index < truth.sample.object_count
            if handle.visible:
                body = truth.sample.objects[index]
                handle.position, handle.wxyz = np.array(body.p_WB_m), np.array(body.q_WB)

    def _show_plan(self, now: float) -> None:
        plan, command, state = (self._newest[topic] for topic in ("plan", "robot/command", "robot/state"))
        debug = self._newest["planner/debug"]
        self._plan_line.visible = plan.fresh and state.fresh
        if self._plan_line.visible:
            points = [np.array(state.sample.p_WE_m)]
            points += [np.array(knot.p_WE_m) for knot in plan.sample.knots[: plan.sample.knot_count]]
            self._plan_line.points = np.array([[a, b] for a, b in zip(points, points[1:])])
            self._solve.add(now, 1e3 * plan.sample.solve_time_s)
        if command.fresh and state.fresh:
            apart = np.linalg.norm(np.array(command.sample.p_WE_desired_m) - np.array(state.sample.p_WE_m))
            self._tracking.add(now, 1e3 * float(apart))
        self._target_mark.visible = debug.fresh
        self._candidates.visible = debug.fresh and debug.sample.candidate_count > 0
        if debug.fresh:
            self._target_mark.position = np.array(debug.sample.p_WB_target_m)
        if self._candidates.visible:
            of = debug.sample.candidates[: debug.sample.candidate_count]
            costs = np.array([candidate.cost for candidate in of])
            good = 1.0 - (costs - costs.min()) / max(np.ptp(costs), 1e-12)  # 1: the best
            self._candidates.points = np.array([candidate.p_WE_m for candidate in of], np.float32)
            self._candidates.colors = np.array([[255 * (1 - g), 200 * g, 40] for g in good], np.uint8)

    def _show_forces(self, now: float) -> None:
        contact, state = self._newest["robot/contact"], self._newest["robot/state"]
        self._force_line.visible = contact.fresh and state.fresh
        if self._force_line.visible:
            at, force = np.array(state.sample.p_WE_m), np.array(contact.sample.force_W_n)
            self._force_line.points = np.array([[at, at + METRES_PER_NEWTON * force]])
            self._force.add(now, *force)

    def _tell(self) -> None:
        state, plan = self._newest["robot/state"], self._newest["plan"]
        self._statuses.update(self._client.status(timeout=0.0))
        self._weights.follow(self._statuses.get("planner"))
        if state.fresh:
            mode = state.sample.mode.name.replace("ROBOT_", "").replace("_", " ").lower()
            phase = plan.sample.phase if plan.fresh else "no plan"
            self._state.content = f"robot: **{mode}** · planner: **{phase}** · {1e-9 * state.sample.header.time_ns:.0f} s"
        else:
            self._state.content = "**nothing is heard of the robot**"
        rows = ["| | | Hz |", "| --- | --- | ---: |"]
        for name, status in self._statuses.items():
            word = status.state.name.replace("SERVICE_", "").lower()
            rows.append(f"| {name} | {word}: {status.text} | {status.rate_hz:.0f} |")
        self._processes.content = "\n".join(rows)
        for plot in (self._tracking, self._solve, self._force):
            plot.show()
