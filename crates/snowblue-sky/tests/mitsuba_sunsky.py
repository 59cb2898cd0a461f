"""Writes tests/data/mitsuba_sky.csv and mitsuba_sun.csv: Mitsuba 3's emitter `sunsky`, for tests/it/mitsuba.rs.

    pip install mitsuba==3.9.1 numpy
    python crates/snowblue-sky/tests/mitsuba_sunsky.py
"""

from pathlib import Path

import mitsuba
import numpy as np

mitsuba.set_variant("scalar_spectral")

DATA = Path(__file__).parent / "data"
WAVELENGTHS_NM = [400.0, 450.0, 545.0, 700.0]
TURBIDITIES = [1.0, 2.5, 4.0, 6.7, 10.0]
ELEVATIONS_DEG = [2.0, 30.0, 75.0]
GROUND_ALBEDOS = [0.0, 0.5, 0.9]
SUN_RADIUS = np.radians(0.5358 / 2)  # Mitsuba's default


def direction(elevation, azimuth):
    return np.array([np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)])


def emitter(elevation_deg, turbidity, ground_albedo, **parts):
    albedo = {"type": "uniform", "value": ground_albedo}
    sun = direction(np.radians(elevation_deg), 0.0).tolist()
    return mitsuba.load_dict(
        {"type": "sunsky", "sun_direction": sun, "turbidity": turbidity, "albedo": albedo, "complex_sun": True, **parts}
    )


def radiance(emitter, direction):
    interaction = mitsuba.SurfaceInteraction3f()
    interaction.wi = -mitsuba.Vector3f(direction.tolist())
    interaction.wavelengths = WAVELENGTHS_NM
    return np.array(emitter.eval(interaction))


def write(name, keys, rows):
    header = ",".join([*keys, *(f"value_{wavelength_nm:.0f}_nm" for wavelength_nm in WAVELENGTHS_NM)])
    (DATA / name).write_text("\n".join([header, *rows]) + "\n")


def row(keys, values):
    return ",".join([*(f"{key:g}" for key in keys), *(f"{value:.5e}" for value in values)])


def directions_deg(count=200):
    """Zenith angles and azimuths from the sun that cover the sky evenly, without its last 0.8 degrees."""
    number = np.arange(count) + 0.5
    zenith = np.degrees(np.arccos(1 - number / count * (1 - np.cos(np.radians(89.2)))))
    azimuth = np.degrees(number * np.pi * (3 - np.sqrt(5))) % 360
    return np.round(zenith, 1), np.round(azimuth, 1)


def sky_rows():
    zenith_deg, azimuth_deg = directions_deg()
    for first, turbidity in enumerate(TURBIDITIES):
        for second, elevation_deg in enumerate(ELEVATIONS_DEG):
            ground_albedo = GROUND_ALBEDOS[(first + second) % 3]
            sky = emitter(elevation_deg, turbidity, ground_albedo, sun_scale=0.0)
            for zenith, azimuth in zip(zenith_deg, azimuth_deg):
                values = radiance(sky, direction(np.radians(90 - zenith), np.radians(azimuth)))
                yield row([turbidity, ground_albedo, elevation_deg, zenith, azimuth], values)


def sun_rows():
    """Radiances above the centre of the disc, at fractions of its radius; the fraction -1 stands for the irradiance."""
    for turbidity in TURBIDITIES:
        for elevation_deg in ELEVATIONS_DEG:
            sun = emitter(elevation_deg, turbidity, 0.3, sky_scale=0.0)
            elevation = np.radians(elevation_deg)
            for fraction in [0.0, 0.4, 0.8]:
                values = radiance(sun, direction(elevation + fraction * SUN_RADIUS, 0.0))
                yield row([turbidity, elevation_deg, fraction], values)
            yield row([turbidity, elevation_deg, -1.0], irradiance(sun, elevation))


def irradiance(sun, elevation, rings=64, points=32):
    """Sum over the disc. With m = cos of the angle at the sun's surface, cos(gamma) domega = sin^2(r) m dm dphi."""
    frame = mitsuba.Frame3f(direction(elevation, 0.0).tolist())
    total = np.zeros(4)
    for m in (np.arange(rings) + 0.5) / rings:
        sine = np.sin(SUN_RADIUS) * np.sqrt(1 - m * m)
        for phi in 2 * np.pi * (np.arange(points) + 0.5) / points:
            local = [sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine * sine)]
            total += m * radiance(sun, np.array(frame.to_world(local)))
    return total * np.sin(SUN_RADIUS) ** 2 * 2 * np.pi / (rings * points)


if __name__ == "__main__":
    DATA.mkdir(exist_ok=True)
    write("mitsuba_sky.csv", ["turbidity", "ground_albedo", "elevation_deg", "zenith_deg", "azimuth_deg"], sky_rows())
    write("mitsuba_sun.csv", ["turbidity", "elevation_deg", "fraction"], sun_rows())
