//! Light in snow: grains, media, Monte Carlo and discrete ordinates.
