"""What the cameras see, with what vision found in it.

No topic has images: vision's virtual cameras are rendered from sim/scene, and so are these pictures, by the same code, while
somebody looks at them. On them stand the pixels of object/detection."""

from __future__ import annotations

import os
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

Picture = npt.NDArray[np.uint8]
Colour = Tuple[int, int, int]

RATE_HZ = 4.0
WIDTH_PX = 480  # of a picture at most
SILENT_S = 1.0
EXPOSURES = 16  # that are kept until vision has said what it found in them
LEAST_NICE = 19
DARK = 40
USED, REJECTED = (40, 220, 80), (220, 50, 50)
THICK_PX, CROSS_PX = 1.0, 9.0


def mark(picture: Picture, u_px: float, v_px: float, radius_px: float, binning: float, colour: Colour) -> None:
    """Draws a detection into the picture: its outline, a cross where it has none.

    u_px, v_px, radius_px: in the full image, of which `binning` pixels make one of the picture; (0, 0) is the middle of the first."""
    u, v = ((np.array([u_px, v_px]) + 0.5) / binning - 0.5).tolist()
    radius = radius_px / binning if radius_px > 0.0 else CROSS_PX
    rows, columns = np.ogrid[: picture.shape[0], : picture.shape[1]]
    if radius_px > 0.0:
        on = np.abs(np.hypot(columns - u, rows - v) - radius) <= THICK_PX
    else:
        across = (np.abs(rows - v) <= THICK_PX) & (np.abs(columns - u) <= radius)
        on = across | ((np.abs(columns - u) <= THICK_PX) & (np.abs(rows - v) <= radius))
    picture[on] = colour


def words_of(detections: Sequence[Any], names: Sequence[str]) -> str:
    """What a camera found, object by object."""
    said = []
    for seen in detections:
        name = names[seen.object_index] if seen.object_index < len(names) else f"object {seen.object_index}"
        said.append(f"{name}: " + (f"{seen.u_px:.0f}, {seen.v_px:.0f} px" if seen.found else "not found")
                    + (" (rejected)" if seen.found and not seen.used else ""))
    return "; ".join(said)


