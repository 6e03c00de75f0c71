"""Makes the files of this folder: 30 boxes thrown onto a floor by PyBullet at 4000 steps/s, z up.

poses.parquet has their poses 1000 times a second, impacts.csv the contact impulses of the log: pushes of one body
with an approach above 0.1 m/s, those within 3 ms summed. pip install pybullet numpy pyarrow
"""
import numpy as np
import pybullet as bullet
import pyarrow as pa
import pyarrow.parquet as pq

STEP, DURATION, BOXES, EVERY = 1 / 4000, 1.2, 30, 4
SLOWEST, WINDOW, GRAVITY = 0.1, 0.003, 9.80665


def world():
    rng = np.random.default_rng(1)
    bullet.connect(bullet.DIRECT)
    bullet.setGravity(0, 0, -GRAVITY)
    bullet.setPhysicsEngineParameter(fixedTimeStep=STEP, numSubSteps=0, restitutionVelocityThreshold=0.02, contactSlop=1e-5)
    floor = bullet.createMultiBody(0, bullet.createCollisionShape(bullet.GEOM_PLANE))
    surface = dict(restitution=0.5**0.5, lateralFriction=0.5**0.5)
    bullet.changeDynamics(floor, -1, **surface)
    bodies = []
    for i in range(BOXES):
        half = rng.uniform(0.015, 0.04, 3)
        turn = rng.normal(size=4)
        shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half)
        place = [(i % 5) * 0.12 - 0.25, (i // 5 % 2) * 0.12, 0.12 + 0.1 * (i // 5)]
        body = bullet.createMultiBody(2500 * 8 * half.prod(), shape, basePosition=place, baseOrientation=turn / np.linalg.norm(turn))
        bullet.resetBaseVelocity(body, [0, 0, 0], rng.normal(size=3) * 4)
        bullet.changeDynamics(body, -1, linearDamping=0, angularDamping=0, rollingFriction=0, spinningFriction=0, **surface)
        bodies.append((body, half))
    return bodies


def main():
    bodies = world()
    mass = [bullet.getDynamicsInfo(body, -1)[0] for body, _ in bodies]
    poses, pushes = [], [{} for _ in bodies]
    for k in range(int(DURATION / STEP)):
        states = [bullet.getBasePositionAndOrientation(body) + bullet.getBaseVelocity(body) for body, _ in bodies]
        if k % EVERY == 0:
            poses += [(k * STEP, i, *s[0], *s[1]) for i, s in enumerate(states)]
        bullet.stepSimulation()
        for contact in bullet.getContactPoints():
            a, b, point, normal, force = contact[1] - 1, contact[2] - 1, np.array(contact[5]), np.array(contact[7]), contact[9]
            if force <= 0:
                continue
            impulse = (normal * force + np.array(contact[11]) * contact[10] + np.array(contact[13]) * contact[12]) * STEP
            speed = lambda i: np.array(states[i][2]) + np.cross(states[i][3], point - states[i][0]) if i >= 0 else 0
            approach = -float(np.dot(speed(a) - speed(b), normal))
            for i, sign in ((a, 1), (b, -1)):
                if i >= 0:
                    push = pushes[i].setdefault(k, [np.zeros(3), 0.0])
                    push[0] += sign * impulse
                    push[1] = max(push[1], approach)
    names = ["t", "body"] + [f"position_{c}" for c in "xyz"] + [f"orientation_{c}" for c in "xyzw"]
    kinds = [pa.float64(), pa.int32()] + [pa.float32()] * 7
    columns = [pa.array(column, kind) for column, kind in zip(zip(*poses), kinds)]
    pq.write_table(pa.table(dict(zip(names, columns))), "poses.parquet", compression="brotli", compression_level=11)
    with open("impacts.csv", "w") as out:
        out.write("body,first,last,impulse_x,impulse_y,impulse_z\n")
        for i, steps in enumerate(pushes):
            current = None
            for k in sorted(steps):
                impulse, approach = steps[k]
                if approach < SLOWEST or np.linalg.norm(impulse) < 3 * mass[i] * 9.8 * STEP:
                    continue
                if current and k * STEP - current[1] <= WINDOW:
                    current[1], current[2] = k * STEP, current[2] + impulse
                else:
                    if current:
                        out.write(row(i, current))
                    current = [k * STEP, k * STEP, impulse.copy()]
            if current:
                out.write(row(i, current))
    with open("boxes.toml", "w") as out:
        out.write('version = 1\n[simulation]\nv_min = 0.1\n[material.stone]\nbase = "granite"\ndensity = 2500.0\n')
        for i, (_, half) in enumerate(bodies):
            size = "x".join(repr(float(2 * h)) for h in half)
            out.write(f'[[body]]\nname = "box-{i}"\nshape = "box:{size}"\nmaterial = "stone"\n')
            out.write(f"position = [{i % 6 * 0.3:.1f}, {1 + i // 6 * 0.3:.1f}, 0.0]\n")
        out.write('[[plane]]\nname = "floor"\nmaterial = "granite"\n')


def row(body, current):
    first, last, impulse = current
    return f"{body},{first:.5f},{last:.5f},{impulse[0]:.6g},{impulse[1]:.6g},{impulse[2]:.6g}\n"


main()
