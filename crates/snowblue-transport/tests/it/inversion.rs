//! Retrieval of snow from spectra: identical twins, limits of information, and laws of the posterior.

use nalgebra::{DMatrix, DVector};
use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::inversion::{
    Illumination, Inversion, InversionError, Measured, Observation, Outcome, Quantity, Retrieval,
};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams, solve_batch, solve_stack_without_errors};
use snowblue_transport::rng::Stream;
use snowblue_transport::{
    GrainSize, GroundAlbedo, IceTable, Incidence, Layer, LayerVariable, Property, SnowSample, Stack, Substance,
    Variable,
};

const OPTIONS: OrdinatesOptions = OrdinatesOptions { tally_rays: 1 << 10, streams: Streams::Auto, seed: 1 };
const NM: [f64; 12] = [400.0, 450.0, 500.0, 600.0, 700.0, 800.0, 900.0, 1000.0, 1030.0, 1100.0, 1200.0, 1300.0];
const SOOT: Variable = Variable::impurity(Substance::BLACK_CARBON);
const DUST: Variable = Variable::impurity(Substance::SAHARAN_DUST);

/// Snow under a light, with the medians of the prior.
#[derive(Debug, Clone)]
struct Truth {
    area_m2_kg: f64,
    soot_ng_g: f64,
    thickness_cm: f64,
    light: Illumination,
}

fn beam(angle_deg: f64) -> Illumination {
    Illumination::Single(Incidence::Beam { angle_deg })
}

fn deep(area_m2_kg: f64, soot_ng_g: f64, light: Illumination) -> Truth {
    Truth { area_m2_kg, soot_ng_g, thickness_cm: f64::INFINITY, light }
}

fn inversion(variables: &[Variable], deviations: &[f64]) -> Inversion {
    let n = variables.len();
    let entry = |k: usize| if k / n == k % n { deviations[k / n].powi(2) } else { 0.0 };
    Inversion {
        wavelengths_nm: NM.to_vec(),
        bands: None,
        variables: variables.iter().copied().map(LayerVariable::from).collect(),
        prior_covariance: (0..n * n).map(entry).collect(),
        options: OPTIONS,
    }
}

/// Exact albedo and transmittance at each wavelength.
fn exact(truth: &Truth) -> [Vec<f64>; 2] {
    let grain_size = GrainSize::from_specific_surface_area(truth.area_m2_kg, -5.0).unwrap();
    let impurities = SnowSample::default().impurities.with(Substance::BLACK_CARBON, truth.soot_ng_g);
    let sample = SnowSample { grain_size, impurities, ..SnowSample::default() };
    let (incidences, diffuse) = match &truth.light {
        Illumination::Single(incidence) => (vec![*incidence; 2], vec![0.0; NM.len()]),
        Illumination::Mixed { angle_deg, diffuse_fractions } => {
            (vec![Incidence::Beam { angle_deg: *angle_deg }, Incidence::Diffuse], diffuse_fractions.clone())
        }
    };
    let case = |incidence: &Incidence| SlabCase {
        sample: 0,
        thickness_cm: truth.thickness_cm,
        incidence: *incidence,
        ground_albedo: 0.0.into(),
    };
    let batch =
        Batch { samples: vec![sample], cases: incidences.iter().map(case).collect(), wavelengths_nm: NM.to_vec() };
    let solved = solve_batch(&batch, &OPTIONS, false, &|_| ()).unwrap();
    let mixed = |k: usize, of: &dyn Fn(usize) -> f64| (1.0 - diffuse[k]) * of(k) + diffuse[k] * of(NM.len() + k);
    [
        (0..NM.len()).map(|k| mixed(k, &|row| solved[row].reflectance.value)).collect(),
        (0..NM.len()).map(|k| mixed(k, &|row| solved[row].transmittance.value)).collect(),
    ]
}

fn measured(values: Vec<f64>, deviation: f64) -> Measured {
    Measured {
        quantity: Quantity::Albedo,
        depths_cm: vec![],
        standard_deviations: vec![deviation; values.len()],
        values,
        scale_error: 0.0,
        correlation_nm: 0.0,
    }
}

/// The albedo of a truth, without errors but with a stated one.
fn observation(truth: &Truth, medians: &[f64], deviation: f64) -> Observation {
    let [albedo, _] = exact(truth);
    Observation {
        layers: vec![Layer::snow(SnowSample::default(), truth.thickness_cm)],
        ground_albedo: 0.0.into(),
        illumination: truth.light.clone(),
        prior_medians: medians.to_vec(),
        measured: vec![measured(albedo, deviation)],
    }
}

fn retrieve(inversion: &Inversion, spectra: &[Observation]) -> Vec<Retrieval> {
    inversion.retrieve(spectra, &|_| ()).unwrap()
}

fn one(inversion: &Inversion, observation: Observation) -> Retrieval {
    retrieve(inversion, &[observation]).remove(0)
}

/// A normal number (Box & Muller 1958).
fn normal(stream: &mut Stream) -> f64 {
    (-2.0 * stream.uniform().ln()).sqrt() * (std::f64::consts::TAU * stream.uniform()).cos()
}

/// Errors of unit variance at ascending wavelengths that correlate over `length_nm`.
fn correlated(stream: &mut Stream, wavelengths_nm: &[f64], length_nm: f64) -> Vec<f64> {
    let mut error = normal(stream);
    let mut errors = vec![error];
    for pair in wavelengths_nm.windows(2) {
        let rho = if length_nm > 0.0 { (-(pair[1] - pair[0]) / length_nm).exp() } else { 0.0 };
        error = rho * error + (1.0 - rho * rho).sqrt() * normal(stream);
        errors.push(error);
    }
    errors
}

/// States drawn from the prior, with errors drawn from the stated covariance: independent, correlated, and with a
/// common scale, under a sun, a white sky and a mix. The true state lies in the ellipse that holds 95 % of the
/// posterior, and each variable in its interval, as often as 400 draws with probability 0.95 do: 364 to 393 times are
/// the 0.05 % and 99.95 % quantiles of the binomial distribution.
#[test]
fn identical_twins_are_recovered_within_their_posterior() {
    check_twins(400, 364..=393, None);
}

/// The weights of [`NM`] in the bands of a sensor: two in the visible, two in the near infrared and one beyond.
fn bands() -> Vec<Vec<f64>> {
    let band = |weights: &[(usize, f64)]| {
        let mut band = vec![0.0; NM.len()];
        weights.iter().for_each(|(place, weight)| band[*place] = *weight);
        band
    };
    vec![
        band(&[(1, 0.5), (2, 0.5)]),
        band(&[(3, 0.75), (4, 0.25)]),
        band(&[(5, 0.25), (6, 0.75)]),
        band(&[(7, 0.25), (8, 0.5), (9, 0.25)]),
        band(&[(10, 0.5), (11, 0.5)]),
    ]
}

