//! Snow of a target colour: known samples are recovered, colours that no snow has are out of reach.

use snowblue_color::{Colorimeter, Illuminant, LinearRgb, Observer, Srgb8, Xyz};
use snowblue_database::DatabaseError;
use snowblue_database::matching::{
    self, DENSITIES_KG_M3, Deviation, FreeParameter, GRAIN_SIZES_UM, Match, Problem, THICKNESSES_CM, Target,
};
use snowblue_transport::ordinates::{OrdinatesOptions, solve_without_errors};
use snowblue_transport::sample::{GrainSize, Property, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Incidence, Slab};

const VERTICAL: Incidence = Incidence::Beam { angle_deg: 0.0 };
const THICKNESS: FreeParameter = FreeParameter { property: None, range: THICKNESSES_CM };
const GRAIN_SIZE: FreeParameter = FreeParameter { property: Some(Property::GrainSize), range: GRAIN_SIZES_UM };
const DENSITY: FreeParameter = FreeParameter { property: Some(Property::Density), range: DENSITIES_KG_M3 };

fn colorimeter(illuminant: Illuminant) -> Colorimeter {
    let tens: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    Colorimeter::new(Observer::Cie1931, illuminant, &tens).unwrap()
}

fn options(seed: u64) -> OrdinatesOptions {
    OrdinatesOptions { tally_rays: 1 << 15, seed, ..OrdinatesOptions::default() }
}

/// The light through the snow to start from.
fn light_through(snow: &Problem, colorimeter: &Colorimeter, options: &OrdinatesOptions) -> Xyz {
    let slab = Slab {
        sample: snow.sample,
        thicknesses_cm: vec![snow.thickness_cm],
        incidences: vec![snow.incidence],
        wavelengths_nm: colorimeter.wavelengths_nm().to_vec(),
    };
    let solved = solve_without_errors(&slab, options).unwrap();
    colorimeter.xyz(&solved.iter().map(|row| row.fluxes.transmittance.value).collect::<Vec<_>>())
}

fn closest(color: Xyz, illuminant: Illuminant, snow: &Problem) -> Result<Vec<Match>, DatabaseError> {
    matching::closest(&target(color, &colorimeter(illuminant)), snow, &options(1))
}

fn target(color: Xyz, colorimeter: &Colorimeter) -> Target<'_> {
    Target { color, white: LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz(), colorimeter }
}

fn default_problem(free: &[FreeParameter]) -> Problem {
    Problem { sample: SnowSample::default(), thickness_cm: 15.0, incidence: VERTICAL, free: free.to_vec() }
}

fn hex(word: &str) -> Xyz {
    word.parse::<Srgb8>().unwrap().decode().xyz()
}

/// The colour at the luminance of middle grey, at which colours are compared.
fn grey(light: Xyz) -> Xyz {
    light * (0.184 / light.y)
}

/// The tallies of target and search differ by about 0.2 %, except for thin snow, whose grey hardly changes with
/// thickness.
#[test]
fn thickness_is_recovered() {
    let fine = |seed| OrdinatesOptions { tally_rays: 1 << 18, ..options(seed) };
    let cases = [
        (Illuminant::D65, 2.0, 1),
        (Illuminant::D65, 8.0, 2),
        (Illuminant::D65, 40.0, 2),
        (Illuminant::E, 12.0, 2),
        (Illuminant::A, 8.0, 2),
        (Illuminant::A, 40.0, 2),
    ];
    for (illuminant, thickness_cm, seed) in cases {
        let colorimeter = colorimeter(illuminant);
        let snow = Problem { thickness_cm, ..default_problem(&[THICKNESS]) };
        let color = grey(light_through(&snow, &colorimeter, &fine(seed)));
        let found = matching::closest(&target(color, &colorimeter), &snow, &fine(1)).unwrap();
        assert_eq!(found.len(), 1, "only the thickness is free");
        let error = found[0].thickness_cm / thickness_cm - 1.0;
        let delta_e = found[0].difference.at_middle_grey;
        assert!(error.abs() < 0.01 && delta_e < 0.1, "{thickness_cm} cm, {illuminant}: {error} {delta_e}");
    }
}

/// The colour of any sample is matched by the default sample and by others at other thicknesses, since chromaticities
/// lie on one curve.
#[test]
fn several_samples_match_a_colour() {
    let facetness = TruncatedNormal::facetness_around(0.7);
    let sample = SnowSample {
        grain_size: GrainSize::around(180.0).unwrap(),
        facetness,
        density_kg_m3: 350.0,
        ..SnowSample::default()
    };
    let other = Problem { sample, thickness_cm: 6.0, incidence: Incidence::Beam { angle_deg: 40.0 }, free: Vec::new() };
    let color = grey(light_through(&other, &colorimeter(Illuminant::D65), &options(2)));
    let found = closest(color, Illuminant::D65, &default_problem(&[THICKNESS, GRAIN_SIZE, DENSITY])).unwrap();
    assert_eq!(found.len(), 5);
    for one in &found {
        assert!(one.difference.at_middle_grey < 1.0 && one.within_reach(), "{one:?}");
    }
    // The default sample comes first, then increasing grain sizes, which match in thicker snow with more light.
    assert_eq!(found[0].sample, SnowSample::default());
    for pair in found[1..].windows(2) {
        assert!(pair[1].thickness_cm > pair[0].thickness_cm && pair[1].light.y > pair[0].light.y, "{found:?}");
    }
}

