"""Presets in the libraries that renderers read them with."""

import os
import re
import subprocess
import textwrap

import MaterialX
import mitsuba as mi
import numpy as np
import pytest
import trimesh
from pxr import Gf, Usd, UsdGeom, UsdShade

CHANNELS = 3


def exported(*arguments):
    done = subprocess.run([os.environ["SNOWBLUE"], "export", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def compared(text, row, column):
    """Red, green and blue of a row of the table in a file: of snow (column 0) or of the preset (column 1)."""
    cells = re.search(rf"{re.escape(row)} +(.*)", text)[1].split()
    return [float(cells[3 * channel + column]) for channel in range(CHANNELS)]


@pytest.fixture(scope="module")
def library():
    document = MaterialX.createDocument()
    MaterialX.loadLibraries(
        MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), document
    )
    return document


def material_x(path, library):
    """A file that MaterialX finds valid, and its surface, which lives as long as the file does."""
    document = MaterialX.createDocument()
    MaterialX.readFromXmlFile(document, str(path))
    document.setDataLibrary(library)
    valid, message = document.validate()
    assert valid, message
    [material] = document.getMaterialNodes()
    [surface] = MaterialX.getShaderNodes(material)
    definition = surface.getNodeDef()
    for given in surface.getInputs():
        assert definition.getActiveInput(given.getName()).getType() == given.getType(), given.getName()
    return document, surface


def triple(color):
    return [color[channel] for channel in range(CHANNELS)]


SPACES = [("acescg", "acescg"), ("srgb-linear", "lin_rec709"), ("rec2020", "lin_rec2020")]


@pytest.mark.parametrize("space, name", SPACES)
def test_material_x_reads_open_pbr(tmp_path, library, space, name):
    path = tmp_path / "snow.mtlx"
    exported("openpbr", "--color-space", space, "-o", path)
    _document, surface = material_x(path, library)
    assert surface.getCategory() == "open_pbr_surface"
    assert surface.getNodeDef().getName() == "ND_open_pbr_surface_surfaceshader"
    assert surface.getInput("subsurface_color").getActiveColorSpace() == name
    # A change of colour space must not mix radii.
    assert surface.getInput("subsurface_radius_scale").getActiveColorSpace() == ""
    assert surface.getInputValue("subsurface_weight") == 1
    assert surface.getInputValue("specular_weight") == 0
    assert max(triple(surface.getInputValue("subsurface_radius_scale"))) == 1


def test_material_x_reads_standard_surface(tmp_path, library):
    path = tmp_path / "snow.mtlx"
    exported("arnold", "--scene-unit", "cm", "-o", path)
    _document, surface = material_x(path, library)
    assert surface.getCategory() == "standard_surface"
    assert surface.getInputValue("subsurface") == 1
    assert surface.getInputValue("specular") == 0
    # The mean free path of the default snow is 0.6 mm.
    assert surface.getInputValue("subsurface_scale") == pytest.approx(0.06, rel=0.05)
    assert max(triple(surface.getInputValue("subsurface_radius"))) == 1


def co_albedo_of(color, asymmetry):
    """1 less the single-scattering albedo of a colour: OpenPBR 1.1, section "Subsurface"."""
    s = 4.09712 + 4.20863 * color - (9.59217 + 41.6808 * color + 17.7126 * color**2) ** 0.5
    return s**2 * (1 - asymmetry) / (1 - asymmetry * s**2)


def test_the_numbers_of_a_file_are_the_medium_that_it_claims(tmp_path, library):
    """The specification's medium of the numbers transmits, by discrete ordinates, what the table says."""
    path = tmp_path / "snow.mtlx"
    exported("openpbr", "--color-space", "srgb-linear", "-o", path)
    _document, surface = material_x(path, library)
    asymmetry = surface.getInputValue("subsurface_scatter_anisotropy")
    colors = triple(surface.getInputValue("subsurface_color"))
    radius = surface.getInputValue("subsurface_radius")
    factors = triple(surface.getInputValue("subsurface_radius_scale"))
    for cm in [5, 15, 30]:
        claimed = compared(path.read_text(), f"through {cm} cm", 1)
        for color, factor, transmittance in zip(colors, factors, claimed):
            co_albedo, tau = co_albedo_of(color, asymmetry), 0.01 * cm / (radius * factor)
            words = ["slab", "--one-minus-omega", co_albedo, "--g", asymmetry, "--tau", tau, "--mu0", 1,
                     "--streams", 32, "--quiet", "--format", "csv"]
            done = subprocess.run([os.environ["SNOWBLUE"], *map(str, words)], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            names, values = (line.split(",") for line in done.stdout.splitlines())
            solved = dict(zip(names, map(float, values)))["transmittance"]
            # The table has four digits, the file seven, of which s of 0.001 keeps four.
            assert solved == pytest.approx(transmittance, rel=2e-3), (cm, color)


@pytest.fixture
def monochrome():
    before = mi.variant()
    mi.set_variant("llvm_ad_mono")
    yield
    mi.set_variant(before)


def transmittance_in_mitsuba(cm, mean_free_path_cm, albedo, asymmetry, samples):
    """Of a wide slab for normal incidence, and its standard error: by reciprocity the radiance of a view straight
    through it of a plane of the radiance 1."""
    transform = mi.ScalarTransform4f()
    made = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 1 << 30},
        "sensor": {
            "type": "orthographic",
            "to_world": transform.look_at([0, 0, 100], [0, 0, 0], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"},
                     "pixel_format": "luminance"},
        },
        "plane": {"type": "rectangle", "to_world": transform.translate([0, 0, -cm]).scale(1000),
                  "emitter": {"type": "area", "radiance": {"type": "uniform", "value": 1.0}}},
        "slab": {
            "type": "cube", "to_world": transform.scale([100, 100, cm / 2]), "bsdf": {"type": "null"},
            "interior": {"type": "homogeneous", "sigma_t": 1 / mean_free_path_cm, "albedo": albedo,
                         "phase": {"type": "hg", "g": asymmetry}},
        },
    })
    pixels = np.array(mi.render(made, spp=samples)).ravel()
    return pixels.mean(), pixels.std(ddof=1) / len(pixels) ** 0.5