/// The mean of a spectrum over each band.
fn means(bands: &[Vec<f64>], spectrum: &[f64]) -> Vec<f64> {
    bands.iter().map(|band| band.iter().zip(spectrum).map(|(weight, value)| weight * value).sum()).collect()
}

/// The same where the albedo is measured in bands, whose errors correlate by their mean wavelengths: of 200 twins 179
/// to 198.
#[test]
fn twins_in_bands_are_recovered_within_their_posterior() {
    check_twins(200, 179..=198, Some(bands()));
}

/// Twins at wavelengths or in bands, and how many of them the ellipse and the intervals have to hold.
fn check_twins(count: usize, expected: std::ops::RangeInclusive<usize>, bands: Option<Vec<Vec<f64>>>) {
    const DEVIATION: f64 = 0.01;
    let (medians, deviations) = ([25.0, 150.0], [0.4, 0.5]);
    let inversion =
        Inversion { bands: bands.clone(), ..inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &deviations) };
    let channels_nm = bands.as_ref().map_or(NM.to_vec(), |bands| means(bands, &NM));
    let mut stream = Stream::new(11, 0);
    let lights = [
        beam(60.0),
        Illumination::Single(Incidence::Diffuse),
        Illumination::Mixed { angle_deg: 75.0, diffuse_fractions: NM.map(|nm| (400.0 / nm).powi(3)).to_vec() },
        beam(20.0),
    ];
    let twin = |number: usize| {
        let draw = [normal(&mut stream), normal(&mut stream)];
        let at = |i: usize| medians[i] * (deviations[i] * draw[i]).exp();
        let truth = deep(at(0), at(1), lights[number % lights.len()].clone());
        let mut twin = observation(&truth, &medians, DEVIATION);
        let albedo = &mut twin.measured[0];
        if let Some(bands) = &bands {
            *albedo = measured(means(bands, &albedo.values), DEVIATION);
        }
        albedo.correlation_nm = if number % 3 == 1 { 150.0 } else { 0.0 };
        albedo.scale_error = if number % 3 == 2 { 0.02 } else { 0.0 };
        let factor = (albedo.scale_error * normal(&mut stream)).exp();
        let errors = correlated(&mut stream, &channels_nm, albedo.correlation_nm);
        for (value, error) in albedo.values.iter_mut().zip(errors) {
            *value = factor * *value + DEVIATION * error;
        }
        (truth, twin)
    };
    let (truths, twins): (Vec<Truth>, Vec<Observation>) = (0..count).map(twin).unzip();
    let found = retrieve(&inversion, &twins);
    let (mut in_ellipse, mut in_interval, mut chi_square) = (0, [0, 0], 0.0);
    for (truth, retrieval) in truths.iter().zip(&found) {
        assert_eq!(retrieval.outcome, Outcome::Converged, "{truth:?} {retrieval:?}");
        assert!((0.0..=2.0).contains(&retrieval.degrees_of_freedom), "{retrieval:?}");
        let truth = [truth.area_m2_kg, truth.soot_ng_g];
        for (i, value) in retrieval.values.iter().enumerate() {
            in_interval[i] += usize::from((value.interval[0]..=value.interval[1]).contains(&truth[i]));
        }
        let [x, y] = [0, 1].map(|i: usize| (truth[i] / retrieval.values[i].median).ln());
        let [a, b, _, d] = retrieval.covariance[..] else { unreachable!() };
        let distance = (d * x * x - 2.0 * b * x * y + a * y * y) / (a * d - b * b);
        // −2 ln 0.05, the 95 % quantile of χ² with 2 degrees of freedom.
        in_ellipse += usize::from(distance <= 5.991_464_547);
        chi_square += retrieval.chi_square;
    }
    for held in [in_ellipse, in_interval[0], in_interval[1]] {
        assert!(expected.contains(&held), "{in_ellipse} {in_interval:?}");
    }
    // χ² with as many degrees of freedom as values: 3.3 of its standard deviations, √(2 · 4800) of 400 spectra.
    let expected = (count * channels_nm.len()) as f64;
    assert!((chi_square - expected).abs() < 3.3 * (2.0 * expected).sqrt(), "{chi_square}");
}

/// A band of one wavelength is that wavelength, in any order, also where some are missing or their errors correlate.
#[test]
fn bands_of_single_wavelengths_have_the_posterior_of_the_wavelengths() {
    let at_wavelengths = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let order: Vec<usize> = (0..NM.len()).rev().collect();
    let single = |place: usize| (0..NM.len()).map(|other| f64::from(u8::from(other == place))).collect();
    let bands = Some(order.iter().map(|place| single(*place)).collect());
    let in_bands = Inversion { bands, ..at_wavelengths.clone() };
    let mut spectrum = observation(&deep(20.0, 100.0, beam(60.0)), &[30.0, 50.0], 0.01);
    let albedo = &mut spectrum.measured[0];
    (albedo.correlation_nm, albedo.scale_error, albedo.values[3]) = (100.0, 0.02, f64::NAN);
    let expected = one(&at_wavelengths, spectrum.clone());
    spectrum.measured[0].values = order.iter().map(|place| spectrum.measured[0].values[*place]).collect();
    let found = one(&in_bands, spectrum);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 1e-9 || a.is_nan());
    for (a, b) in found.values.iter().zip(&expected.values) {
        assert!(near(&[a.median, a.standard_deviation], &[b.median, b.standard_deviation]), "{found:?} {expected:?}");
    }
    assert!(near(&found.covariance, &expected.covariance) && near(&[found.chi_square], &[expected.chi_square]));
    let reordered: Vec<f64> = order.iter().map(|place| expected.fits[0][*place]).collect();
    assert!(near(&found.fits[0], &reordered) && found.data == 11 && found.fits[0][8].is_nan());
}

