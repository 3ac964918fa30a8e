"""Drops spheres on a wall in YADE, each new contact damped by a law at the speed it begins with, and prints e.

    WETCOR_LIBRARY=…/libwetcor.so yade -x -n capi/tests/yade_contacts.py

prints a line for each sphere: contact model, how the damping was set, law, speed in m/s, e of the law, e found.

YADE makes a contact and computes its first force within one engine, so that its damping can be set only after that force.
Contacts are therefore made without damping (cn or betan 0) and damped from the second step on, the speed being that of
the sphere before the first force. What the first step lacks is at most 2 γ ω dt of the speed, below 2.3e-3 of it or
5e-4 in e at the steps taken here, 2,000 or more to a contact. With YADE's own en or cn in place of 0 the first force
would be damped by that.

Beside the treatment stand two faults that must be seen: damping that is not set, and the law taken at half the speed.
"""

import math
import os
import sys

from yade import *

sys.path.insert(0, os.path.dirname(os.path.abspath(sys.argv[0])))
from wetcor_ctypes import law, restitution

RADIUS, DENSITY = 2.381e-3, 2150.0
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
STEPS_A_CONTACT = 2000
HEADER = b"particle,liquid,law,alpha,beta_m_s,kappa_m2_s2,min_speed_m_s,max_speed_m_s,quotable"
# each with the speeds from e = 0.2 on that spheres are dropped with
LAWS = {
    "reference": (law("wetcor_law_from_csv", HEADER, b"PTFE,M50,reference,0.53,-0.31,,,,true"), 0.64, 4.0),
    "impact": (law("wetcor_law_impact", 0.183, 1, 0.06, -0.11, 0.0), 0.168, 4.0),
    "dry": (law("wetcor_law_dry", 0.31, 2), 0.05, 4.0),
}
SPEEDS = 8
TREATMENTS = {"set": 1.0, "unset": None, "half": 0.5}


def damping_ratio(e):
    """Share of the critical damping of a linear contact that ends where its force does (Schwager & Pöschel 2007)."""

    def of_ratio(ratio):
        root = math.sqrt(1.0 - ratio * ratio)
        return math.exp(-ratio / root * (math.pi - math.atan2(2.0 * ratio * root, 1.0 - 2.0 * ratio * ratio)))

    low, high = 0.0, 1.0 - 1e-12
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if of_ratio(middle) > e else (low, middle)
    return low


def betan(e):
    """The same of a Hertzian contact, betan of YADE (Thornton, Cummins & Cleary 2013, eq. B6)."""
    terms = [-6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757, -1489.915]
    exponent = 0.0
    for term in reversed(terms):
        exponent = e * (term + exponent)
    return math.sqrt(1.0 / (1.0 - (1.0 + e) ** 2 * math.exp(exponent)) - 1.0)


def damp_linear(phys, e):
    phys.cn = 2.0 * damping_ratio(e) * math.sqrt(phys.kn * MASS)


def damp_hertz(phys, e):
    phys.betan = betan(e)


STIFFNESS, YOUNG, POISSON = 1e4, 1e8, 0.3
# material, what makes a contact, what computes its force, what damps it, how long it lasts at a speed, in s
MODELS = {
    "linear": (
        lambda: ViscElMat(density=DENSITY, kn=2 * STIFFNESS, ks=0.0, cn=0.0, cs=0.0, frictionAngle=0.0),
        lambda: Ip2_ViscElMat_ViscElMat_ViscElPhys(),
        lambda: Law2_ScGeom_ViscElPhys_Basic(),
        damp_linear,
        lambda speed: math.pi * math.sqrt(MASS / STIFFNESS),
    ),
    "hertz": (
        lambda: FrictMat(density=DENSITY, young=YOUNG, poisson=POISSON, frictionAngle=0.0),
        lambda: Ip2_FrictMat_FrictMat_MindlinPhys(betan=0.0, betas=0.0),
        lambda: Law2_ScGeom_MindlinPhys_Mindlin(),
        damp_hertz,
        lambda speed: 2.87 * (MASS**2 / (RADIUS * (0.5 * YOUNG / (1 - POISSON**2)) ** 2 * speed)) ** 0.2,
    ),
}


def damp_new_contacts(fallen, damp):
    """To be called at every step, between the forces and the motion."""
    for contact in O.interactions:
        if contact.iterMadeReal == O.iter:
            sphere = max(contact.id1, contact.id2)
            treatment, name, _ = fallen[sphere]
            # the normal points along z, and the wall rests
            speed = -O.bodies[sphere].state.vel[2]
            share = TREATMENTS[treatment]
            if share is not None:
                # the formulas need a rebound
                damp(contact.phys, max(restitution(LAWS[name][0], share * speed), 0.01))


for model, (material, make, force, damp, duration) in MODELS.items():
    O.reset()
    O.materials.append(material())
    O.bodies.append(wall(0.0, axis=2, sense=1))
    O.dt = duration(4.0) / STEPS_A_CONTACT
    fallen = {}
    for treatment in TREATMENTS:
        for name, (_, least, most) in LAWS.items():
            for step in range(SPEEDS):
                v = least * (most / least) ** (step / (SPEEDS - 1))
                # the first contact begins anywhere within a step
                gap = v * O.dt * (2.0 + (0.618 * len(fallen)) % 1.0)
                number = O.bodies.append(sphere((3 * RADIUS * len(fallen), 0, RADIUS + gap), RADIUS))
                O.bodies[number].state.vel = (0, 0, -v)
                fallen[number] = (treatment, name, v)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.5 * RADIUS),
        InteractionLoop([Ig2_Wall_Sphere_ScGeom()], [make()], [force()]),
        PyRunner(command="damp_new_contacts(fallen, damp)", iterPeriod=1),
        NewtonIntegrator(damping=0.0),
    ]
    # a damped contact lasts up to twice as long as an elastic one
    O.run(int(2.2 * duration(0.05) / O.dt), True)
    for number, (treatment, name, v) in fallen.items():
        found = O.bodies[number].state.vel[2] / v
        print(f"e,{model},{treatment},{name},{v:.6f},{restitution(LAWS[name][0], v):.6f},{found:.6f}")
print("done")
sys.stdout.flush()