#[test]
fn bluer_targets_need_thicker_snow() {
    let thicknesses_cm = [1.0, 3.0, 10.0, 25.0, 50.0, 80.0];
    let found = thicknesses_cm.map(|thickness_cm| {
        let color = light_through(
            &Problem { thickness_cm, ..default_problem(&[]) },
            &colorimeter(Illuminant::D65),
            &options(2),
        );
        closest(grey(color), Illuminant::D65, &default_problem(&[THICKNESS])).unwrap()[0]
    });
    assert!(found.windows(2).all(|pair| pair[1].thickness_cm > pair[0].thickness_cm), "{found:?}");
    assert!(found.windows(2).all(|pair| pair[1].light.y < pair[0].light.y), "{found:?}");
}

/// At a given thickness the grain size is fitted, and the density where the grain size ends at its limit.
#[test]
fn parameters_are_fitted_in_order() {
    let known = SnowSample { grain_size: GrainSize::around(600.0).unwrap(), ..SnowSample::default() };
    let given = Problem { sample: known, thickness_cm: 10.0, ..default_problem(&[]) };
    let color = grey(light_through(&given, &colorimeter(Illuminant::D65), &options(2)));
    let free = Problem { thickness_cm: 10.0, ..default_problem(&[GRAIN_SIZE, DENSITY]) };
    let found = closest(color, Illuminant::D65, &free).unwrap();
    let size_um = |one: &Match| 0.5 * (one.sample.grain_size.min_um + one.sample.grain_size.max_um);
    assert!((size_um(&found[0]) / 600.0 - 1.0).abs() < 0.03 && found[0].difference.at_middle_grey < 0.1, "{found:?}");
    assert!((found[0].sample.density_kg_m3 - 300.0).abs() < 1e-9);
    // Denser snow needs larger grains.
    assert!(found[1..].windows(2).all(|pair| size_um(&pair[1]) > size_um(&pair[0])), "{found:?}");

    let thin = Problem { thickness_cm: 3.5, ..free };
    let found = closest(color, Illuminant::D65, &thin).unwrap()[0];
    assert!((size_um(&found) - GRAIN_SIZES_UM.low).abs() < 1e-6 && found.sample.density_kg_m3 > 310.0, "{found:?}");
    assert!(found.difference.at_middle_grey < 0.5, "{found:?}");
}

#[test]
fn colours_that_no_snow_has_are_out_of_reach() {
    let colorimeter = colorimeter(Illuminant::D65);
    let words = [("#c03030", "redder"), ("#30a040", "greener"), ("#a050c0", "purple"), ("#d0c040", "yellower")];
    for (color, word) in words {
        let color = hex(color);
        let nearest = closest(color, Illuminant::D65, &default_problem(&[THICKNESS])).unwrap()[0];
        let Deviation { word: direction, delta_a: a, delta_b: b, .. } = nearest.deviation(&target(color, &colorimeter));
        assert!(!nearest.within_reach() && direction.contains(word), "{word}: {direction} {a} {b} {nearest:?}");
        // Both are at L* = 50, so they differ only in a* and b*.
        assert!((a.hypot(b) / nearest.difference.at_middle_grey - 1.0).abs() < 1e-9);
    }
}

#[test]
fn white_needs_little_snow_and_black_is_refused() {
    let white = closest(hex("#ffffff"), Illuminant::D65, &default_problem(&[THICKNESS, GRAIN_SIZE])).unwrap();
    assert!(white[0].within_reach() && white[0].thickness_cm < 2.0 && white[0].light.y > 0.1, "{:?}", white[0]);
    assert_eq!(white[0].sample, SnowSample::default(), "a parameter without effect must not change");
    let black = closest(Xyz::default(), Illuminant::D65, &default_problem(&[THICKNESS]));
    assert!(matches!(black, Err(DatabaseError::DarkTarget)));
    let deep = Problem { thickness_cm: 1e5, ..default_problem(&[]) };
    assert!(matches!(closest(hex("#8090ff"), Illuminant::D65, &deep), Err(DatabaseError::NoLight { .. })));
    let steep = Problem { incidence: Incidence::Beam { angle_deg: 90.0 }, ..default_problem(&[THICKNESS]) };
    assert!(closest(hex("#8090ff"), Illuminant::D65, &steep).is_err());
}
