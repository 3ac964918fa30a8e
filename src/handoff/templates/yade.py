# -*- coding: utf-8 -*-
# YADE: {{heading}}
# YADE takes one e a pair of materials, whatever the speed or St, through a MatchMaker; a plain number is for every pair
# Hertz-Mindlin contact: the force never pulls (Ip2_FrictMat_FrictMat_MindlinPhys, Law2_ScGeom_MindlinPhys_Mindlin). betan, in
# closed form, is {{beta_plate}} for the e asked for; the formula for a contact that may pull would give {{pulling}} for it
# en={{e_5}} in its place is turned into betan by an approximation, which in 2023.02a is right to 4e-4 for e of 0.05 to 0.925, and
# makes 0.948 of 0.95 and 0.969 of 0.975. Give en or betan, not both
# ViscElMat with en takes the ARITHMETIC MEAN of both materials' en as that of the pair: give pairs there by a MatchMaker too
{% if dry %}
# Dry: versions after 2023.02a have vn, and en={{e_5}}, vn={{speed}} is a contact whose e falls with the speed; not run here
{% endif %}
# Run: yade -x -n {{file}}   or with speeds in m/s: yade -x -n {{file}} 0.6 0.9 1.2
import sys

from yade import *
from yade import utils

# asked for: sphere on plate, two spheres
E_PLATE = {{e}}
E_PAIR = {{pair}}
# damping ratios that give it
BETA_PLATE = {{beta_plate}}
BETA_PAIR = {{beta_pair}}
SPEED = {{speed}}  # m/s
RADIUS = {{radius}}  # m
DENSITY = {{density}}  # kg/m3
YOUNG = {{young}}  # Pa, for this test's time step: e does not depend on it
POISSON = {{poisson}}
STEP = {{step}}  # s


def contact(sphere, plate):
    """The contact of materials by their numbers, each pair with its own damping."""
    pairs = ((sphere, plate, BETA_PLATE), (sphere, sphere, BETA_PAIR))
    # betas given too: left out, the shear damping would be the normal one
    return Ip2_FrictMat_FrictMat_MindlinPhys(
        betan=MatchMaker(matches=pairs, algo='val', val=BETA_PLATE),
        betas=MatchMaker(matches=(), algo='val', val=0.0),
    )


def ball(height, speed, material):
    """A sphere at a height, moving upwards."""
    body = O.bodies[O.bodies.append(utils.sphere((0, 0, height), RADIUS, material=material))]
    body.state.vel = (0, 0, speed)
    return body.state


def rebounds(speed):
    """e of one sphere launched just above the plate and of two that meet away from it, without gravity."""
    O.reset()
    sphere = O.materials.append(FrictMat(young=YOUNG, poisson=POISSON, frictionAngle=0, density=DENSITY))
    plate = O.materials.append(FrictMat(young=YOUNG, poisson=POISSON, frictionAngle=0, density=DENSITY))
    O.bodies.append(utils.wall(0.0, axis=2, material=plate))
    dropped = ball({{start}}, -speed, sphere)
    upper, lower = ball({{upper}}, -speed / 2, sphere), ball({{lower}}, speed / 2, sphere)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * RADIUS),
        InteractionLoop(
            [Ig2_Wall_Sphere_ScGeom(), Ig2_Sphere_Sphere_ScGeom()],
            [contact(sphere, plate)],
            [Law2_ScGeom_MindlinPhys_Mindlin()],
        ),
        NewtonIntegrator(damping=0, gravity=(0, 0, 0)),
    ]
    O.dt = STEP
    for _ in range(50):
        O.run(2000, True)
        if dropped.pos[2] > RADIUS and dropped.vel[2] > 0 and upper.pos[2] - lower.pos[2] > 2 * RADIUS and upper.vel[2] > 0:
            break
    return dropped.vel[2] / speed, (upper.vel[2] - lower.vel[2]) / speed


for text in sys.argv[1:] or [str(SPEED)]:
    on_plate, of_two = rebounds(float(text))
    print('sphere on plate at %s m/s: e asked %.6f, e measured %.6f' % (text, E_PLATE, on_plate))
    print('two spheres at %s m/s: e asked %.6f, e measured %.6f' % (text, E_PAIR, of_two))
