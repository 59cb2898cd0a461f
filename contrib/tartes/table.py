#!/usr/bin/env python3
"""Fills a table of snow with TARTES, a two-stream model (Libois et al. 2013, doi:10.5194/tc-7-1803-2013).

    pip install tartes xarray scipy
    python3 table.py tartes.nc
    snowblue database import tartes.nc --space log --components 3 -o tartes_snow.nc
    snowblue render scenes/block_30cm.toml --integrator pcasnow --database tartes_snow.nc -o tartes.png

TARTES has no facetness; the grain shape is its default (B = n squared, g after Robledano et al. 2023). The facetness
axis has the single value 0.3, which the scenes use.
"""

import sys

import numpy as np
import tartes
import xarray as xr

ICE_DENSITY = 917.7  # kg/m3 at -5 degrees Celsius
# Surface-to-volume ratio of spheroids with a sphericity of 0.7-0.9, times their greatest extension.
SURFACE_OVER_VOLUME = 8.204

sizes_um = np.arange(100.0, 501.0, 50.0)
densities = np.array([200.0, 300.0, 400.0])
angles = np.array([0.0, 20.0, 40.0, 60.0, 80.0, 89.0])
thicknesses_cm = np.array([0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 5.0, 10.0, 15.0, 25.0, 35.0, 50.0, 70.0, 100.0])
wavelengths_nm = np.arange(400.0, 701.0, 10.0)


def specific_surface_area(mean_um):
    """In m2/kg, for sizes distributed uniformly in number over the mean +- 50 um: <s2>/<s3> replaces 1/s."""
    low, high = mean_um - 50.0, mean_um + 50.0
    mean_square = (low**2 + low * high + high**2) / 3.0
    mean_cube = (low + high) * (low**2 + high**2) / 4.0
    return SURFACE_OVER_VOLUME * mean_square / mean_cube * 1e6 / ICE_DENSITY


def slab(mean_um, density, thickness_cm, angle_deg):
    """Reflectance and transmittance of a slab: the light absorbed by a black ground is transmitted."""
    albedo, absorbed = tartes.tartes(
        wavelengths_nm * 1e-9,
        specific_surface_area(mean_um),
        density,
        [thickness_cm * 1e-2],
        refrac_index="w2008",
        soilalbedo=0.0,
        dir_frac=1.0,
        mudir=np.cos(np.radians(angle_deg)),
        compute_absorption=True,
    )
    return albedo, np.asarray(absorbed).reshape(len(wavelengths_nm), -1)[:, -1]


def main(path):
    shape = (len(angles), len(thicknesses_cm), len(sizes_um), len(densities), len(wavelengths_nm))
    reflectance, transmittance = np.empty(shape), np.empty(shape)
    for index in np.ndindex(shape[:-1]):
        a, t, s, d = index
        reflectance[index], transmittance[index] = slab(sizes_um[s], densities[d], thicknesses_cm[t], angles[a])
    dimensions = ("angle", "thickness", "grain_size", "density", "wavelength")
    table = xr.Dataset(
        {"transmittance": (dimensions, transmittance), "reflectance": (dimensions, reflectance)},
        {
            "angle": angles,
            "thickness": thicknesses_cm,
            "grain_size": sizes_um,
            "density": densities,
            "wavelength": wavelengths_nm,
        },
    ).expand_dims(facetness=[0.3])
    table.to_netcdf(path, format="NETCDF3_64BIT")


if __name__ == "__main__":
    main(sys.argv[1])