/// Picard's table of ice begins at 320 nm, and only one of the bands needs shorter wavelengths.
#[test]
fn a_spectrum_needs_the_wavelengths_of_its_own_bands_only() {
    let wavelengths_nm = [&[310.0], &NM[..]].concat();
    let mut all: Vec<Vec<f64>> = bands().into_iter().map(|band| [vec![0.0], band].concat()).collect();
    let mut last = vec![0.0; NM.len() + 1];
    (last[0], last[1]) = (0.5, 0.5);
    all.push(last);
    let whole = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let inversion = Inversion { wavelengths_nm, bands: Some(all), ..whole.clone() };
    let mut spectrum = observation(&deep(20.0, 100.0, beam(60.0)), &[30.0, 50.0], 0.01);
    spectrum.layers[0].sample_mut().unwrap().ice = IceTable::Picard2016;
    let values = means(&bands(), &spectrum.measured[0].values);
    let expected = one(
        &Inversion { bands: Some(bands()), ..whole },
        Observation { measured: vec![measured(values.clone(), 0.01)], ..spectrum.clone() },
    );
    spectrum.measured[0] = measured([values, vec![f64::NAN]].concat(), 0.01);
    let found = one(&inversion, spectrum.clone());
    assert!((found.values[0].median / expected.values[0].median - 1.0).abs() < 1e-9, "{found:?} {expected:?}");
    assert!(found.fits[0][5].is_nan() && found.fits[0][4].is_finite());
    spectrum.measured[0].values[5] = 0.3;
    let error = inversion.retrieve(&[spectrum], &|_| ()).unwrap_err();
    assert_eq!((error.observation, error.wavelength), (Some(0), Some(5)), "{error}");
    assert!(error.to_string().contains("wavelength is 310 nm"), "{error}");
}

#[test]
fn wrong_bands_are_named() {
    let spectrum = observation(&deep(20.0, 100.0, beam(60.0)), &[30.0, 50.0], 0.01);
    let of_bands = measured(means(&bands(), &spectrum.measured[0].values), 0.01);
    let wrong = |bands: Vec<Vec<f64>>, albedo: Measured| {
        let inversion =
            Inversion { bands: Some(bands), ..inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]) };
        let error = inversion.retrieve(&[Observation { measured: vec![albedo], ..spectrum.clone() }], &|_| ());
        let error = error.unwrap_err();
        (error.wavelength, error.to_string())
    };
    let changed = |band: usize, weights: Vec<f64>| {
        let mut all = bands();
        all[band] = weights;
        all
    };
    let told = |(place, text): (Option<usize>, String), expected: Option<usize>, words: &str| {
        assert!(place == expected && text.contains(words), "{place:?} {text}");
    };
    told(wrong(vec![], of_bands.clone()), None, "band");
    told(wrong(changed(1, vec![1.0]), of_bands.clone()), Some(1), "as many as there are wavelengths");
    told(wrong(changed(2, [vec![1.5, -0.5], vec![0.0; 10]].concat()), of_bands.clone()), Some(2), "negative");
    told(wrong(changed(3, vec![0.1; 12]), of_bands.clone()), Some(3), "sum of the weights of a band must be 1");
    told(wrong(bands(), spectrum.measured[0].clone()), None, "as many as there are bands");
    let mut bright = of_bands.clone();
    bright.values[4] = 2.0;
    told(wrong(bands(), bright), Some(4), "albedo is 2");
    let twice = changed(1, bands()[0].clone());
    told(wrong(twice, Measured { correlation_nm: 50.0, ..of_bands }), Some(1), "mean wavelength of a band is that of");
}

/// At the mode x̂ of exact data, KᵀK (x − x̂) = S_a⁻¹ (x̂ − x_a) with the derivatives between x̂ and x, so that
/// x̂ − x = (1 − A)/A (x_a − x̂). Over a shift below 0.002 the derivatives of an albedo change by less than 1 %.
#[test]
fn an_albedo_under_the_sun_is_that_of_its_angle() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea)], &[1.0]);
    let sun = observation(&deep(20.0, 0.0, beam(60.0)), &[30.0], 0.01);
    let found = one(&inversion, sun.clone());
    let (kernel, median) = (found.averaging_kernel[0], found.values[0].median);
    let shift = (median / 20.0).ln();
    let expected = (1.0 - kernel) / kernel * (30.0 / median).ln();
    assert!((shift / expected - 1.0).abs() < 0.01 && shift < 0.002, "{shift} {expected} {found:?}");
    // As diffuse light it would be another snow, whose albedo fits less well.
    let wrong = one(&inversion, Observation { illumination: Illumination::Single(Incidence::Diffuse), ..sun });
    assert!(wrong.values[0].median > 24.0 && wrong.data_chi_square > 10.0 * found.data_chi_square, "{wrong:?}");
}

#[test]
fn a_mix_of_light_lies_between_its_parts() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let mixed = |fraction: f64| Illumination::Mixed { angle_deg: 20.0, diffuse_fractions: vec![fraction; NM.len()] };
    let retrieved = |truth: Illumination, told: Illumination| {
        let spectrum = observation(&deep(20.0, 100.0, truth), &[20.0, 100.0], 0.01);
        one(&inversion, Observation { illumination: told, ..spectrum }).values[0].median
    };
    let diffuse = Illumination::Single(Incidence::Diffuse);
    for (truth, told) in [(mixed(0.0), beam(20.0)), (mixed(1.0), diffuse.clone()), (mixed(0.3), mixed(0.3))] {
        // The prior's mean is the truth.
        assert!((retrieved(truth, told) - 20.0).abs() < 1e-6);
    }
    // A steep beam is reflected less than diffuse light, as by coarser snow.
    let [by_mixed, by_diffuse] = [mixed(0.3), diffuse].map(|told| retrieved(beam(20.0), told));
    assert!(by_diffuse < by_mixed - 1.0 && by_mixed < 19.0, "{by_mixed} {by_diffuse}");
}

/// To the last bit, also where errors correlate.
#[test]
fn a_mask_of_missing_wavelengths_equals_dropping_them() {
    let whole = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let truth = deep(35.0, 80.0, beam(40.0));
    let mut masked = observation(&truth, &[20.0, 30.0], 0.01);
    let kept: Vec<usize> = (0..NM.len()).filter(|place| ![0, 5, 6, 11].contains(place)).collect();
    let albedo = &mut masked.measured[0];
    (albedo.correlation_nm, albedo.scale_error) = (60.0, 0.01);
    let dropped = Measured {
        values: kept.iter().map(|place| albedo.values[*place]).collect(),
        standard_deviations: kept.iter().map(|place| albedo.standard_deviations[*place]).collect(),
        ..albedo.clone()
    };
    for place in [0, 5, 6, 11] {
        (albedo.values[place], albedo.standard_deviations[place]) = (f64::NAN, f64::NAN);
    }
    let fewer = Inversion { wavelengths_nm: kept.iter().map(|place| NM[*place]).collect(), ..whole.clone() };
    let short = Observation { measured: vec![dropped], ..masked.clone() };
    let (masked, short) = (one(&whole, masked), one(&fewer, short));
    assert_eq!((masked.data, &masked.outcome), (8, &Outcome::Converged));
    assert!(masked.fits[0][5].is_nan());
    let fits = vec![kept.iter().map(|place| masked.fits[0][*place]).collect()];
    assert_eq!(Retrieval { fits, ..masked }, short);
}

