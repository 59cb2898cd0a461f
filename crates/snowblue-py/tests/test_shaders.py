"""The exported functions on a GPU, or on the processor by a software driver of Vulkan."""

import json
import os
import re
import subprocess

import numpy as np
import pytest
import wgpu
from numpy.polynomial import chebyshev

import snowblue

VECTOR = r"(?:vec3f|vec3|color)\(([^()]*)\)"
SNOWS = {
    "common": {},
    "fine": {"grain_size_um": 100, "facetness": 0.9, "density_kg_m3": 400},
    "sooty": {"grain_size_um": 800, "impurities_ng_g": {"black-carbon": 1000}},
}
OPTIONS = {
    "common": [],
    "fine": ["--grain-size", "100", "--facetness", "0.9", "--density", "400"],
    "sooty": ["--grain-size", "800", "--impurity", "black-carbon=1000"],
}
# Thicknesses in m and cosines that are no nodes of the fit.
RANDOM = np.random.default_rng(7)
POINTS = np.stack([10.0 ** RANDOM.uniform(-4, -0.01, 400), RANDOM.uniform(0.02, 1.0, 400)], axis=-1)

WGSL_MAIN = """
@group(0) @binding(0) var<storage, read> points: array<vec2f>;
@group(0) @binding(1) var<storage, read_write> colours: array<vec4f>;
@compute @workgroup_size(1)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let point = points[id.x];
    colours[2u * id.x] = vec4f(snow_transmittance(point.x, point.y), 0.0);
    colours[2u * id.x + 1u] = vec4f(snow_reflectance(point.x, point.y), 0.0);
}
"""
GLSL_MAIN = """
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly buffer Points { vec2 points[]; };
layout(std430, binding = 1) buffer Colours { vec4 colours[]; };
void main() {
    uint id = gl_GlobalInvocationID.x;
    colours[2u * id] = vec4(snow_transmittance(points[id].x, points[id].y), 0.0);
    colours[2u * id + 1u] = vec4(snow_reflectance(points[id].x, points[id].y), 0.0);
}
"""


@pytest.fixture(scope="module")
def device():
    return wgpu.gpu.request_adapter_sync(power_preference="high-performance").request_device_sync()


