"""The blue of light through snow.

>>> import snowblue
>>> snow = snowblue.spectrum(grain_size_um=400, density_kg_m3=300, thickness_cm=[5, 15, 30])
>>> snow.transmittance.plot(hue="thickness")  # doctest: +SKIP

Quantities carry their unit in the name of the argument. Results are `xarray.Dataset`s whose coordinates have units; a
list or an array as an argument makes an axis of the result, a tuple is one value (the range of a grain size, the
distribution of a facetness). Work that takes long shows a bar if tqdm is installed, and stops at Ctrl-C. All functions
use all cores; the environment variable RAYON_NUM_THREADS limits them. The same arguments give the same numbers.
"""

from snowblue._native import __version__, illuminants, parameters
from snowblue._arguments import Snow, substance
from snowblue._bands import bands
from snowblue._color import color, match, swatch
from snowblue._database import Database
from snowblue._inversion import invert
from snowblue._light import light_at_depth
from snowblue._scene import Bake, BakedObject, Scene
from snowblue._sky import sky, sun_position, sunlight
from snowblue._spectra import aged_ssa, albedo, brf, bsdf, layers, single_scattering, spectrum

__all__ = [
    "Bake",
    "BakedObject",
    "Database",
    "Scene",
    "Snow",
    "__version__",
    "aged_ssa",
    "albedo",
    "bands",
    "brf",
    "bsdf",
    "color",
    "illuminants",
    "invert",
    "layers",
    "light_at_depth",
    "match",
    "parameters",
    "single_scattering",
    "sky",
    "spectrum",
    "substance",
    "sun_position",
    "sunlight",
    "swatch",
]