/// A spectrum has the result that it has alone, whatever the others are.
#[test]
fn spectra_do_not_depend_on_each_other() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let truths = [deep(8.0, 10.0, beam(10.0)), deep(80.0, 500.0, beam(70.0)), deep(20.0, 1.0, beam(82.0))];
    let spectra: Vec<Observation> = truths.iter().map(|truth| observation(truth, &[20.0, 30.0], 0.01)).collect();
    let together = retrieve(&inversion, &spectra);
    let alone: Vec<Retrieval> = spectra.into_iter().map(|spectrum| one(&inversion, spectrum)).collect();
    assert_eq!(together, alone);
}

#[test]
fn without_information_the_posterior_is_the_prior() {
    let mut inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[0.7, 1.5]);
    (inversion.prior_covariance[1], inversion.prior_covariance[2]) = (0.5, 0.5);
    let vague = observation(&deep(35.0, 80.0, beam(40.0)), &[20.0, 30.0], 1e6);
    let mut empty = vague.clone();
    empty.measured[0].values.fill(f64::NAN);
    let unmeasured = Observation { measured: vec![], ..vague.clone() };
    let found = retrieve(&inversion, &[vague, empty, unmeasured]);
    for retrieval in &found {
        // What the data say is less than 10⁻¹² of what the prior does.
        for (value, prior) in retrieval.values.iter().zip([20.0, 30.0]) {
            assert!((value.median / prior - 1.0).abs() < 1e-12, "{retrieval:?}");
        }
        for (entry, prior) in retrieval.covariance.iter().zip(&inversion.prior_covariance) {
            assert!((entry - prior).abs() < 1e-12, "{retrieval:?}");
        }
        assert!(retrieval.degrees_of_freedom.abs() < 1e-12 && retrieval.averaging_kernel[1].abs() < 1e-12);
    }
    let outcomes: Vec<Outcome> = found.iter().map(|retrieval| retrieval.outcome.clone()).collect();
    assert_eq!(outcomes, [Outcome::Converged, Outcome::NoData, Outcome::NoData]);
}

/// Better data, and more of them, determine more.
#[test]
fn information_grows_with_the_data() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT, Variable::Thickness], &[1.0, 2.0, 1.0]);
    let truth = Truth { thickness_cm: 6.0, ..deep(20.0, 100.0, beam(30.0)) };
    let both = |deviation: f64, relative: Option<f64>| {
        let [albedo, transmittance] = exact(&truth);
        let measure = |relative: f64| Measured {
            quantity: Quantity::Transmittance,
            standard_deviations: transmittance.iter().map(|value| relative * value).collect(),
            ..measured(transmittance.clone(), 1.0)
        };
        Observation {
            measured: [measured(albedo, deviation)].into_iter().chain(relative.map(measure)).collect(),
            ..observation(&truth, &[20.0, 100.0, 6.0], deviation)
        }
    };
    let cases = [both(1.0, None), both(0.02, None), both(0.005, None), both(0.005, Some(0.1)), both(1e-4, Some(1e-3))];
    let found = retrieve(&inversion, &cases);
    let degrees: Vec<f64> = found.iter().map(|retrieval| retrieval.degrees_of_freedom).collect();
    assert!(degrees.windows(2).all(|pair| pair[0] < pair[1]), "{degrees:?}");
    assert!(degrees[0] > 0.0 && degrees[4] < 3.0 && degrees[4] > 2.9, "{degrees:?}");
    let errors = |i: usize| found.iter().map(|retrieval| retrieval.values[i].standard_deviation).collect::<Vec<_>>();
    for i in 0..3 {
        assert!(errors(i).windows(2).all(|pair| pair[1] < pair[0]), "{:?}", errors(i));
    }
}

/// dx̂/dx by central differences where the truth is the prior's mean, so that the retrieval is the truth. The error of
/// the difference is of second order in the step, 0.0025 of the third derivative, which is below that of an exponential
/// model, A (1 − A) < 0.25. A search ends with gᵀδ below 10⁻⁶ per element, less than 10⁻³ of a standard deviation from
/// the mode; the last step δ is taken, and what it leaves is of second order, below 10⁻⁵ over a difference of 0.1.
#[test]
fn the_averaging_kernel_is_the_derivative_of_the_retrieval() {
    const STEP: f64 = 0.05;
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[0.5, 1.0]);
    let mean = [20.0, 60.0];
    let at = |i: usize, sign: f64| {
        let mut state = mean;
        state[i] *= (sign * STEP).exp();
        let mut spectrum = observation(&deep(state[0], state[1], beam(30.0)), &mean, 0.02);
        spectrum.measured[0].scale_error = 0.02;
        spectrum
    };
    let cases = [at(0, 0.0), at(0, 1.0), at(0, -1.0), at(1, 1.0), at(1, -1.0)];
    let found = retrieve(&inversion, &cases);
    let element = |retrieval: &Retrieval, i: usize| retrieval.values[i].median.ln();
    let kernel = &found[0].averaging_kernel;
    for i in 0..2 {
        for j in 0..2 {
            let difference = (element(&found[1 + 2 * j], i) - element(&found[2 + 2 * j], i)) / (2.0 * STEP);
            assert!((kernel[2 * i + j] - difference).abs() < 1e-3, "{i} {j}: {kernel:?} {difference}");
        }
    }
    // It is neither 0 nor the identity.
    assert!(kernel[3] > 0.05 && kernel[3] < 0.95 && kernel[2].abs() > 0.005, "{kernel:?}");
}

#[test]
fn an_error_of_scale_is_retrieved_with_the_snow() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let truth = deep(20.0, 100.0, beam(30.0));
    let mut scaled = observation(&truth, &[20.0, 100.0], 0.002);
    scaled.measured[0].values.iter_mut().for_each(|value| *value *= 1.03);
    let trusted = one(&inversion, scaled.clone());
    scaled.measured[0].scale_error = 0.05;
    let free = one(&inversion, scaled);
    let distance = |retrieval: &Retrieval| (retrieval.values[0].median - 20.0) / retrieval.values[0].standard_deviation;
    assert!(distance(&trusted) > 10.0 && distance(&free).abs() < 1.0, "{trusted:?} {free:?}");
    assert!((free.scales[0].median - 1.03).abs() < free.scales[0].standard_deviation, "{free:?}");
    assert!(trusted.chi_square > 10.0 * free.chi_square);
    assert!((trusted.scales[0].interval[1] - 1.0).abs() < 1e-15);
}

