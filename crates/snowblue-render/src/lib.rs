//! From a scene with snow to an image: a spectral path tracer with PCASnow.
