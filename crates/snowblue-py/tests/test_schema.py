"""The JSON Schema of scene files, by which editors complete keys and mark mistakes, agrees with the program."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

SCENES = Path(__file__).parents[3] / "scenes"


def schema(kind):
    read = json.loads((SCENES / f"{kind}.schema.json").read_text())
    jsonschema.Draft7Validator.check_schema(read)
    return jsonschema.Draft7Validator(read)


@pytest.fixture(scope="module")
def validator():
    return schema("scene")


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_scenes_are_valid(validator, path):
    text = path.read_text()
    assert text.startswith("#:schema scene.schema.json\n")
    validator.validate(tomllib.loads(text))


OBJECT = '[[object]]\nmaterial = "snow"\n'
BOX = 'shape = "box"\nsize = [1, 1, 1]\n'


@pytest.mark.parametrize("text", [
    '[film]\nwidth = 20000\n',
    '[film]\nwidht = 100\n',
    '[camera]\nposition = [0, 0, 1]\nlook_at = [0, 1]\n',
    '[integrator]\ntype = "hybird"\n',
    '[material.snow]\ntype = "snow"\ndensity_kg_m3 = 1200\n',
    '[material.snow]\ntype = "snow"\nfacetnes = 0.3\n',
    '[material.paint]\ntype = "diffuse"\nreflectance = 1.5\n',
    '[[light]]\ntype = "point"\nposition = [0, 0, 1]\n',
    '[[light]]\ntype = "torch"\nposition = [0, 0, 1]\nradiant_intensity_w_sr = 1\n',
    f'{OBJECT}shape = "sphere"\nradius = "5 cm"\n',
    f'{OBJECT}{BOX}colour = 1\n',
    f'{OBJECT}{BOX}position = [0, 1e9, 0]\n',
    f'{OBJECT}shape = "carved"\ncell = 0.1\n[[object.add]]\ntype = "ellipsoid"\ncentre = [0, 0, 0]\n',
    '[sky]\nsun = { elevation_deg = 100 }\n',
])
def test_wrong_scenes_are_refused(validator, text):
    with pytest.raises(jsonschema.ValidationError):
        validator.validate(tomllib.loads(text))


@pytest.mark.parametrize("text", [
    '[sky]\nsun = { elevation_deg = 30 }\n',
    '[film]\nexposure = -1.5\nwhite = "sky"\n',
    '[material.snow]\ntype = "snow"\nsparkle = true\nrelief = "fresh"\n'
    'mask = { attribute = "age" }\nbetween = [{ grain_size_um = 200 }, { grain_size_um = [400, 900] }]\n',
    f'{OBJECT}mesh = "a.ply"\nscale = 2\n',
    f'{OBJECT}shape = "snowpack"\nground = "a.tif"\ndepth = {{ texture = "d.png", range = [0, 2] }}\ncrop = '
    '{ centre = [0, 0], size = [9, 9] }\n',
])
def test_notations_are_accepted(validator, text):
    validator.validate(tomllib.loads(text))


@pytest.mark.parametrize("layer, is_valid", [
    ("thickness_cm = 3\nsnow = \"fresh\"\nimpurities_ng_g = { black-carbon = 10 }\n", True),
    ("thickness_cm = 3\ngrain_size_um = [100, 300]\nfacetness = 0.3\n", True),
    ("kind = \"ice\"\nthickness_cm = 0.5\n", True),
    ("kind = \"ice\"\nthickness_cm = 0.5\ndensity_kg_m3 = 300\n", False),
    ("snow = \"fresh\"\n", False),
    ("thickness_cm = 3\ndensity_kg_m3 = 1200\n", False),
    ("thickness_cm = 3\nimpurities_ng_g = { black-carbon = -1 }\n", False),
])
def test_layers(layer, is_valid):
    file = tomllib.loads(f"[[layer]]\n{layer}")
    assert schema("layers").is_valid(file) == is_valid