/// Albedo and transmittance together, of all variables that they can tell apart.
#[test]
fn every_variable_can_be_retrieved() {
    let truth = Truth { thickness_cm: 3.0, ..deep(25.0, 100.0, beam(45.0)) };
    let [albedo, transmittance] = exact(&truth);
    for (variable, value, wrong) in [
        (Variable::Snow(Property::SurfaceArea), 25.0, 10.0),
        (Variable::Snow(Property::Density), 300.0, 200.0),
        (Variable::Thickness, 3.0, 5.0),
        (SOOT, 100.0, 30.0),
        (Variable::CosIncidence, 45_f64.to_radians().cos(), 0.5),
    ] {
        let grain_size = GrainSize::from_specific_surface_area(25.0, -5.0).unwrap();
        let impurities = SnowSample::default().impurities.with(Substance::BLACK_CARBON, 100.0);
        let transmittance = Measured { quantity: Quantity::Transmittance, ..measured(transmittance.clone(), 1e-3) };
        let sample = SnowSample { grain_size, impurities, ..SnowSample::default() };
        let spectrum = Observation {
            layers: vec![Layer::snow(sample, truth.thickness_cm)],
            measured: vec![measured(albedo.clone(), 1e-3), transmittance],
            ..observation(&truth, &[wrong], 1e-3)
        };
        let found = one(&inversion(&[variable], &[2.0]), spectrum);
        let off = found.values[0].median - value;
        assert!(
            found.outcome == Outcome::Converged && off.abs() < 0.1 * found.values[0].standard_deviation,
            "{found:?}"
        );
        assert!(found.data == 24 && found.data_chi_square < 0.1 && found.solutions < 30, "{found:?}");
    }
    // What is not in the snow, and what darkens it in another way.
    for (variable, median) in
        [(DUST, 1000.0), (Variable::GroundAlbedo, 0.2), (Variable::Snow(Property::WaterSaturation), 0.02)]
    {
        let grain_size = GrainSize::from_specific_surface_area(25.0, -5.0).unwrap();
        let sample = SnowSample { grain_size, ..SnowSample::default() };
        let spectrum = Observation {
            layers: vec![Layer::snow(sample, truth.thickness_cm)],
            ..observation(&Truth { soot_ng_g: 0.0, ..truth.clone() }, &[median], 1e-4)
        };
        let found = one(&inversion(&[variable], &[2.0]), spectrum);
        assert!(found.values[0].interval[1] < 0.3 * median && found.outcome != Outcome::NotConverged, "{found:?}");
    }
}

#[test]
fn a_variable_at_an_end_of_its_range_is_named() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea)], &[3.0]);
    let mut bright = observation(&deep(200.0, 0.0, beam(0.0)), &[20.0], 0.005);
    bright.measured[0].values.fill(1.0);
    let found = one(&inversion, bright);
    assert_eq!(found.outcome, Outcome::AtEndOfRange(vec![Variable::Snow(Property::SurfaceArea).into()]));
    assert!((found.values[0].median - 300.0).abs() < 1e-9);
    // It is held there: a slightly different snow would be retrieved as the same.
    let posterior = [found.averaging_kernel[0], found.covariance[0], found.degrees_of_freedom];
    assert!(posterior.iter().all(|entry| entry.abs() < f64::MIN_POSITIVE), "{found:?}");
    assert_eq!(found.outcome.to_string(), "ssa_m2_kg is at an end of its range");
}

#[test]
fn all_variables_at_ends_of_their_ranges_are_named() {
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[3.0, 3.0]);
    let mut black = observation(&deep(200.0, 0.0, beam(0.0)), &[20.0, 100.0], 0.005);
    black.measured[0].values.fill(0.002);
    let outcome = one(&inversion, black).outcome.to_string();
    assert!(
        outcome.starts_with("ssa_m2_kg and black") && outcome.ends_with("are at ends of their ranges"),
        "{outcome}"
    );
}

/// The wavelengths of other spectra, at which the model of its snow does not hold, are not those of a spectrum.
#[test]
fn a_spectrum_needs_its_own_wavelengths_only() {
    let mut inversion = inversion(&[Variable::Snow(Property::SurfaceArea)], &[1.0]);
    let mut dry = observation(&deep(20.0, 0.0, beam(30.0)), &[20.0], 0.01);
    let mut picard = dry.clone();
    picard.layers[0].sample_mut().unwrap().ice = IceTable::Picard2016;
    inversion.wavelengths_nm.push(310.0);
    for (spectrum, value) in [(&mut dry, 0.95), (&mut picard, f64::NAN)] {
        let albedo = &mut spectrum.measured[0];
        albedo.values.push(value);
        albedo.standard_deviations.push(0.05);
    }
    let found = retrieve(&inversion, &[picard.clone(), dry.clone(), picard.clone()]);
    assert!(found.iter().all(|retrieval| retrieval.outcome == Outcome::Converged), "{found:?}");
    assert!(found[0].values == found[2].values && found[0].data == 12 && found[1].data == 13);
    assert!(found[0].fits[0][12].is_nan() && found[1].fits[0][12] > 0.0 && found[0].fits[0][11] > 0.0);
    picard.measured[0].values[12] = 0.95;
    let error = inversion.retrieve(&[dry, picard], &|_| ()).unwrap_err();
    assert!((error.observation, error.wavelength) == (Some(1), Some(12)), "{error}");
}

