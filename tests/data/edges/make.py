#!/usr/bin/env python3
"""Makes the pictures in this folder, and what OpenCV finds in them.

    pip install opencv-python-headless numpy scikit-image pillow
    python3 make.py FILM     # all: FILM is a clip of "Big Buck Bunny" of 1280 x 720 pixels
    python3 make.py          # only what OpenCV finds in the pictures that are there

`NAME-png.edges.png` has, for each pixel of `NAME.png` (or -jpg of .jpg) as `cv2.imread(..., IMREAD_GRAYSCALE)` reads it, the sum of

    128  where Canny(image, 150, 450) has an edge
     64  where Canny(image, 50, 100) has one
     32  where Canny(GaussianBlur(image, (0, 0), 1.4), 40, 120) has one
"""

import struct
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

HERE = Path(__file__).parent
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def insert(name, *chunks):
    """Puts chunks after the header of a PNG."""
    path = HERE / name
    data = path.read_bytes()
    path.write_bytes(data[:33] + b"".join(chunks) + data[33:])


def interlaced(name, gray):
    """Writes a gray PNG in seven passes."""
    passes = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
    rows = b"".join(b"\0" + row.tobytes() for x, y, dx, dy in passes for row in gray[y::dy, x::dx])
    header = struct.pack(">IIBBBBB", gray.shape[1], gray.shape[0], 8, 0, 0, 0, 1)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
    (HERE / name).write_bytes(SIGNATURE + body)


def frames(film, numbers):
    video, found = cv2.VideoCapture(film), {}
    for number in range(max(numbers) + 1):
        read, frame = video.read()
        assert read, f"{film} has only {number} frames"
        if number in numbers:
            found[number] = Image.fromarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB))
    return found


def bunnies(film):
    frame = frames(film, [0, 30, 45, 60, 75, 90, 120])
    small = {number: picture.resize((640, 360), Image.LANCZOS) for number, picture in frame.items()}
    save = lambda name, picture, **options: picture.save(HERE / name, **options)
    save("bunny-gray.png", small[0].convert("L").crop((120, 40, 440, 280)), optimize=True)
    save("bunny-colour.png", small[30].crop((200, 60, 440, 240)), optimize=True)
    save("bunny-16-colours.png", small[45].crop((120, 40, 440, 280)).quantize(16), optimize=True)
    save("bunny-4-2-0.jpg", small[60], quality=85)
    save("bunny-progressive.jpg", small[75], quality=80, progressive=True)
    save("bunny-gray.jpg", small[90].convert("L"), quality=85)
    save("bunny-restarts.jpg", small[120], quality=85, subsampling=0, restart_marker_blocks=16)


def others():
    from skimage import data

    picture = lambda name: Image.fromarray(getattr(data, name)())
    save = lambda name, picture, **options: picture.save(HERE / name, **options)
    save("camera.png", picture("camera").crop((140, 40, 380, 280)), optimize=True)
    deep = data.camera()[300:440, 120:300].astype(np.uint16) * 257
    cv2.imwrite(str(HERE / "camera-16-bits.png"), deep + (np.arange(deep.size, dtype=np.uint16) * 37 % 200).reshape(deep.shape))
    save("astronaut.png", picture("astronaut").crop((100, 0, 290, 160)), optimize=True)
    insert("astronaut.png", chunk(b"sRGB", b"\0"))
    save("chelsea.png", picture("chelsea").crop((100, 60, 300, 220)).convert("RGBA"), optimize=True)
    insert("chelsea.png", chunk(b"gAMA", struct.pack(">I", 60000)))
    save("text.png", picture("text").crop((0, 0, 300, 160)), optimize=True)
    interlaced("horse.png", np.where(data.horse(), 255, 0).astype(np.uint8))
    save("coins.png", picture("coins").crop((0, 0, 240, 200)), optimize=True)
    save("grass.png", picture("grass").crop((0, 0, 120, 120)), optimize=True)
    save("gravel.png", picture("gravel").crop((0, 0, 150, 121)), optimize=True)
    exif = Image.Exif()
    exif[0x0112] = 6
    save("coffee-turned.jpg", picture("coffee"), quality=85, exif=exif)
    save("rocket.jpg", picture("rocket").crop((160, 0, 480, 427)), quality=90)
    save("retina.jpg", picture("retina").crop((100, 100, 460, 400)), quality=95)
    save("hubble-without-luma.jpg", picture("hubble_deep_field").crop((0, 0, 220, 200)), quality=85, keep_rgb=True)


def masks():
    for path in sorted(HERE.iterdir()):
        if path.suffix not in (".png", ".jpg") or path.name.endswith(".edges.png"):
            continue
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        blurred = cv2.GaussianBlur(image, (0, 0), 1.4)
        sets = [cv2.Canny(image, 150, 450) & 128, cv2.Canny(image, 50, 100) & 64, cv2.Canny(blurred, 40, 120) & 32]
        name = f"{path.name.replace('.', '-')}.edges.png"
        cv2.imwrite(str(HERE / name), sum(sets), [cv2.IMWRITE_PNG_COMPRESSION, 9])
        print(path.name, image.shape[::-1], *(np.count_nonzero(found) for found in sets))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        bunnies(sys.argv[1])
        others()
    masks()
