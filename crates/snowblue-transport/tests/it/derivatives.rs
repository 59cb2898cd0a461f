//! Derivatives of spectra against differences, Taylor's theorem, and laws.

use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams, differentiate_batch, solve_batch};
use snowblue_transport::slab::Fluxes;
use snowblue_transport::{
    GrainSize, Impurities, Incidence, Property, SnowSample, Substance, TruncatedNormal, Variable,
};

use crate::variables::variables;

const OPTIONS: OrdinatesOptions = OrdinatesOptions { tally_rays: 1 << 10, streams: Streams::Auto, seed: 1 };
const NM: [f64; 4] = [400.0, 550.0, 900.0, 1350.0];
const SURFACE_AREA_M2_KG: f64 = 20.0;

/// One slab of one snow.
#[derive(Debug, Clone)]
struct Scene {
    sample: SnowSample,
    case: SlabCase,
}

fn snow() -> SnowSample {
    SnowSample {
        grain_size: GrainSize::from_specific_surface_area(SURFACE_AREA_M2_KG, -5.0).unwrap(),
        ..SnowSample::default()
    }
}

fn scene(sample: SnowSample, thickness_cm: f64, angle_deg: f64, ground_albedo: f64) -> Scene {
    let incidence = if angle_deg < 0.0 { Incidence::Diffuse } else { Incidence::Beam { angle_deg } };
    Scene { sample, case: SlabCase { sample: 0, thickness_cm, incidence, ground_albedo: f64::into(ground_albedo) } }
}

/// Thin, thick and deep, under high and low sun and a white sky, clean, dirty and wet, on black and bright ground.
fn scenes() -> Vec<(&'static str, Scene)> {
    let dirt = Impurities::none()
        .with(Substance::BLACK_CARBON, 200.0)
        .with(Substance::SAHARAN_DUST, 5e4)
        .with(Substance::BROWN_CARBON, 300.0);
    let dirty = SnowSample { impurities: dirt, ..snow() };
    let algae = SnowSample { impurities: dirt.with(Substance::SNOW_ALGAE, 1e5), ..snow() };
    let wet = SnowSample { water_saturation: 0.2, ..snow() };
    let smooth = SnowSample { facetness: TruncatedNormal::exactly(0.0), density_kg_m3: 120.0, ..snow() };
    let soaked = SnowSample { water_saturation: 0.9, impurities: dirt, ..snow() };
    let sizes = GrainSize { min_um: 200.0, max_um: 900.0, ..SnowSample::default().grain_size };
    let range = SnowSample { grain_size: sizes, ..snow() };
    vec![
        ("film", scene(snow(), 1e-4, 30.0, 0.0)),
        ("thin", scene(snow(), 0.1, 15.0, 0.0)),
        ("usual", scene(snow(), 5.0, 60.0, 0.0)),
        ("thick", scene(snow(), 60.0, 20.0, 0.0)),
        ("very thick", scene(snow(), 400.0, -1.0, 0.0)),
        ("half-space", scene(snow(), f64::INFINITY, 50.0, 0.0)),
        ("white half-space", scene(snow(), f64::INFINITY, -1.0, 0.4)),
        ("low sun", scene(snow(), 3.0, 86.0, 0.0)),
        ("lowest sun", scene(dirty, f64::INFINITY, 89.5, 0.0)),
        ("dirty", scene(dirty, 4.0, 45.0, 0.0)),
        ("algae", scene(algae, 1.0, 20.0, 0.3)),
        ("wet", scene(wet, 2.0, 35.0, 0.0)),
        ("soaked", scene(soaked, 8.0, -1.0, 0.2)),
        ("smooth", scene(smooth, 1.0, 70.0, 0.0)),
        ("range", scene(range, 10.0, 10.0, 0.0)),
        ("ground", scene(snow(), 0.5, 25.0, 0.6)),
        ("bright ground", scene(dirty, 1.5, -1.0, 0.95)),
    ]
}

fn batch(scene: &Scene) -> Batch {
    Batch { samples: vec![scene.sample], cases: vec![scene.case.clone()], wavelengths_nm: NM.to_vec() }
}

fn solve(scene: &Scene, options: &OrdinatesOptions) -> Vec<[f64; 3]> {
    let solved = solve_batch(&batch(scene), options, false, &|_| ()).unwrap();
    solved.into_iter().map(|fluxes| fluxes.to_array().map(|one| one.value)).collect()
}