#[test]
fn wrong_input_is_named_with_its_place() {
    let good = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let spectrum = observation(&deep(20.0, 100.0, beam(30.0)), &[20.0, 100.0], 0.01);
    let told = |inversion: &Inversion, wrong: Observation| {
        let error = inversion.retrieve(&[spectrum.clone(), wrong], &|_| ()).unwrap_err();
        let InversionError { observation, wavelength, .. } = error;
        (observation, wavelength, error.to_string())
    };
    let albedo = |change: &dyn Fn(&mut Measured)| {
        let mut wrong = spectrum.clone();
        change(&mut wrong.measured[0]);
        told(&good, wrong)
    };
    let message = |place: Option<usize>, text: &str| (Some(1), place, text.to_owned());
    assert_eq!(albedo(&|m| m.values[3] = 2.0), message(Some(3), "albedo is 2, but must lie in -0.5–1.5"));
    assert_eq!(albedo(&|m| m.values[0] = f64::INFINITY), message(Some(0), "albedo is inf, but must lie in -0.5–1.5"));
    let zero = "standard deviation of the albedo is 0, but must lie in 1e-6–1000000";
    assert_eq!(albedo(&|m| m.standard_deviations[7] = 0.0), message(Some(7), zero));
    let few = "albedo has 11 numbers, but must be as many as there are wavelengths";
    assert_eq!(albedo(&|m| m.values.truncate(11)), message(None, few));
    assert_eq!(albedo(&|m| m.scale_error = 1e-9), message(None, "scale error must be 0 or at least 1e-6"));
    let text = "scale error is 2, but must lie in 0–1";
    assert_eq!(albedo(&|m| m.scale_error = 2.0), message(None, text));
    let wrong = |change: &dyn Fn(&mut Observation)| {
        let mut wrong = spectrum.clone();
        change(&mut wrong);
        told(&good, wrong)
    };
    let text = "angle is 95°, but must lie in 0–89.99°";
    assert_eq!(wrong(&|s| s.illumination = beam(95.0)), message(None, text));
    let mixed = |fraction: f64| {
        let mut diffuse_fractions = vec![0.2; NM.len()];
        diffuse_fractions[4] = fraction;
        Illumination::Mixed { angle_deg: 10.0, diffuse_fractions }
    };
    let text = "diffuse fraction is 1.2, but must lie in 0–1";
    assert_eq!(wrong(&|s| s.illumination = mixed(1.2)), message(Some(4), text));
    let text = "the prior of ssa_m2_kg: specific surface area is 1000 m²/kg, but must lie in 1.4–300 m²/kg";
    assert_eq!(wrong(&|s| s.prior_medians[0] = 1000.0), message(None, text));
    let text = "transmittance needs a thickness that is finite";
    assert_eq!(wrong(&|s| s.measured[0].quantity = Quantity::Transmittance), message(None, text));
    let text = "density is 1200 kg/m³, but must lie in 10–900 kg/m³";
    assert_eq!(wrong(&|s| s.layers[0].sample_mut().unwrap().density_kg_m3 = 1200.0), message(None, text));

    let changed = |change: &dyn Fn(&mut Inversion)| {
        let mut inversion = good.clone();
        change(&mut inversion);
        told(&inversion, spectrum.clone())
    };
    let whole = |text: &str| (None, None, text.to_owned());
    assert_eq!(
        changed(&|i| i.variables[1] = Variable::Snow(Property::SurfaceArea).into()),
        whole("ssa_m2_kg is to be retrieved twice")
    );
    let text = "covariance of the prior must be symmetric and positive definite";
    assert_eq!(changed(&|i| i.prior_covariance[1] = 0.1), whole(text));
    assert_eq!(changed(&|i| (i.prior_covariance[1], i.prior_covariance[2]) = (9.0, 9.0)), whole(text));
    assert!(
        changed(&|i| i.prior_covariance[0] = -1.0).2.starts_with("the prior of ssa_m2_kg: standard deviation is NaN")
    );
    assert_eq!(changed(&|i| i.variables.clear()), whole("no quantity to retrieve is given"));
    assert!(changed(&|i| i.wavelengths_nm[2] = 2600.0).1 == Some(2));
    let half_space = "thickness cannot be retrieved for a half-space";
    assert_eq!(changed(&|i| i.variables[1] = Variable::Thickness.into()).2, half_space);
}

/// A soft and a hard layer on a dark ground.
fn pack() -> Vec<Layer> {
    let layer =
        |density_kg_m3, thickness_cm| Layer::snow(SnowSample { density_kg_m3, ..SnowSample::default() }, thickness_cm);
    vec![layer(150.0, 3.0), layer(350.0, 20.0)]
}

fn of_layer(variable: Variable, layer: usize) -> LayerVariable {
    LayerVariable { variable, layer: Some(layer) }
}

/// Exact albedo, and fluxes downwards at depths, of two layers of these surface areas with some soot in both.
fn exact_in_layers(areas_m2_kg: [f64; 2], soot_ng_g: f64, depths_cm: &[f64], angle_deg: f64) -> [Vec<f64>; 2] {
    let mut layers = pack();
    for (layer, area_m2_kg) in layers.iter_mut().zip(areas_m2_kg) {
        let sample = layer.sample_mut().unwrap();
        sample.grain_size = GrainSize::from_specific_surface_area(area_m2_kg, -5.0).unwrap();
        sample.impurities = sample.impurities.with(Substance::BLACK_CARBON, soot_ng_g);
    }
    let stack = Stack {
        layers,
        ground_albedo: 0.1.into(),
        depths_cm: depths_cm.to_vec(),
        incidences: vec![Incidence::Beam { angle_deg }],
        wavelengths_nm: NM.to_vec(),
    };
    let solved = solve_stack_without_errors(&stack, &OPTIONS).unwrap();
    let down = |depth: usize| solved.iter().map(move |row| row.profile[depth].down.value);
    [
        solved.iter().map(|row| row.whole.fluxes.reflectance.value).collect(),
        (0..depths_cm.len()).flat_map(down).collect(),
    ]
}

/// An albedo of this error, and fluxes downwards with a relative error over that of a dark signal.
fn profile(values: [Vec<f64>; 2], depths_cm: &[f64], deviation: f64, relative: f64) -> Vec<Measured> {
    let [albedo, down] = values;
    let flux = Measured {
        quantity: Quantity::Down,
        depths_cm: depths_cm.to_vec(),
        standard_deviations: down.iter().map(|value| 1e-6 + relative * value).collect(),
        ..measured(down, 1.0)
    };
    vec![measured(albedo, deviation), flux]
}

fn of_pack(measured: Vec<Measured>, angle_deg: f64, medians: &[f64]) -> Observation {
    Observation {
        layers: pack(),
        ground_albedo: 0.1.into(),
        illumination: beam(angle_deg),
        prior_medians: medians.to_vec(),
        measured,
    }
}

fn inversion_of(variables: Vec<LayerVariable>, deviations: &[f64]) -> Inversion {
    Inversion {
        variables,
        ..inversion(&[Variable::Snow(Property::SurfaceArea), SOOT, DUST][..deviations.len()], deviations)
    }
}

