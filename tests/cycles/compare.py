#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares Sightline's colour pictures with those that Blender's Cycles traces of the same glTF.

compare.py SIGHTLINE FOLDER: draws a textured sphere under several lights with both, leaves the
pictures in FOLDER (ours, theirs, the difference four times over grey), prints how far they are
apart in linear light and how far the texture is shifted, and fails where that is too far. Needs
blender, numpy and OpenCV.
"""
import json
import os
import pathlib
import subprocess
import sys

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
WIDTH = 512
STEPS = 160  # of the sphere's longitude


def sphere():
    """Positions, which are normals too, coordinates on the texture, and triangles."""
    rows = STEPS // 2
    v, u = np.mgrid[0:rows + 1, 0:STEPS + 1]
    v, u = v / rows, u / STEPS
    side, azimuth = np.sin(np.pi * v), 2 * np.pi * u
    points = np.stack([side * np.cos(azimuth), np.cos(np.pi * v), -side * np.sin(azimuth)], -1)
    corner = np.arange((rows + 1) * (STEPS + 1)).reshape(rows + 1, STEPS + 1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1)[1:].reshape(-1, 3),
                                np.stack([a, c, d], -1)[:-1].reshape(-1, 3)])
    flat = lambda x: np.ascontiguousarray(x.reshape(-1, x.shape[-1]), np.float32)
    return flat(points), flat(np.stack([u, v], -1)), triangles.astype(np.uint32)


def write_texture(path):
    """Smooth random colours: a texel of 1024 x 512 is smaller than a pixel's sample."""
    random = np.random.default_rng(1)
    coarse = random.integers(0, 256, (48, 96, 3), np.uint8)
    cv2.imwrite(str(path), cv2.resize(coarse, (1024, 512), interpolation=cv2.INTER_CUBIC))


def write_gltf(path, metallic, roughness):
    points, uv, triangles = sphere()
    blobs = [points.tobytes(), points.tobytes(), uv.tobytes(), triangles.tobytes()]
    path.with_suffix(".bin").write_bytes(b"".join(blobs))
    offsets = np.cumsum([0] + [len(blob) for blob in blobs])
    accessor = lambda i, kind, count, code: {"bufferView": i, "componentType": code, "count": count, "type": kind}
    accessors = [accessor(0, "VEC3", len(points), 5126), accessor(1, "VEC3", len(points), 5126),
                 accessor(2, "VEC2", len(uv), 5126), accessor(3, "SCALAR", triangles.size, 5125)]
    accessors[0] |= {"min": points.min(0).tolist(), "max": points.max(0).tolist()}
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
                                    "indices": 3, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": metallic,
                                                "roughnessFactor": roughness}}],
        "textures": [{"source": 0}], "images": [{"uri": "texture.png"}],
        "buffers": [{"uri": path.with_suffix(".bin").name, "byteLength": int(offsets[-1])}],
        "bufferViews": [{"buffer": 0, "byteOffset": int(offsets[i]), "byteLength": len(blob)}
                        for i, blob in enumerate(blobs)],
        "accessors": accessors}))


def write_obj(path):
    """The same sphere with a dull surface: glTF's are all a little glossy."""
    points, uv, triangles = sphere()
    path.with_suffix(".mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd texture.png\n")
    lines = [f"mtllib {path.with_suffix('.mtl').name}", "usemtl paint"]
    lines += ["v {:.9g} {:.9g} {:.9g}".format(*p) for p in points]
    lines += ["vn {:.9g} {:.9g} {:.9g}".format(*p) for p in points]
    lines += ["vt {:.9g} {:.9g}".format(u, 1 - v) for u, v in uv]
    lines += ["f " + " ".join(f"{i}/{i}/{i}" for i in t + 1) for t in triangles]
    path.write_text("\n".join(lines) + "\n")


def write_panorama(path):
    """A few broad lights of several colours, up to 6 times white."""
    v, u = np.mgrid[0:128, 0:256]
    azimuth, elevation = (u + 0.5) / 256 * 2 * np.pi - np.pi, np.pi / 2 - (v + 0.5) / 128 * np.pi
    light = np.full((128, 256, 3), 0.1, np.float32)
    for centre, height, colour in [(0.5, 0.6, (1, 3, 6)), (-2, 0.1, (2, 0.5, 0.2)), (2.2, -0.8, (0.2, 0.9, 0.3))]:
        cosine = np.sin(elevation) * np.sin(height) + np.cos(elevation) * np.cos(height) * np.cos(azimuth - centre)
        light += np.float32(np.exp(12 * (cosine - 1))[..., None] * np.array(colour))
    cv2.imwrite(str(path), light)


