"""Simulate the 2005 robot from rest, wheels sticking and slipping, and draw its path."""

import math

import serpenoid as sn
from matplotlib.figure import Figure

robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
gait = sn.Gait(math.radians(70), math.radians(75), 5.0)
run = sn.simulate(sn.Scene(robot, ground, gait, method="nonsmooth", start="zero_momentum"))
x, y = run.centre_m.T
print(f"{run.travel_m:.3f} m away after {run.t_s[-1]:g} s")

figure = Figure(figsize=(6, 4.5), layout="constrained")
ax = figure.subplots()
ax.plot(run.x_m[:, -1], run.y_m[:, -1], label="head")
ax.plot(x, y, color="black", label="centre of mass")
ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title="2005 robot, from rest, 10 s")
ax.legend(frameon=False)
figure.savefig("path.png", dpi=160)
print("drawn in path.png")
