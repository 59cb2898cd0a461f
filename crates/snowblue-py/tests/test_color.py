"""Colours, matches and swatches."""

import numpy as np
import pytest

import snowblue


def test_colours_are_those_of_the_command(command):
    rows = command("color", "--thickness", "5,15,30", "--illuminant", "LED-B5", "--exposure", "auto")
    ours = snowblue.color(thickness_cm=[5, 15, 30], illuminant="LED-B5", exposure_stops=None)
    for name in ("X", "Y", "Z", "L", "a", "b", "r_linear", "g_linear", "b_linear"):
        np.testing.assert_allclose(ours[name].values.ravel(), [float(row[name]) for row in rows], rtol=1e-6)
    assert ours.hex.values.ravel().tolist() == [row["hex"] for row in rows]


def test_colours_of_a_given_spectrum_have_its_axes():
    curves = snowblue.spectrum(thickness_cm=[5, 30], density_kg_m3=[200, 400], standard_errors=False)
    seen = snowblue.color(curves.transmittance, illuminant=["D65", "A"])
    assert seen.Y.dims == ("illuminant", "density", "thickness", "angle")
    assert (seen.Y.diff("thickness") < 0).all()
    # Tungsten light is redder.
    assert (seen.sel(illuminant="A").r_linear / seen.sel(illuminant="A").b_linear
            > seen.sel(illuminant="D65").r_linear / seen.sel(illuminant="D65").b_linear).all()
    with pytest.raises(ValueError, match="'wavelength'"):
        snowblue.color(curves.transmittance.isel(wavelength=0))
    with pytest.raises(TypeError, match="thickness_cm has no effect"):
        snowblue.color(curves.transmittance, thickness_cm=5)
    with pytest.raises(TypeError, match="reflected has no effect"):
        snowblue.color(curves.transmittance, reflected=True)
    with pytest.raises(ValueError, match="illuminant"):
        snowblue.color(illuminant="D99")
    assert "D65" in snowblue.illuminants()
    with pytest.raises(ValueError, match="the value NaN, but must be finite"):
        snowblue.color(curves.transmittance * np.nan)
    with pytest.raises(ValueError, match="exposure is NaN stops"):
        snowblue.color(exposure_stops=np.nan)


@pytest.mark.parametrize("step_nm", [1, 5, 10, 12, 15, 20])
def test_a_constant_spectrum_has_the_chromaticity_of_the_light(step_nm):
    import xarray as xr

    wavelengths_nm = np.arange(400.0, 720.0, step_nm)
    grey = xr.DataArray(np.full(wavelengths_nm.size, 0.5), {"wavelength": wavelengths_nm}, ["wavelength"])
    light = snowblue.color(thickness_cm=0)
    for name in "XYZ":
        assert float(snowblue.color(grey)[name]) == pytest.approx(0.5 * light[name].item(), rel=1e-12)
    with pytest.raises(ValueError, match=r"are 400–690 nm, but must cover 400–700 nm"):
        snowblue.color(grey.interp(wavelength=[400.0, 420, 440, 460, 480, 500, 520, 540, 560, 580, 600, 620, 640, 660,
                                               680, 690]))


def test_matches_are_those_of_the_command(command):
    rows = command("match", "--target", "#7bcdec")
    found = snowblue.match("#7bcdec")
    for name in ("grain_size_um", "density_kg_m3", "thickness_cm", "delta_e", "Y"):
        np.testing.assert_allclose(found[name], [float(row[name]) for row in rows], rtol=1e-6)
    assert found.within_reach.all()
    with pytest.warns(UserWarning, match="out of reach"):
        snowblue.match("#ff0000", thickness_cm=(1, 30))
    with pytest.raises(ValueError, match="thickness_cm"):
        snowblue.match("#7bcdec", thickness_cm=(30, 1))
    with pytest.raises(ValueError, match="blue"):
        snowblue.match("blue")


@pytest.mark.parametrize(("target", "keywords", "words"), [
    (["#7bcdec"], {}, r"target is \['#7bcdec'\], but must be one word"),
    ("#7bcdec", {"illuminant": ["D65", "A"]}, "illuminant is .*, but must be one word"),
    ("#7bcdec", {"thickness_cm": [1, 30]}, r"thickness_cm is \[1, 30\], but must be one thickness or a tuple"),
    ("#7bcdec", {"thickness_cm": "5"}, "thickness_cm is '5', but must be a number"),
    ("#7bcdec", {"thickness_cm": ("1", 30)}, "thickness_cm is '1', but must be a number"),
    ("#7bcdec", {"angle_deg": [30, 40]}, r"angle_deg is \[30, 40\], but must be one angle"),
    ("#7bcdec", {"density_kg_m3": "300"}, "density_kg_m3 is '300', but must be a number"),
    ("#7bcdec", {"seed": "x"}, "seed is 'x', but must be a number"),
])
def test_bad_arguments_of_a_match_are_named(target, keywords, words):
    with pytest.raises(ValueError, match=words):
        snowblue.match(target, **keywords)


def test_swatches_are_bluer_the_thicker_the_snow(tmp_path):
    sheet = snowblue.swatch(columns={"thickness_cm": [5, 30]}, size_px=64, output=tmp_path / "sheet.png")
    assert sheet.dtype == np.uint8 and sheet.shape == (64, 128, 3)
    assert (tmp_path / "sheet.png").read_bytes().startswith(b"\x89PNG")
    thin, thick = sheet[32, 32].astype(float), sheet[32, 96].astype(float)
    assert thick.sum() < thin.sum()
    assert thick[2] / thick[0] > thin[2] / thin[0]
    with pytest.raises(TypeError, match="'depth' is not known"):
        snowblue.swatch(columns={"depth": [1]})
    with pytest.raises(ValueError, match="also given"):
        snowblue.swatch(columns={"thickness_cm": [1]}, thickness_cm=2)
    with pytest.raises(ValueError, match="thickness_cm has no values"):
        snowblue.swatch(columns={"thickness_cm": []})
    with pytest.raises(ValueError, match="9 swatches of 2048 pixels are 18432 pixels, but must be at most 16384"):
        snowblue.swatch(columns={"angle_deg": list(range(9))}, size_px=2048)