/// As the twins of one layer, with the albedo and the fluxes at two depths of two layers, whose soot is the same: 200
/// draws with probability 0.95 count 179 to 198 times between the 0.05 % and 99.95 % quantiles.
#[test]
fn layers_are_recovered_within_their_posterior() {
    const TWINS: usize = 200;
    let (medians, deviations, depths_cm) = ([40.0, 15.0, 60.0], [0.3, 0.3, 0.5], [2.0, 12.0]);
    let variables = vec![
        of_layer(Variable::Snow(Property::SurfaceArea), 0),
        of_layer(Variable::Snow(Property::SurfaceArea), 1),
        SOOT.into(),
    ];
    let inversion = inversion_of(variables, &deviations);
    let mut stream = Stream::new(12, 0);
    let twin = |number: usize| {
        let truth: [f64; 3] = std::array::from_fn(|i| medians[i] * (deviations[i] * normal(&mut stream)).exp());
        let angle_deg = [20.0, 65.0][number % 2];
        let mut measured =
            profile(exact_in_layers([truth[0], truth[1]], truth[2], &depths_cm, angle_deg), &depths_cm, 0.01, 0.05);
        measured[1].scale_error = if number % 3 == 2 { 0.1 } else { 0.0 };
        for one in &mut measured {
            let factor = (one.scale_error * normal(&mut stream)).exp();
            for (value, deviation) in one.values.iter_mut().zip(&one.standard_deviations) {
                *value = factor * *value + deviation * normal(&mut stream);
            }
        }
        (truth, of_pack(measured, angle_deg, &medians))
    };
    let (truths, twins): (Vec<[f64; 3]>, Vec<Observation>) = (0..TWINS).map(twin).unzip();
    let found = retrieve(&inversion, &twins);
    let (mut in_ellipse, mut in_interval) = (0, [0; 3]);
    for (truth, retrieval) in truths.iter().zip(&found) {
        assert!(retrieval.outcome == Outcome::Converged && retrieval.data == 36, "{truth:?} {retrieval:?}");
        for (i, value) in retrieval.values.iter().enumerate() {
            in_interval[i] += usize::from((value.interval[0]..=value.interval[1]).contains(&truth[i]));
        }
        let off = DVector::from_fn(3, |i, _| (truth[i] / retrieval.values[i].median).ln());
        let precision = DMatrix::from_row_slice(3, 3, &retrieval.covariance).try_inverse().unwrap();
        // The 95 % quantile of χ² with 3 degrees of freedom.
        in_ellipse += usize::from(off.dot(&(precision * &off)) <= 7.814_727_903);
    }
    for count in [in_ellipse, in_interval[0], in_interval[1], in_interval[2]] {
        assert!((179..=198).contains(&count), "{in_ellipse} {in_interval:?}");
    }
}

/// Light at depth says of the lower layer what an albedo does not.
#[test]
fn fluxes_at_depth_determine_what_lies_below() {
    let depths_cm = [2.0, 12.0];
    let variables =
        vec![of_layer(Variable::Snow(Property::SurfaceArea), 0), of_layer(Variable::Snow(Property::SurfaceArea), 1)];
    let inversion = inversion_of(variables, &[0.7, 0.7]);
    let both = profile(exact_in_layers([60.0, 10.0], 0.0, &depths_cm, 50.0), &depths_cm, 0.01, 0.03);
    let albedo = vec![both[0].clone()];
    let [by_albedo, by_both] = [albedo, both].map(|measured| one(&inversion, of_pack(measured, 50.0, &[30.0, 30.0])));
    // Below 3 cm the albedo sees little.
    let deviations = |retrieval: &Retrieval| [0, 3].map(|entry: usize| retrieval.covariance[entry].sqrt());
    let ([upper, lower], [upper_by_both, lower_by_both]) = (deviations(&by_albedo), deviations(&by_both));
    assert!(upper < 0.1 && lower > 0.1 && upper_by_both < upper && lower_by_both < 0.3 * lower, "{by_albedo:?}");
    for (value, truth) in by_both.values.iter().zip([60.0, 10.0]) {
        // Exact data: the prior shifts the state by a small part of its error.
        assert!((value.median - truth).abs() < 0.5 * value.standard_deviation, "{by_both:?}");
    }
    let [_, exact] = exact_in_layers([60.0, 10.0], 0.0, &depths_cm, 50.0);
    assert_eq!(by_both.fits[1].len(), exact.len());
    for (fit, exact) in by_both.fits[1].iter().zip(exact) {
        // Within the stated error.
        assert!((fit - exact).abs() < 1e-6 + 0.03 * exact, "{fit} {exact}");
    }
}

/// Of layers that are alike the common value is that of one layer, to rounding.
#[test]
fn a_common_value_of_equal_layers_is_that_of_one() {
    let truth = deep(25.0, 100.0, beam(45.0));
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea), SOOT], &[1.0, 2.0]);
    let whole = observation(&truth, &[20.0, 30.0], 0.01);
    let mut cut = whole.clone();
    cut.layers.insert(0, Layer { thickness_cm: 2.0, ..whole.layers[0] });
    let found = retrieve(&inversion, &[whole, cut]);
    for (whole, cut) in found[0].values.iter().zip(&found[1].values) {
        assert!((whole.median / cut.median - 1.0).abs() < 1e-8, "{found:?}");
        assert!((whole.standard_deviation / cut.standard_deviation - 1.0).abs() < 1e-6, "{found:?}");
    }
    let observation = observation(&truth, &[20.0, 30.0], 0.01);
    assert!((observation.known(Variable::Snow(Property::Density).into()) - 300.0).abs() < 1e-12);
    let layered = of_pack(vec![], 45.0, &[]);
    assert!(layered.known(Variable::Snow(Property::Density).into()).is_nan());
    assert!((layered.known(of_layer(Variable::Snow(Property::Density), 1)) - 350.0).abs() < 1e-12);
}

/// A glaze of ice, whose infrared absorption tells its thickness, on snow, whose surface area is retrieved with it.
#[test]
fn the_thickness_of_ice_is_retrieved() {
    let glazed = |thickness_cm: f64, area_m2_kg: f64| {
        let grain_size = GrainSize::from_specific_surface_area(area_m2_kg, -5.0).unwrap();
        let snow = SnowSample { grain_size, ..SnowSample::default() };
        vec![Layer::ice(IceTable::default(), thickness_cm), Layer::snow(snow, f64::INFINITY)]
    };
    let stack = Stack {
        layers: glazed(0.4, 12.0),
        ground_albedo: 0.0.into(),
        depths_cm: vec![],
        incidences: vec![Incidence::Beam { angle_deg: 50.0 }],
        wavelengths_nm: NM.to_vec(),
    };
    let solved = solve_stack_without_errors(&stack, &OPTIONS).unwrap();
    let albedo = solved.iter().map(|row| row.whole.fluxes.reflectance.value).collect();
    let observation = Observation {
        layers: glazed(1.0, 30.0),
        ground_albedo: 0.0.into(),
        illumination: beam(50.0),
        prior_medians: vec![1.0, 20.0],
        measured: vec![measured(albedo, 1e-4)],
    };
    // The common surface area of all layers is that of the snow.
    let variables = vec![of_layer(Variable::Thickness, 0), Variable::Snow(Property::SurfaceArea).into()];
    let found = one(&inversion_of(variables, &[1.0, 1.0]), observation.clone());
    assert_eq!(found.outcome, Outcome::Converged);
    for (value, truth) in found.values.iter().zip([0.4, 12.0]) {
        // Exact data: the prior shifts the state by a small part of its error.
        assert!((value.median - truth).abs() < 0.1 * value.standard_deviation, "{found:?}");
        assert!(value.standard_deviation < 0.05 * truth, "{found:?}");
    }
    let told = |by: LayerVariable, median: f64| {
        let wrong = Observation { prior_medians: vec![median], ..observation.clone() };
        inversion_of(vec![by], &[1.0]).retrieve(&[wrong], &|_| ()).unwrap_err().to_string()
    };
    assert_eq!(
        told(of_layer(Variable::Snow(Property::SurfaceArea), 0), 20.0),
        "ssa_m2_kg cannot be retrieved from clear ice"
    );
    let thin = "the prior of thickness_cm of layer 0: thickness is 0.001 cm, but must lie in 0.01–100000 cm";
    assert_eq!(told(of_layer(Variable::Thickness, 0), 0.001), thin);
}

