"""Writes one fall onto a plate, v = 1 m/s and e = 0.6 at 0.1 s, as other programs write positions, and the list of them."""

from pathlib import Path

HERE = Path(__file__).parent
GRAVITY = 9.81


def height(time):
    before = 0.1 - time
    if before >= 0.0:
        return before - 0.5 * GRAVITY * before * before
    start, speed = 0.1, 0.6
    while time >= start + 2.0 * speed / GRAVITY:
        start += 2.0 * speed / GRAVITY
        speed *= 0.6
    return speed * (time - start) - 0.5 * GRAVITY * (time - start) ** 2


FRAMES = [(frame, frame / 1000, height(frame / 1000)) for frame in range(200)]


def rows(line):
    return "".join(line(*seen) + "\n" for seen in FRAMES)


def comma(number):
    return f"{number:.5f}".replace(".", ",")


# text, unit and axis of each
TABLES = {
    "mass A.txt": ("mass A\t\t\nt\tx\ty\n" + rows(lambda _, t, y: f"{t}\t0.001\t{y:.7f}"), "m", ""),
    "a(1).txt": ("Masse A\t\t\nt\tx\ty\n" + rows(lambda _, t, y: f"{comma(t)}\t0,001\t{comma(y)}"), "m", ""),
    "v=0.5.csv": (
        ",y,x,mass,frame,particle\n" + rows(lambda n, _, y: f"{n},{900 - 20_000 * y:.4f},88.2,5021.1,{n},0"),
        "px",
        "",
    ),
    "spots.csv": (
        "LABEL,TRACK_ID,POSITION_Y,FRAME\nLabel,Track ID,Y,Frame\n,,(mm),\n"
        + rows(lambda n, _, y: f"ID{n},0,{95 - 1e3 * y:.4f},{n}"),
        "mm",
        "down",
    ),
}

listed = "file,particle,liquid,diameter_mm,film_um,frame_rate_Hz,y_unit,y_axis\n"
for name, (text, unit, axis) in TABLES.items():
    (HERE / name).write_text(text, encoding="utf-8")
    listed += f'"{name}",PTFE,dry,4.762,,1000,{unit},{axis}\n'
(HERE / "recordings.csv").write_text(listed, encoding="utf-8")
