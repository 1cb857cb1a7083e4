"""Sliders for the weights of Algorithm 1, where the scenario allows others than its own."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, List, Mapping, Optional

import numpy as np

DECADES_STEP = 0.05
WHAT = "Powers of ten of the scenario's own."
NOT_ALLOWED = "This scenario allows no others than its own; with `--set planner.weights.adjustable_by=100` it does."


class Weights:
    """A panel of the page: a slider for each weight, in decades of the scenario's value. What is moved is asked of the planner
    by a thread of its own, all that has moved since the last answer at once.

    scene: {"weights": [{"name", "value", "min", "max"}]}, as `c3rt view` writes it.
    ask: gives the planner weights by name, none of them: the scenario's; returns the answer in words."""

    def __init__(self, server: Any, scene: Mapping[str, Any], ask: Callable[[Dict[str, float]], str]) -> None:
        self._ask = ask
        self._own: Dict[str, Dict[str, Any]] = {weight["name"]: weight for weight in scene.get("weights", [])}
        self._sliders: Dict[str, Any] = {}
        self._asked: Dict[str, float] = {}  # what each slider stood at when it was last looked at
        self._moved: Optional[Dict[str, float]] = {}  # since the last answer; None: back to the scenario's
        self._changed = threading.Condition()
        self._ended = False
        self._pid: Optional[int] = None
        gui = server.gui
        with gui.add_folder("Weights", expand_by_default=False):
            self._answer = gui.add_markdown(WHAT if self._own else NOT_ALLOWED)
            if not self._own:
                return
            gui.add_button("The scenario's weights").on_click(lambda _: self.give_back())
            for phase in dict.fromkeys(name.split(".", 1)[0] for name in self._own):
                with gui.add_folder(f"Phase {phase}", expand_by_default=False):
                    for name, weight in self._own.items():
                        if name.startswith(phase + "."):
                            self._add(gui, name, weight)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        with self._changed:
            self._ended = True
            self._changed.notify()

    def follow(self, planner: Any) -> None:
        """planner: the newest status of the planner, None where none was heard. One that was started anew has the scenario's
        weights."""
        if planner is None or not self._own:
            return
        if self._pid is not None and planner.pid != self._pid:
            self._centre()
            self._answer.content = "The planner was started anew: the weights are the scenario's."
        self._pid = planner.pid

    def give_back(self) -> None:
        self._centre()
        with self._changed:
            self._moved = None
            self._changed.notify()

    def _add(self, gui: Any, name: str, weight: Mapping[str, float]) -> None:
        low, high = (round(float(np.log10(weight[end] / weight["value"])), 9) for end in ("min", "max"))
        # a browser's slider counts its steps from its least value, and 0 has to be one of them
        steps = max(1, round((high - low) / DECADES_STEP / 2) * 2)
        slider = gui.add_slider(name.split(".", 1)[1], min=low, max=high, step=(high - low) / steps, initial_value=0.0,
                                hint=f"{weight['value']:g} times a power of ten, from {weight['min']:g} to {weight['max']:g}")
        self._sliders[name], self._asked[name] = slider, 0.0
        slider.on_update(lambda _, name=name: self._take(name))

    def _take(self, name: str) -> None:
        at, weight = float(self._sliders[name].value), self._own[name]
        if at == self._asked[name]:
            return  # set by the page itself
        self._asked[name] = at
        with self._changed:
            self._moved = self._moved or {}
            self._moved[name] = float(np.clip(weight["value"] * 10.0**at, weight["min"], weight["max"]))
            self._changed.notify()

    def _centre(self) -> None:
        with self._changed:
            self._moved = {}
        for name, slider in self._sliders.items():
            self._asked[name] = 0.0
            slider.value = 0.0

    def _serve(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or self._moved is None or len(self._moved) > 0)
                if self._ended:
                    return
                wanted, self._moved = self._moved or {}, {}
            for some in _by_sample(wanted):
                self._answer.content = self._ask(some)


def _by_sample(weights: Dict[str, float]) -> List[Dict[str, float]]:
    """As many at once as a sample has room for; none is one question, too."""
    from c3rt.v2 import MAX_WEIGHTS

    names = list(weights)
    return [{name: weights[name] for name in names[i : i + MAX_WEIGHTS]} for i in range(0, max(1, len(names)), MAX_WEIGHTS)]