class Cameras:
    """A panel of the page: a picture for each camera of the scenario, a few times a second, while its box is ticked and a
    browser is there. follow() is called with the page's period; rendering is a thread's of its own, of the lowest priority.

    scene: {"cameras": [{"name", "width_px", "height_px"}], "file", "overrides", "seed", "objects"}, as `c3rt view` writes it.
    make: of the renderer, for tests; else c3rt's virtual cameras."""

    def __init__(self, server: Any, client: Any, scene: Dict[str, Any], make: Optional[Callable[[], Any]] = None) -> None:
        self._server, self._client = server, client
        self._cameras: List[Dict[str, Any]] = scene.get("cameras", [])
        self._names = [body["name"] for body in scene["objects"]]
        self._make = make or (lambda: _renderer(scene))
        self._readers: Optional[Tuple[Any, Any]] = None
        self._exposures: Dict[int, Any] = {}
        self._seen: Dict[Tuple[int, int], Any] = {}
        self._heard = self._next = -np.inf
        self._work: Optional[Tuple[Any, List[Any]]] = None  # of the thread: a scene, and what was found in it
        self._wake = threading.Condition()
        self._ended = False
        self._failure = ""  # of the thread: why there are no pictures
        self._thread: Optional[threading.Thread] = None
        with server.gui.add_folder("Cameras"):
            if not self._cameras:
                server.gui.add_markdown("This scenario has no cameras: vision is given the objects' poses with noise "
                                        "(`vision.source: emulated`).")
                return
            self._box = server.gui.add_checkbox("Show what they see", False)
            self._text = server.gui.add_markdown("")
            self._pictures: List[Any] = []
            self._found: List[Any] = []
            for camera in self._cameras:
                self._pictures.append(server.gui.add_image(_blank(camera), label=camera["name"], format="jpeg", visible=False))
                self._found.append(server.gui.add_markdown("", visible=False))

    @property
    def shown(self) -> bool:
        """Whether somebody looks."""
        return bool(self._cameras) and bool(self._box.value) and len(self._server.get_clients()) > 0

    def follow(self) -> None:
        now = time.monotonic()
        if not self.shown:
            self._close()
            return
        if now < self._next:
            return
        self._next = now + 1.0 / RATE_HZ
        if self._readers is None:
            # detections of two exposures; of these and of the scenes no more is kept than is shown
            self._readers = (self._client.reader("object/detection", 2 * len(self._cameras) * max(len(self._names), 1)),
                             self._client.reader("sim/scene", EXPOSURES))
            self._heard = now
        detections, scenes = self._readers
        for seen in detections.take():
            self._seen[seen.camera, seen.object_index] = seen
        for scene in scenes.take():
            if scene.exposure:
                self._exposures[scene.header.time_ns] = scene
                self._heard = now
        while len(self._exposures) > EXPOSURES:
            del self._exposures[next(iter(self._exposures))]
        if now - self._heard > SILENT_S:
            self._text.content = "Nobody writes `sim/scene`, of which these pictures are made: what vision found is on dark ones."
            self._draw(None, list(self._seen.values()))
        elif self._exposures:
            self._text.content = self._failure
            with self._wake:
                if self._work is None:  # else the last ones are still being drawn
                    self._work = self._newest()
                    self._wake.notify()
            if self._thread is None:
                self._thread = threading.Thread(target=self._render, name="cameras", daemon=True)
                self._thread.start()

    def stop(self) -> None:
        with self._wake:
            self._ended = True
            self._wake.notify()
        if self._thread is not None:
            self._thread.join()

    def _newest(self) -> Tuple[Any, List[Any]]:
        """What vision found last and the exposure in which it did; the newest exposure alone where that is long ago."""
        newest = max(self._exposures)
        told = max((seen.exposure_ns for seen in self._seen.values()), default=None)
        if told is None or newest - told > 1e9 * SILENT_S:
            return self._exposures[newest], []
        # a replay at another rate gives the times of both topics by a clock that is not theirs
        at = min(self._exposures, key=lambda time_ns: abs(time_ns - told))
        return self._exposures[at], [seen for seen in self._seen.values() if seen.exposure_ns == told]

    def _close(self) -> None:
        if self._readers is None:
            return
        for reader in self._readers:
            reader.close()
        self._readers = None
        self._exposures.clear()
        self._seen.clear()
        for handle in (*self._pictures, *self._found):
            handle.visible = False
        self._text.content = ""

    def _render(self) -> None:
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), LEAST_NICE)
        try:
            renderer = self._make()
        except Exception as error:  # no OSMesa, a scenario of another host: the page goes on without
            self._failure = f"The pictures cannot be made: {error}"
            renderer = None
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._ended or self._work is not None)
                if self._ended:
                    return
                scene, detections = self._work  # type: ignore[misc]
            self._draw(renderer and (renderer, scene), detections)
            with self._wake:
                self._work = None

    def _draw(self, rendered: Optional[Tuple[Any, Any]], detections: List[Any]) -> None:
        pictures = [_blank(camera) for camera in self._cameras]
        if rendered is not None:
            renderer, scene = rendered
            renderer.expose(scene.q_rad, [[*body.p_WB_m, *body.q_WB] for body in scene.objects[: scene.object_count]])
            pictures = [renderer.picture(index) for index in range(len(self._cameras))]
        for index, camera in enumerate(self._cameras):
            of_camera = sorted((seen for seen in detections if seen.camera == index), key=lambda seen: seen.object_index)
            for seen in of_camera:
                if seen.found:
                    mark(pictures[index], seen.u_px, seen.v_px, seen.radius_px, camera["width_px"] / pictures[index].shape[1],
                         USED if seen.used else REJECTED)
            self._pictures[index].image = pictures[index]
            self._found[index].content = words_of(of_camera, self._names) or "nothing told"
            self._pictures[index].visible = self._found[index].visible = True


def _blank(camera: Dict[str, Any]) -> Picture:
    width = min(WIDTH_PX, camera["width_px"])
    return np.full((round(width * camera["height_px"] / camera["width_px"]), width, 3), DARK, np.uint8)


def _renderer(scene: Dict[str, Any]) -> Any:
    from c3rt._cameras import Cameras as VirtualCameras

    return VirtualCameras(scene["file"], scene["overrides"], scene["seed"], WIDTH_PX)