@pytest.mark.parametrize(("cm", "samples"), [(1, 256), (5, 64)])
def test_another_renderer_agrees_on_the_medium(tmp_path, library, monochrome, cm, samples):
    """Mitsuba's random walks in the medium that the specification makes of the numbers in a file."""
    path = tmp_path / "snow.mtlx"
    exported("openpbr", "--color-space", "srgb-linear", "--scene-unit", "cm", "-o", path)
    _document, surface = material_x(path, library)
    asymmetry, radius = (surface.getInputValue(f"subsurface_{name}") for name in ("scatter_anisotropy", "radius"))
    colors = triple(surface.getInputValue("subsurface_color"))
    factors = triple(surface.getInputValue("subsurface_radius_scale"))
    claimed = compared(path.read_text(), f"through {cm} cm", 1)
    for color, factor, expected in zip(colors, factors, claimed):
        albedo = 1 - co_albedo_of(color, asymmetry)
        mean, error = transmittance_in_mitsuba(cm, radius * factor, albedo, asymmetry, samples)
        # The table has four digits.
        assert abs(mean - expected) < 4 * error + 1e-3 * expected, (mean, expected, error)


@pytest.mark.parametrize("unit, metres", [("m", 1), ("cm", 0.01), ("mm", 0.001)])
def test_usd_binds_both_surfaces(tmp_path, unit, metres):
    path = tmp_path / "snow.usda"
    exported("usd", "--scene-unit", unit, "-o", path)
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageMetersPerUnit(stage) == metres
    material = UsdShade.Material(stage.GetDefaultPrim())
    assert material and material.GetPath() == "/Snow"

    block = UsdGeom.Cube.Define(stage, "/Block").GetPrim()
    UsdShade.MaterialBindingAPI.Apply(block).Bind(material)
    bound, _ = UsdShade.MaterialBindingAPI(block).ComputeBoundMaterial()
    assert bound.GetPath() == "/Snow"

    preview, *_ = bound.ComputeSurfaceSource()
    assert preview.GetShaderId() == "UsdPreviewSurface"
    diffuse = preview.GetInput("diffuseColor")
    assert diffuse.GetAttr().GetColorSpace() == Gf.ColorSpaceNames.LinearRec709
    albedo = compared(exported("openpbr", "--color-space", "srgb-linear"), "albedo, deep", 0)
    assert list(diffuse.Get()) == pytest.approx(albedo, abs=1e-5)

    surface, *_ = bound.ComputeSurfaceSource("mtlx")
    assert surface.GetShaderId() == "ND_open_pbr_surface_surfaceshader"
    color, factors = (surface.GetInput(name) for name in ("subsurface_color", "subsurface_radius_scale"))
    assert color.GetAttr().GetColorSpace() == Gf.ColorSpaceNames.LinearAP1
    assert factors.GetAttr().GetColorSpace() == Gf.ColorSpaceNames.Data
    assert surface.GetInput("subsurface_radius").Get() * metres == pytest.approx(6.05e-4, rel=0.02)


