"""A planner of one's own: it rolls the ball along a line with the library's solver, 100 times a second (docs/clients.md)."""
import numpy as np

import c3rt
from c3rt.client import Knot, Planner

TABLE, BALL, TIP, MASS = -0.0245, 0.0315, 0.0195, 0.01  # height, radii [m], mass of the end effector in the model [kg]
ON_BALL = TABLE + 2 * BALL + TIP
Q = np.diag([1e3] * 3 + [0] * 4 + [5e5] * 2 + [0] + [10] * 3 + [0.1] * 6)  # end effector, turn, ball, their velocities


class Roller(Planner):
    """Rolls the ball for 0.9 s, returns behind it in 0.5 s, and so on."""

    rate_hz, phase, began, solver = 100.0, "approach", None, None
    model = c3rt.PlanningModel("rolling_ball", end_effector_mass_kg=MASS, end_effector_radius_m=TIP, ball_mass_kg=0.132,
                               ball_radius_m=BALL, table_height_m=TABLE, friction_end_effector=1, friction_table=1)

    def plan(self, now):
        if 0 not in now.objects:
            return None
        ball, tip = now.objects[0], now.effector
        part = 0.0 if self.began is None else (now.time - self.began) % 1.4
        if part < 0.5:  # up, behind the ball, and down
            behind = tip.p[:2] if self.began and part < 0.15 else ball.p[:2] + [0, 0.02]
            way = np.array([*behind, ON_BALL + (0.03 if part < 0.35 else 0.0)]) - tip.p
            if self.began is None and np.linalg.norm(way) < 0.005:
                self.began, self.phase = now.time, "roll"
            pace = way / max(np.linalg.norm(way), 0.02)
            return Knot(tip.p + 0.02 * pace, 0.2 * pace)
        scene = dict(effector=tip.p, effector_velocity=tip.v, positions=[ball.p + ball.age * ball.v], orientations=[ball.q],
                     velocities=[ball.v], rates=[ball.omega], contact_model="stewart_trinkle")
        lcs = self.model.lcs(**scene, step=0.1)
        scale = (lcs.A**2).sum() / (lcs.D**2).sum()  # forces as large as states
        lcs = c3rt.LCS(lcs.A, lcs.B, lcs.D * scale, lcs.d, lcs.E / scale, lcs.F, lcs.H / scale, lcs.c / scale)
        x = self.model.state(**{key: value for key, value in scene.items() if key != "contact_model"})
        goal = np.r_[ball.p[:2], ON_BALL + 0.004, np.zeros(4), 0.55, ball.p[1] - 0.035, np.zeros(10)]
        if self.solver is None:
            n = 22 + lcs.n_lambda
            self.solver = c3rt.Solver(c3rt.Problem(lcs, x, projection="MIQP", N=5, s=2, rho=1, rho_s=3, Q=Q, QN=Q, xd=goal,
                                                   R=0.01 * np.eye(3), G=0.01 * np.eye(n),
                                                   U=np.diag([100] * 19 + [1] * (n - 19))))
        u = self.solver.solve(x, lcs=lcs, xd=goal).u[0]
        x_next, _ = self.model.lcs(**scene, step=0.01).step(x, u)  # Algorithm 3: where the model is after a period
        force = MASS * ((x_next[10:13] - tip.v) / 0.01 + [0, 0, 9.81]) - u  # of the ball on the end effector
        return Knot(x_next[:3], x_next[10:13], force=force)


if __name__ == "__main__":
    Roller().main()