def draw_ours(program, folder, name, mesh, settings):
    scene = folder / f"{name}.toml"
    scene.write_text(f'target = "{mesh}"\n[camera]\nwidth_px = {WIDTH}\nheight_px = {WIDTH}\nf_px = {WIDTH}\n'
                     "[[poses.fixed]]\ntheta_deg = [20, 30, 10]\nt_m = [0.1, -0.05, 2.5]\n")
    out = folder / name
    keys = {"image.colour": "rgb", "image.bits": 16, "image.samples_per_pixel": 64, "image.psf_sigma_px": 0,
            "noise.read_noise_grey": 0, "background.level": 0, "light.phase_deg": 40, "light.azimuth_deg": 30}
    command = [program, "render", str(scene), "--count", "1", "--out", str(out), "--quiet"]
    for key, value in (keys | settings).items():
        command += ["--set", f"{key}={value}"]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    picture = cv2.imread(str(out / "test/000000/rgb/000000.png"), cv2.IMREAD_UNCHANGED)
    mask = cv2.imread(str(out / "test/000000/mask/000000_000000.png"), cv2.IMREAD_UNCHANGED) > 0
    return picture / 65535, mask, out / "sightline/000000/000000.json"


def draw_theirs(folder, name, mesh, truth, kind, panorama):
    out = folder / f"{name}.exr"
    command = ["blender", "-b", "--factory-startup", "-P", str(HERE / "in_blender.py"), "--",
               str(mesh), str(truth), str(out), kind] + ([str(panorama)] if panorama else [])
    run = subprocess.run(command, capture_output=True, text=True)
    picture = cv2.imread(str(out), cv2.IMREAD_UNCHANGED)
    if picture is None:
        sys.exit(f"{name}: blender drew nothing:\n{run.stdout[-2000:]}{run.stderr[-2000:]}")
    return np.minimum(picture[..., :3].astype(float), 1)


def shift_px(ours, theirs, inside):
    """How far ours would have to move, by least squares."""
    down, right = np.gradient(theirs, axis=(0, 1))
    slopes = np.stack([right[inside].ravel(), down[inside].ravel()], -1)
    return np.linalg.lstsq(slopes, (theirs - ours)[inside].ravel(), rcond=None)[0]


# Name, our mesh, the material that Cycles has, settings, whether a panorama lights, and how far
# apart mean and RMS of the difference may be. Cycles's Principled surface is not glTF's: it is the
# same for metals alone.
CASES = [
    ("sun", "dull.obj", "dull", {"light.ambient": 0, "light.directional": 0.8}, False, (1e-4, 3e-4)),
    ("glow", "dull.obj", "dull", {"light.ambient": 0.8, "light.directional": 0}, False, (2e-4, 1e-3)),
    ("panorama", "dull.obj", "dull", {"light.ambient": 0, "light.directional": 0}, True, (3e-4, 3e-3)),
    ("metal-sun", "metal.gltf", "principled", {"light.ambient": 0, "light.directional": 0.4}, False, (3e-4, 2e-3)),
    ("metal-glow", "metal.gltf", "principled", {"light.ambient": 0.8, "light.directional": 0}, False, (8e-3, 1e-2)),
]


def main():
    program, folder = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    write_texture(folder / "texture.png")
    write_obj(folder / "dull.obj")
    write_gltf(folder / "dull.gltf", 0, 1)
    write_gltf(folder / "metal.gltf", 1, 0.5)
    write_panorama(folder / "panorama.exr")
    is_near = True
    print("| | mean of theirs | ours less theirs | RMS | shift of the texture / px |\n|---|---|---|---|---|")
    for name, mesh, kind, settings, has_panorama, (most_mean, most_rms) in CASES:
        panorama = folder / "panorama.exr" if has_panorama else None
        keys = settings | ({"environment.file": str(panorama)} if panorama else {})
        ours, mask, truth = draw_ours(program, folder, name, folder / mesh, keys)
        theirs = draw_theirs(folder, name, (folder / mesh).with_suffix(".gltf"), truth, kind, panorama)
        inside = cv2.erode(mask.astype(np.uint8), np.ones((5, 5))) > 0
        apart = (ours - theirs)[inside]
        shift = shift_px(ours, theirs, inside)
        mean, rms = apart.mean(), np.sqrt((apart**2).mean())
        print(f"| {name} | {theirs[inside].mean():.4f} | {mean:+.5f} | {rms:.5f} | {shift[0]:+.4f}, {shift[1]:+.4f} |",
              flush=True)
        is_near &= abs(mean) < most_mean and rms < most_rms and abs(shift).max() < 0.01
        encode = lambda x: 255 * np.clip(x, 0, 1) ** (1 / 2.2)
        cv2.imwrite(str(folder / f"{name}.png"),
                    np.hstack([encode(ours), encode(theirs), np.clip(128 + 4 * 255 * (ours - theirs), 0, 255)]))
    sys.exit(0 if is_near else "too far apart")


main()