fn differentiate(scene: &Scene, variables: &[Variable], options: &OrdinatesOptions) -> Vec<[f64; 3]> {
    let solved = differentiate_batch(&batch(scene), variables, options, false, &|_| ()).unwrap();
    solved.derivatives.into_iter().map(Fluxes::to_array).collect()
}

/// The value of a variable, if the scene has one.
fn value(scene: &Scene, variable: Variable) -> Option<f64> {
    let Scene { sample, case } = scene;
    Some(match variable {
        Variable::Snow(Property::SurfaceArea) => 4.0 * sample.extinction_per_m() / sample.density_kg_m3,
        Variable::Snow(Property::Density) => sample.density_kg_m3,
        Variable::Thickness => Some(case.thickness_cm).filter(|thickness_cm| thickness_cm.is_finite())?,
        Variable::Snow(Property::WaterSaturation) => sample.water_saturation,
        Variable::Snow(Property::Impurity(substance)) => sample.impurities.ng_g(substance),
        Variable::Snow(_) => unreachable!("{variable} has no derivatives"),
        Variable::CosIncidence => match case.incidence {
            Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
            Incidence::Diffuse => return None,
        },
        Variable::GroundAlbedo => case.ground_albedo.at(550.0),
    })
}

/// The scene with another value of a variable.
fn with(scene: &Scene, variable: Variable, value_then: f64) -> Scene {
    let mut changed = scene.clone();
    let Scene { sample, case } = &mut changed;
    match variable {
        Variable::Snow(Property::SurfaceArea) => {
            let ratio = value(scene, variable).unwrap() / value_then;
            sample.grain_size.min_um *= ratio;
            sample.grain_size.max_um *= ratio;
        }
        Variable::Snow(Property::Density) => sample.density_kg_m3 = value_then,
        Variable::Thickness => case.thickness_cm = value_then,
        Variable::Snow(Property::WaterSaturation) => sample.water_saturation = value_then,
        Variable::Snow(Property::Impurity(substance)) => {
            sample.impurities = sample.impurities.with(substance, value_then)
        }
        Variable::Snow(_) => unreachable!("{variable} has no derivatives"),
        Variable::CosIncidence => case.incidence = Incidence::Beam { angle_deg: value_then.acos().to_degrees() },
        Variable::GroundAlbedo => case.ground_albedo = value_then.into(),
    }
    changed
}

/// Derivatives by differences: the sum of `weight` (f(p + `steps` h) − f(p))/h over the terms; for R and T f ln(f(p +
/// `steps` h)/f(p))/h, so that no exponential decay is truncated.
fn differences(
    scene: &Scene,
    variable: Variable,
    (at, step): (f64, f64),
    terms: &[(f64, f64)],
    options: &OrdinatesOptions,
) -> Vec<[f64; 3]> {
    let values = solve(scene, options);
    let mut sums = vec![[0.0; 3]; values.len()];
    for (steps, weight) in terms {
        let there = solve(&with(scene, variable, at + steps * step), options);
        for (place, sum) in sums.iter_mut().flatten().enumerate() {
            let (here, there) = (values[place / 3][place % 3], there[place / 3][place % 3]);
            let change = if place % 3 == 2 || here <= 0.0 { there - here } else { here * (there / here).ln() };
            *sum += weight * change / step;
        }
    }
    sums
}

/// The flux that an absorptance is precise to; reflectance and transmittance are precise to themselves.
fn scale(flux: usize, values: &[f64; 3]) -> f64 {
    if flux == 2 { 1.0 } else { values[flux] }
}

/// The rounding of a sum of terms.
fn rounding(terms: &[(f64, f64)]) -> f64 {
    1e-14 * terms.iter().map(|(_, weight)| weight.abs()).sum::<f64>()
}

/// Within 10⁻⁵ of the differences, whose terms each round by 10⁻¹⁴ of the flux.
fn assert_near(what: &str, (found, expected): (&[[f64; 3]], &[[f64; 3]]), values: &[[f64; 3]], rounding: f64) {
    for (place, ((found, expected), values)) in found.iter().zip(expected).zip(values).enumerate() {
        for flux in 0..3 {
            let (found, expected) = (found[flux], expected[flux]);
            let tolerance = 1e-5 * expected.abs() + rounding * scale(flux, values);
            let message = format!("{what}, {} nm, {}", NM[place], ["R", "T", "A"][flux]);
            assert!((found - expected).abs() <= tolerance, "{message}: {found:e}, but by differences {expected:e}");
        }
    }
}