def test_usd_and_material_x_have_the_same_numbers(tmp_path, library):
    usd, mtlx = tmp_path / "snow.usda", tmp_path / "snow.mtlx"
    exported("usd", "--snow", "fresh", "-o", usd)
    exported("openpbr", "--snow", "fresh", "-o", mtlx)
    stage = Usd.Stage.Open(str(usd))
    ours = UsdShade.Shader.Get(stage, "/Snow/OpenPBR")
    _document, theirs = material_x(mtlx, library)
    assert {given.GetBaseName() for given in ours.GetInputs()} == {given.getName() for given in theirs.getInputs()}
    for given in ours.GetInputs():
        value = theirs.getInputValue(given.GetBaseName())
        if isinstance(value, MaterialX.Color3):
            assert list(given.Get()) == pytest.approx(triple(value))
        else:
            assert given.Get() == pytest.approx(value)


def test_the_scene_of_the_chapter_binds_the_preset(tmp_path, repository):
    [scene] = re.findall(r"```usda\n(.*?)```", (repository / "docs" / "src" / "presets.md").read_text(), re.DOTALL)
    (tmp_path / "scene.usda").write_text(textwrap.dedent(scene).strip())
    exported("usd", "--scene-unit", "m", "-o", tmp_path / "snow.usda")
    stage = Usd.Stage.Open(str(tmp_path / "scene.usda"))
    block = stage.GetPrimAtPath("/World/Block")
    material, _relation = UsdShade.MaterialBindingAPI(block).ComputeBoundMaterial()
    assert material.GetPath() == "/World/Snow"
    surface, _name, _type = material.ComputeSurfaceSource("mtlx")
    assert surface.GetShaderId() == "ND_open_pbr_surface_surfaceshader"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    lamp, camera = (stage.GetPrimAtPath(f"/World/{name}") for name in ("Lamp", "Camera"))
    assert (lamp.GetTypeName(), camera.GetTypeName()) == ("SphereLight", "Camera")
    to_world = [UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0) for prim in (lamp, camera)]
    behind, before = (matrix.ExtractTranslation() for matrix in to_world)
    # The block is about the origin: the lamp is behind its face at y = size / 2, and the camera, which looks along -z,
    # sees the middle of the block.
    mesh = UsdGeom.Mesh(block)
    points = np.array(mesh.GetPointsAttr().Get())
    assert list(mesh.GetFaceVertexCountsAttr().Get()) == [4] * 6
    quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(6, 4)
    solid = trimesh.Trimesh(points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    half = points.max()
    assert solid.is_watertight and np.isclose(solid.volume, (2 * half) ** 3)
    assert np.allclose(mesh.GetExtentAttr().Get(), solid.bounds)
    assert half < behind[1] and before[1] < -half
    assert np.allclose(to_world[1].TransformDir((0, 0, -1)), -before.GetNormalized(), atol=0.01)