#[test]
fn wrong_packs_are_named() {
    let depths_cm = [2.0, 12.0];
    let data = profile(exact_in_layers([40.0, 20.0], 0.0, &depths_cm, 30.0), &depths_cm, 0.01, 0.05);
    let told = |variables: Vec<LayerVariable>, change: &dyn Fn(&mut Observation)| {
        let medians = vec![20.0; variables.len()];
        let mut wrong = of_pack(data.clone(), 30.0, &medians);
        change(&mut wrong);
        let inversion = inversion_of(variables, &vec![1.0; medians.len()]);
        inversion.retrieve(&[wrong], &|_| ()).map(|_| ()).unwrap_err()
    };
    let area = |layer: usize| vec![of_layer(Variable::Snow(Property::SurfaceArea), layer)];
    let thickness = |layer: usize| vec![of_layer(Variable::Thickness, layer)];
    assert_eq!(told(area(2), &|_| ()).to_string(), "number of the layer is 2, but must lie in 0–1");
    let twice = vec![of_layer(Variable::Snow(Property::SurfaceArea), 0), Variable::Snow(Property::SurfaceArea).into()];
    assert_eq!(told(twice, &|_| ()).to_string(), "ssa_m2_kg is to be retrieved twice");
    let deep = told(area(0), &|wrong| wrong.measured[1].depths_cm[1] = 30.0);
    assert_eq!(deep.to_string(), "depth is 30 cm, but must lie in 0–23 cm");
    let value = told(area(0), &|wrong| wrong.measured[1].values[15] = 80.0);
    assert_eq!(value.to_string(), "down is 80, but must lie in -0.5–3, at a depth of 12 cm");
    assert_eq!((value.wavelength, value.depth_cm), (Some(3), Some(12.0)));
    let bare = told(area(0), &|wrong| wrong.measured[1].depths_cm.clear());
    assert_eq!(bare.to_string(), "down needs depths");
    let known = told(thickness(1), &|wrong| (wrong.layers[1].thickness_cm, wrong.prior_medians[0]) = (2.0, 8.0));
    assert!(known.to_string().ends_with("thickness is 8 cm, but must lie in 9–100000 cm"), "{known}");
    let deep = told(area(0), &|wrong| wrong.measured[0].depths_cm.push(1.0));
    assert_eq!(deep.to_string(), "albedo has no depths");
    let missing = told(area(0), &|wrong| wrong.layers.clear());
    assert_eq!(missing.to_string(), "no layer is given");

    // The ground stays below the deepest flux.
    let shallow = told(thickness(1), &|wrong| wrong.prior_medians[0] = 8.0);
    assert_eq!(
        shallow.to_string(),
        "the prior of thickness_cm of layer 1: thickness is 8 cm, but must lie in 9–100000 cm"
    );
    let both = told([thickness(0), thickness(1)].concat(), &|_| ());
    let text = "thickness of several layers cannot be retrieved from fluxes at depth, which the ground must not reach";
    assert_eq!(both.to_string(), text);
    // A common thickness of both layers is at least half of the depth.
    let common = told(vec![Variable::Thickness.into()], &|wrong| wrong.prior_medians[0] = 5.0);
    assert_eq!(common.to_string(), "the prior of thickness_cm: thickness is 5 cm, but must lie in 6–100000 cm");
    let half_space = told(thickness(1), &|wrong| wrong.layers[1].thickness_cm = f64::INFINITY);
    assert_eq!(half_space.to_string(), "thickness cannot be retrieved for a half-space");
}

/// A spectrum as ground is known like a grey one; a ground that is retrieved is grey.
#[test]
fn snow_on_a_ground_with_a_spectrum_is_found() {
    let soil = GroundAlbedo::spectrum(vec![300.0, 2500.0], vec![0.05, 0.6]).unwrap();
    let truth =
        SnowSample { grain_size: GrainSize::from_specific_surface_area(18.0, -5.0).unwrap(), ..SnowSample::default() };
    let stack = Stack {
        layers: vec![Layer::snow(truth, 1.0)],
        ground_albedo: soil.clone(),
        depths_cm: vec![],
        incidences: vec![Incidence::Diffuse],
        wavelengths_nm: NM.to_vec(),
    };
    let solved = solve_stack_without_errors(&stack, &OPTIONS).unwrap();
    let albedo = solved.iter().map(|row| row.whole.fluxes.reflectance.value).collect();
    let inversion = inversion(&[Variable::Snow(Property::SurfaceArea)], &[1.0]);
    let observation = Observation {
        layers: vec![Layer::snow(SnowSample::default(), 1.0)],
        ground_albedo: soil,
        illumination: Illumination::Single(Incidence::Diffuse),
        prior_medians: vec![10.0],
        measured: vec![measured(albedo, 1e-4)],
    };
    let on_grey = Observation { ground_albedo: 0.05.into(), ..observation.clone() };
    let [found, wrong] = [observation.clone(), on_grey].map(|one_of| one(&inversion, one_of).values[0]);
    assert!((found.median / 18.0 - 1.0).abs() < 1e-6, "{found:?}");
    assert!((wrong.median - 18.0).abs() > 10.0 * wrong.standard_deviation, "{wrong:?}");
    let short = GroundAlbedo::spectrum(vec![300.0, 500.0], vec![0.1, 0.1]).unwrap();
    let short = Observation { ground_albedo: short, ..observation };
    assert!(short.known(Variable::GroundAlbedo.into()).is_nan());
    let message = inversion.retrieve(&[short], &|_| ()).unwrap_err().to_string();
    assert!(message.contains("wavelength above the ground"), "{message}");
}