/// The derivatives by one of [`variables`] at each wavelength.
fn column(all: &[[f64; 3]], place: usize) -> Vec<[f64; 3]> {
    all.iter().skip(place).step_by(variables().len()).copied().collect()
}

/// Central differences over h and 2h, extrapolated: their error is of the order h⁴.
#[test]
fn derivatives_agree_with_central_differences() {
    let central = [(2.0, -1.0), (1.0, 8.0), (-1.0, -8.0), (-2.0, 1.0)].map(|(steps, weight)| (steps, weight / 12.0));
    let mut compared = 0;
    for (name, scene) in scenes() {
        let (derivatives, values) = (differentiate(&scene, &variables(), &OPTIONS), solve(&scene, &OPTIONS));
        for (place, variable) in variables().into_iter().enumerate() {
            let Some(at) = value(&scene, variable) else {
                assert!(column(&derivatives, place).iter().flatten().all(|derivative| derivative.abs() <= 0.0));
                continue;
            };
            let room = if at < 1.0 { at.min(1.0 - at) } else { at };
            if room <= 0.0 {
                continue;
            }
            let step = 1e-3 * room;
            let expected = differences(&scene, variable, (at, step), &central, &OPTIONS);
            assert_near(
                &format!("{name}, {variable}"),
                (&column(&derivatives, place), &expected),
                &values,
                rounding(&central) / step,
            );
            compared += 1;
        }
    }
    // Surface area and density of all, thickness of all but three, the cosine of beams, water, dirt and grounds.
    assert_eq!(compared, 17 + 17 + 14 + 13 + 2 + 16 + 5);
}

/// Clean and dry snow on black ground, towards a little dirt, water and light from below; no snow, towards a little;
/// and what can only be less: water that fills the pores, a vertical beam, white ground.
#[test]
fn derivatives_at_the_ends_of_ranges_agree_with_differences_to_one_side() {
    let one_sided = [(1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)];
    // Water and algae would change the number of streams.
    let options = OrdinatesOptions { streams: Streams::Exactly(16), ..OPTIONS };
    let saturated = SnowSample { water_saturation: 1.0, ..snow() };
    let ends = [("nothing", scene(snow(), 0.0, 20.0, 0.5)), ("saturated", scene(saturated, 3.0, 0.0, 1.0))];
    let mut compared = 0;
    // Such differences in a film are rounding.
    for (name, scene) in scenes().into_iter().skip(1).take(5).chain(ends) {
        let (derivatives, values) = (differentiate(&scene, &variables(), &options), solve(&scene, &options));
        for (place, variable) in variables().into_iter().enumerate() {
            // Traces change deep snow.
            let depth_cm = 1.0 + scene.case.thickness_cm.min(1e3);
            let is_fraction = matches!(
                variable,
                Variable::Snow(Property::WaterSaturation) | Variable::CosIncidence | Variable::GroundAlbedo
            );
            let step = match variable {
                Variable::Snow(Property::Impurity(Substance::BLACK_CARBON | Substance::BROWN_CARBON)) => 1.0 / depth_cm,
                Variable::Snow(Property::Impurity(_)) => 100.0 / depth_cm,
                // The steepest mode decays over 10⁻³ cm.
                Variable::Thickness => 1e-6,
                _ => 1e-3 / depth_cm,
            };
            let step = match value(&scene, variable) {
                Some(at) if at <= 0.0 => step,
                Some(at) if at >= 1.0 && is_fraction => -step,
                _ => continue,
            };
            let at = value(&scene, variable).unwrap();
            let expected = differences(&scene, variable, (at, step), &one_sided, &options);
            assert_near(
                &format!("{name}, {variable}"),
                (&column(&derivatives, place), &expected),
                &values,
                rounding(&one_sided) / step.abs(),
            );
            compared += 1;
        }
    }
    // Five impurities of all, water and ground of dry snow on black ground, and each end.
    assert_eq!(compared, 5 * 7 + (5 + 1 + 1) + (5 + 3));
}

