//! From spectra to colour: observer, illuminants, XYZ, RGB, CIELAB.
