"""Follow one gait with the exact and with the implicit model, and see the error of its springs."""

import math

import numpy as np
import serpenoid as sn

robot, ground = sn.Robot(3, 1.0, 0.12), sn.Ground(ct=0.1, cn=10.0)
gait = sn.Gait(math.radians(30), math.radians(90), 3.0)
exact = sn.simulate(sn.Scene(robot, ground, gait, duration_s=5.0))
for stiffness in (1e3, 1e4, 1e5):
    soft = sn.simulate(
        sn.Scene(
            robot,
            ground,
            gait,
            formulation="implicit",
            joint_stiffness_n_m=stiffness,
            dt_s=1e-4,
            record_every=10,
            duration_s=5.0,
        )
    )
    apart = np.abs(soft.theta_rad - exact.theta_rad).max()
    print(f"k = {stiffness:8.0f} N/m: angles differ by up to {apart:.1e} rad")