/// f(p + h) − f(p) − f' h is f'' h²/2 to leading order: half the step leaves a quarter of it.
#[test]
fn the_remainder_of_taylor_is_of_second_order() {
    let mut tested = 0;
    for (name, scene) in scenes() {
        let (derivatives, values) = (differentiate(&scene, &variables(), &OPTIONS), solve(&scene, &OPTIONS));
        for (place, variable) in variables().into_iter().enumerate() {
            let Some(at) = value(&scene, variable).filter(|at| *at > 0.0) else { continue };
            let step = 4e-3 * if at < 1.0 { at.min(1.0 - at) } else { at };
            let there = [1.0, 0.5].map(|part| solve(&with(&scene, variable, at + part * step), &OPTIONS));
            for (wavelength, derivative) in column(&derivatives, place).iter().enumerate() {
                for flux in 0..2 {
                    let value = values[wavelength][flux];
                    let [whole, half] = [1.0, 0.5].map(|part| {
                        let there = &there[usize::from(part < 1.0)];
                        there[wavelength][flux] - value - derivative[flux] * part * step
                    });
                    // Where the curvature is seen above the rounding, by 10³.
                    if half.abs() > 1e-11 * value {
                        let ratio = whole / half;
                        // The next term is some h/p times the number of e-foldings, 265 at most.
                        let folds = 1.0 + value.ln().abs();
                        assert!((ratio - 4.0).abs() < 0.05 * folds, "{name}, {variable}, {}: {ratio}", NM[wavelength]);
                        tested += 1;
                    }
                }
            }
        }
    }
    assert!(tested > 300, "{tested}");
}

/// Dry snow depends on density and thickness by their product only, and a half-space of it on neither.
#[test]
fn density_and_thickness_act_as_one_in_dry_snow() {
    for (name, scene) in scenes().into_iter().filter(|(_, scene)| scene.sample.water_saturation <= 0.0) {
        let found = differentiate(&scene, &[Variable::Snow(Property::Density), Variable::Thickness], &OPTIONS);
        let values = solve(&scene, &OPTIONS);
        for (place, pair) in found.chunks(2).enumerate() {
            for flux in 0..2 {
                let by_density = pair[0][flux] * scene.sample.density_kg_m3;
                let by_thickness =
                    if scene.case.thickness_cm.is_finite() { pair[1][flux] * scene.case.thickness_cm } else { 0.0 };
                // Rounding.
                let tolerance = 1e-10 * by_thickness.abs() + 1e-13 * values[place][flux];
                assert!((by_density - by_thickness).abs() <= tolerance, "{name}: {by_density:e} {by_thickness:e}");
            }
        }
    }
}

/// Other slabs and standard errors do not change a bit of a derivative, and other variables only its rounding.
#[test]
fn derivatives_are_those_that_a_slab_has_alone() {
    let scenes = scenes();
    let cases = scenes.iter().enumerate().map(|(sample, (_, scene))| SlabCase { sample, ..scene.case.clone() });
    let together = Batch {
        samples: scenes.iter().map(|(_, scene)| scene.sample).collect(),
        cases: cases.collect(),
        wavelengths_nm: NM.to_vec(),
    };
    let solved = differentiate_batch(&together, &variables(), &OPTIONS, true, &|_| ()).unwrap();
    let bits = |rows: &[[f64; 3]]| -> Vec<u64> { rows.iter().flatten().map(|value| value.to_bits()).collect() };
    let per_case = NM.len() * variables().len();
    for ((name, scene), rows) in scenes.iter().zip(solved.derivatives.chunks(per_case)) {
        let rows: Vec<[f64; 3]> =
            rows.iter().map(|row| [row.reflectance, row.transmittance, row.absorptance]).collect();
        assert_eq!(bits(&rows), bits(&differentiate(scene, &variables(), &OPTIONS)), "{name}");
        let values = solve(scene, &OPTIONS);
        for (place, variable) in variables().into_iter().enumerate() {
            let by_one = differentiate(scene, &[variable], &OPTIONS);
            for (wavelength, (of_all, alone)) in column(&rows, place).iter().zip(&by_one).enumerate() {
                for flux in 0..2 {
                    // Substances that are differentiated by take part in the sums of the medium, which round.
                    let tolerance = 1e-9 * alone[flux].abs() + 1e-15 * values[wavelength][flux];
                    assert!((of_all[flux] - alone[flux]).abs() <= tolerance, "{name}, {variable}");
                }
            }
        }
    }
    let values = solve_batch(&together, &OPTIONS, true, &|_| ()).unwrap();
    assert_eq!(values, solved.fluxes);
    let twice = differentiate(&scenes[0].1, &[Variable::Snow(Property::Density); 2], &OPTIONS);
    assert_eq!(bits(&twice[..1]), bits(&twice[1..2]));
}