def exported(*arguments):
    done = subprocess.run([os.environ["SNOWBLUE"], "export", *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def on_gpu(device, code, label=""):
    """Transmittance and reflectance at POINTS, (points, 2, 3)."""
    shader = device.create_shader_module(code=code, label=label)
    size = POINTS.shape[0] * 32
    points = device.create_buffer_with_data(data=POINTS.astype(np.float32), usage=wgpu.BufferUsage.STORAGE)
    colours = device.create_buffer(size=size, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": shader, "entry_point": "main"})
    entries = [
        {"binding": number, "resource": {"buffer": buffer, "offset": 0, "size": buffer.size}}
        for number, buffer in enumerate([points, colours])
    ]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    work = encoder.begin_compute_pass()
    work.set_pipeline(pipeline)
    work.set_bind_group(0, group)
    work.dispatch_workgroups(POINTS.shape[0])
    work.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(colours), np.float32).reshape(-1, 2, 4)[..., :3]


def on_processor(text):
    """The same in double precision, from the numbers in the text."""
    colours = []
    for body in re.split(r"\n}\n", text)[:2]:
        vectors = [[float(number) for number in vector.split(",")] for vector in re.findall(VECTOR, body)]
        vectors = [vector for vector in vectors if len(vector) == 3]
        [per_octave, per_metre] = map(float, re.search(r"min\((\S+) \* log2\(1.0 \+ (\S+) \* h", body).groups())
        [per_root, offset] = map(float, re.search(r"clamp\((\S+) \* sqrt\(cos_incidence\) - (\S+),", body).groups())
        is_transmittance = "snow_transmittance" in body
        *_, x, y, z = np.array(vectors)
        decay = np.array(vectors[-4]) if is_transmittance else 0
        # The text begins with the highest order. Terms are three numbers, or one for all three.
        orders = re.findall(r"(?:b\d+|sum) = (vec3.*?);", body, re.DOTALL)[::-1]
        rows = np.zeros((len(orders), 2 + len(re.findall(r"\bt\d+ =", body)), 3))
        for row, order in zip(rows, orders, strict=True):
            row[0] = [float(number) for number in re.match(VECTOR, order).group(1).split(",")]
            for degree, vector, number in re.findall(rf"\+ (y|t\d+) \* (?:{VECTOR}|([-\d.e]+))", order):
                row[1 if degree == "y" else int(degree[1:])] = [float(one) for one in (vector or number).split(",")]
        thickness, cosine = POINTS.astype(np.float32).astype(float).T
        arguments = (
            np.minimum(per_octave * np.log2(1 + per_metre * thickness) - 1, 1),
            np.clip(per_root * np.sqrt(cosine) - offset, -1, 1),
        )
        logarithm = chebyshev.chebval2d(*arguments, rows)
        xyz = 2 ** (logarithm - (np.outer(decay, thickness) if is_transmittance else 0))
        if not is_transmittance:
            xyz = xyz * thickness / (thickness + 1 / per_metre)
        colours.append(xyz.T @ np.stack([x, y, z]))
    return np.stack(colours, axis=1)


def relative(ours, exact):
    """The error over the greatest channel, which near black and outside sRGB is not each channel's own."""
    return np.abs(ours - exact).max(-1) / np.abs(exact).max(-1)


@pytest.mark.parametrize("name", SNOWS)
def test_the_functions_on_a_gpu_are_those_in_double_precision(device, name):
    text = exported("wgsl", *OPTIONS[name])
    exact = on_processor(text)
    # Single precision; the logarithms to base 2 of thick snow, up to 100, are rounded to 4e-6.
    bright = exact[:, 0].max(-1) > 1e-12
    error = relative(on_gpu(device, text + WGSL_MAIN), exact)
    assert bright.sum() > 200
    assert error[bright].max() < 1e-5
    assert error[:, 1].max() < 1e-5


def test_glsl_gives_the_figures_of_wgsl(device):
    wgsl = on_gpu(device, exported("wgsl") + WGSL_MAIN)
    text = "#version 450\n" + exported("glsl") + GLSL_MAIN
    assert relative(on_gpu(device, text, "comp"), wgsl).max() < 1e-5


@pytest.mark.parametrize("added_error", ["0.0001", "0.005"])
@pytest.mark.parametrize("name", SNOWS)
def test_the_functions_give_the_colours_of_snow(device, name, added_error):
    text = exported("wgsl", *OPTIONS[name], "--added-error", added_error)
    stated = float(re.search(r"greatest error of the fit: (\S+)", text).group(1))
    assert stated < 7e-4 + float(added_error)
    ours = on_gpu(device, text + WGSL_MAIN)
    # Some points, each with a thickness and an angle of its own.
    for number in range(0, len(POINTS), 20):
        thickness_m, cosine = POINTS[number].astype(np.float32).astype(float)
        slab = {"thickness_cm": 100 * thickness_m, "angle_deg": np.degrees(np.arccos(cosine))}
        for quantity, reflected in enumerate([False, True]):
            colours = snowblue.color(**SNOWS[name], **slab, reflected=reflected)
            colour = np.array([float(colours[f"{channel}_linear"].item()) for channel in "rgb"])
            # The stated error is that of X, Y and Z; of a channel the matrix to sRGB makes up to twice the fit's 6e-4.
            assert relative(ours[number, quantity], colour) < max(stated, 1e-3), (name, number, slab)


def test_a_table_holds_the_fit(tmp_path):
    file = tmp_path / "snow.json"
    exported("lut", "-o", str(file))
    table = json.loads(file.read_text())
    row, column = 40, 200
    slab = {"thickness_cm": 100 * table["thickness_m"][column]}
    slab["angle_deg"] = np.degrees(np.arccos(table["cos_incidence"][row]))
    for name, reflected in [("transmittance", False), ("reflectance", True)]:
        colour = snowblue.color(**slab, reflected=reflected)
        exact = [colour[channel].item() for channel in "XYZ"]
        thickness_m = table["thickness_m"][column]
        factor = thickness_m / (thickness_m + table["scale_m"]) if reflected else 1
        assert factor * 2 ** np.array(table[f"log2_xyz_{name}"][row][column]) == pytest.approx(exact, rel=1e-3)
