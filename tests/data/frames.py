"""Writes what is no recording of frames into bad/track_frames_that_are_none, and the list of it."""

import struct
import zlib
from pathlib import Path

HERE = Path(__file__).parent / "bad/track_frames_that_are_none"
SIDE = 20
GREY = b"\x64"


def png(path, width=SIDE, bits=8, stated=None):
    """A grey picture; `stated` is the size that its header tells in place of its own."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = (b"\0" + width * (bits // 8) * GREY) * SIDE
    header = struct.pack(">IIBBBBB", *(stated or (width, SIDE)), bits, 0, 0, 0, 0)
    chunks = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunks)


def tiff(path, pages):
    """Grey pictures as pages of one file."""
    pixels = SIDE * SIDE * GREY
    tags = [(256, SIDE), (257, SIDE), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, SIDE), (279, len(pixels))]
    file, size = b"II*\0" + struct.pack("<I", 8 + len(pixels)) + pixels, 2 + 12 * len(tags) + 4
    for page in range(pages):
        after = len(file) + size if page + 1 < pages else 0
        entries = [struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags]
        file += struct.pack("<H", len(tags)) + b"".join(entries) + struct.pack("<I", after)
    path.write_bytes(file)


def folder(name, frames=5):
    path = HERE / name
    path.mkdir(parents=True, exist_ok=True)
    for frame in range(frames):
        png(path / f"f{frame}.png")
    return path


(folder("empty", 0) / "notes").write_text("notes")
(folder("of_a_video", 0) / "fall.AVI").write_text("a video")
(folder("of_a_kind_not_read", 0) / "old.bmp").write_text("BM")
folder("one", 1)
folder("without_sphere", 8)
(folder("broken") / "f3.png").write_text("no PNG")
png(folder("of_two_sizes") / "f3.png", width=24)
png(folder("of_two_depths") / "f3.png", bits=16)
png(folder("of_a_stated_size") / "f0.png", stated=(65536, 65536))
(folder("of_two_formats") / "f9.gif").write_text("GIF89a")
for frame in range(5):
    tiff(folder("of_pages", 0) / f"f{frame}.tif", 1)
tiff(folder("of_pages", 0) / "pages.tif", 5)
(HERE / "broken.tif").write_text("II*")
tiff(HERE / "one_page.tif", 1)
png(HERE / "alone.png")
(HERE / "notes").write_text("notes")
KEPT = ["args.txt", "expected.txt", "recordings.csv"]
names = sorted(path.name for path in HERE.iterdir() if path.name not in KEPT)
rows = [f"{name},PTFE,dry,4,,1000" for name in ["nowhere", "of_a_video/fall.AVI", *names]]
header = "file,particle,liquid,diameter_mm,film_um,frame_rate_Hz"
(HERE / "recordings.csv").write_text("\n".join([header, *rows]) + "\n")
