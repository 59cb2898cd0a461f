//! Derivatives of the fluxes of layers, and at depths, against differences, Taylor's theorem, and those of slabs.

use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::illumination::{Illumination, LightInLayers, differentiate_light_in_layers, light_in_layers};
use snowblue_transport::ordinates::{
    DifferentiatedStack, OrdinatesOptions, Streams, differentiate_batch, differentiate_stack, solve_stack,
    solve_stack_without_errors,
};
use snowblue_transport::stack::ICE_THICKNESS_RANGE;
use snowblue_transport::stack::{DepthFluxes, StackDerivatives, StackRadiometry};
use snowblue_transport::sunlight::Band;
use snowblue_transport::{
    GrainSize, IceTable, Impurities, Incidence, Layer, LayerVariable, Property, SnowSample, Stack, Substance,
    TruncatedNormal, Variable,
};

use crate::variables::variables;

const OPTIONS: OrdinatesOptions = OrdinatesOptions { tally_rays: 1 << 10, streams: Streams::Auto, seed: 1 };
const NM: [f64; 4] = [400.0, 550.0, 900.0, 1350.0];

fn snow(area_m2_kg: f64, density_kg_m3: f64) -> SnowSample {
    SnowSample {
        grain_size: GrainSize::from_specific_surface_area(area_m2_kg, -5.0).unwrap(),
        density_kg_m3,
        ..SnowSample::default()
    }
}

fn dirty(sample: SnowSample) -> SnowSample {
    let impurities = Impurities::none().with(Substance::BLACK_CARBON, 50.0).with(Substance::SAHARAN_DUST, 2e4);
    SnowSample { impurities, ..sample }
}

fn stack(layers: &[(SnowSample, f64)], angle_deg: f64, ground_albedo: f64, depths_cm: &[f64]) -> Stack {
    let incidence = if angle_deg < 0.0 { Incidence::Diffuse } else { Incidence::Beam { angle_deg } };
    let layer = |(sample, thickness_cm): &(SnowSample, f64)| Layer::snow(*sample, *thickness_cm);
    Stack {
        layers: layers.iter().map(layer).collect(),
        ground_albedo: f64::into(ground_albedo),
        depths_cm: depths_cm.to_vec(),
        incidences: vec![incidence],
        wavelengths_nm: NM.to_vec(),
    }
}

/// The stack with layers of ice of a thickness in cm, each as the layer of a number.
fn iced(mut stack: Stack, ice: &[(usize, f64)]) -> Stack {
    for (layer, thickness_cm) in ice {
        stack.layers.insert(*layer, Layer::ice(IceTable::default(), *thickness_cm));
    }
    stack
}

/// Ice on top, within, on the ground, alone, and in several places with neighbouring ice, with depths within it.
fn iced_stacks() -> Vec<(&'static str, Stack)> {
    let snows = [(snow(45.0, 120.0), 2.0), (dirty(snow(9.0, 400.0)), 5.0)];
    let stack = |angle_deg, depths_cm: &[f64]| stack(&snows, angle_deg, 0.3, depths_cm);
    let alone = Stack { layers: vec![], ..stack(40.0, &[1.0]) };
    vec![
        ("ice on top", iced(stack(50.0, &[0.2, 1.0, 4.0]), &[(0, 0.5)])),
        ("ice within", iced(stack(65.0, &[1.0, 2.4, 5.0]), &[(1, 1.0)])),
        ("ice on the ground", iced(stack(-1.0, &[1.0, 8.1]), &[(2, 2.0)])),
        ("ice alone", iced(alone, &[(0, 3.0)])),
        ("several", iced(stack(75.0, &[0.1, 1.0, 2.5, 2.9, 9.0]), &[(0, 0.3), (2, 0.4), (3, 0.6), (5, 3.0)])),
    ]
}

/// Thin, thick and endless layers, under high and low sun and a white sky, clean, dirty and wet, on black and bright
/// ground. Depths are those of no face.
fn stacks() -> Vec<(&'static str, Stack)> {
    let (fresh, old) = (snow(45.0, 120.0), snow(9.0, 400.0));
    let wet = SnowSample { water_saturation: 0.15, ..snow(15.0, 350.0) };
    let algae = SnowSample { impurities: Impurities::none().with(Substance::SNOW_ALGAE, 1e5), ..fresh };
    let smooth = SnowSample { facetness: TruncatedNormal::exactly(0.0), ..old };
    let endless = f64::INFINITY;
    let usual = [(fresh, 3.0), (dirty(snow(20.0, 250.0)), 10.0), (old, 12.0)];
    vec![
        ("usual", stack(&usual, 30.0, 0.2, &[0.0, 0.1, 1.5, 5.0, 13.5, 20.0])),
        ("white sky", stack(&usual, -1.0, 0.6, &[0.0, 2.0, 7.0, 14.0])),
        ("one", stack(&[(fresh, 4.0)], 50.0, 0.0, &[0.0, 2.0])),
        ("thick", stack(&[(fresh, 30.0), (dirty(old), 100.0)], 65.0, 0.3, &[1.0, 60.0])),
        ("endless", stack(&[(fresh, 1.0), (dirty(old), endless)], 40.0, 0.0, &[0.5, 3.0])),
        ("film", stack(&[(fresh, 1e-4), (old, 5.0)], 20.0, 0.0, &[5e-5, 1.0])),
        ("low sun", stack(&[(fresh, 2.0), (old, endless)], 86.0, 0.0, &[0.1, 5.0])),
        ("wet", stack(&[(fresh, 1.0), (wet, 4.0)], 35.0, 0.3, &[0.5, 3.0])),
        ("algae", stack(&[(algae, 1.0), (smooth, 4.0), (algae, 2.0)], -1.0, 0.9, &[0.5, 3.0])),
    ]
    .into_iter()
    .chain(iced_stacks())
    .collect()
}

const QUANTITIES: [&str; 6] = ["down", "up", "net", "fluence", "absorbed_per_m", "e_folding_depth_cm"];

/// R, T and A, then the quantities of each depth, of each wavelength.
fn values(stack: &Stack, options: &OrdinatesOptions) -> Vec<Vec<f64>> {
    let solved = solve_stack_without_errors(stack, options).unwrap();
    let row = |row: &StackRadiometry| {
        let whole = row.whole.fluxes.to_array();
        whole.into_iter().chain(row.profile.iter().flat_map(of_depth)).map(|one| one.value).collect()
    };
    solved.iter().map(row).collect()
}

/// The quantities of a depth.
fn of_depth<T: Copy>(at: &DepthFluxes<T>) -> [T; 6] {
    let DepthFluxes { down, up, net, fluence, absorbed_per_m, e_folding_depth_cm } = *at;
    [down, up, net, fluence, absorbed_per_m, e_folding_depth_cm]
}

/// The derivatives of the quantities, of each wavelength and each variable of each layer.
fn derivatives(solved: &DifferentiatedStack) -> Vec<Vec<f64>> {
    let row = |row: &StackDerivatives| {
        row.whole.to_array().into_iter().chain(row.profile.iter().flat_map(of_depth)).collect()
    };
    solved.derivatives.iter().map(row).collect()
}

fn differentiate(stack: &Stack, variables: &[Variable], options: &OrdinatesOptions) -> Vec<Vec<f64>> {
    derivatives(&differentiate_stack(stack, variables, options, false).unwrap())
}

/// The value of a variable, if the stack has one.
fn value(stack: &Stack, by: &LayerVariable) -> Option<f64> {
    let layer = by.layer.map(|layer| stack.layers[layer]);
    let sample = layer.as_ref().and_then(Layer::sample);
    Some(match by.variable {
        Variable::CosIncidence => match stack.incidences[0] {
            Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
            Incidence::Diffuse => return None,
        },
        Variable::GroundAlbedo => stack.ground_albedo.at(550.0),
        Variable::Snow(Property::SurfaceArea) => 4.0 * sample?.extinction_per_m() / sample?.density_kg_m3,
        Variable::Snow(Property::Density) => sample?.density_kg_m3,
        Variable::Thickness => layer.map(|layer| layer.thickness_cm).filter(|thickness| thickness.is_finite())?,
        Variable::Snow(Property::WaterSaturation) => sample?.water_saturation,
        Variable::Snow(Property::Impurity(substance)) => sample?.impurities.ng_g(substance),
        Variable::Snow(_) => unreachable!("{} has no derivatives", by.variable),
    })
}

/// The stack with another value of a variable.
fn with(stack: &Stack, by: &LayerVariable, value_then: f64) -> Stack {
    let mut changed = stack.clone();
    let ratio = value(stack, by).unwrap() / value_then;
    match (by.variable, by.layer) {
        (Variable::CosIncidence, _) => {
            changed.incidences[0] = Incidence::Beam { angle_deg: value_then.acos().to_degrees() };
        }
        (Variable::GroundAlbedo, _) => changed.ground_albedo = value_then.into(),
        (variable, layer) => {
            let layer = &mut changed.layers[layer.unwrap()];
            let Some(sample) = layer.sample_mut().filter(|_| variable != Variable::Thickness) else {
                layer.thickness_cm = value_then;
                return changed;
            };
            match variable {
                Variable::Snow(Property::SurfaceArea) => {
                    sample.grain_size.min_um *= ratio;
                    sample.grain_size.max_um *= ratio;
                }
                Variable::Snow(Property::Density) => sample.density_kg_m3 = value_then,
                Variable::Snow(Property::WaterSaturation) => sample.water_saturation = value_then,
                Variable::Snow(Property::Impurity(substance)) => {
                    sample.impurities = sample.impurities.with(substance, value_then);
                }
                _ => unreachable!("{variable} is no property of snow with derivatives"),
            }
        }
    }
    changed
}

fn describe(place: usize) -> String {
    match place {
        0..3 => ["R", "T", "A"][place].to_owned(),
        _ => format!("{} of depth {}", QUANTITIES[(place - 3) % 6], (place - 3) / 6),
    }
}

/// The flux to whose rounding a quantity is precise: absorptance and net flux are differences of fluxes at the top.
fn scale(place: usize, values: &[f64]) -> f64 {
    match place {
        2 => 1.0,
        3.. if (place - 3) % 6 == 2 => values[place - 2],
        _ => values[place].abs(),
    }
}

/// Compares the derivatives by all variables that have a value with differences: the sum of `weight` (f(p + `steps` h)
/// − f(p))/h over the terms. Returns how many were compared.
fn compare(
    name: &str,
    stack: &Stack,
    keep: impl Fn(&LayerVariable, f64) -> Option<f64>,
    terms: &[(f64, f64)],
) -> usize {
    let options = OPTIONS;
    let found = differentiate(stack, &variables(), &options);
    let here = values(stack, &options);
    let of_layers = LayerVariable::of_layers(&variables(), stack.layers.len());
    let mut compared = 0;
    for (number, by) in of_layers.iter().enumerate() {
        let Some(at) = value(stack, by) else {
            let rows = found.iter().skip(number).step_by(of_layers.len());
            assert!(rows.flatten().all(|derivative| derivative.abs() <= 0.0), "{name}, {by}");
            continue;
        };
        let Some(step) = keep(by, at) else { continue };
        let there: Vec<Vec<Vec<f64>>> =
            terms.iter().map(|(steps, _)| values(&with(stack, by, at + steps * step), &options)).collect();
        for (wavelength, here) in here.iter().enumerate() {
            for (place, value) in here.iter().enumerate() {
                let derivative = found[wavelength * of_layers.len() + number][place];
                let differences = terms.iter().zip(&there).map(|((_, weight), there)| {
                    let there = there[wavelength][place];
                    // Of the logarithm, so that no exponential decay is truncated.
                    let is_flux = !matches!(describe(place).as_str(), "A") && *value > 0.0 && there > 0.0;
                    weight * if is_flux { value * (there / value).ln() } else { there - value }
                });
                let expected = differences.sum::<f64>() / step;
                let rounding = 2e-13 * terms.iter().map(|(_, weight)| weight.abs()).sum::<f64>() / step.abs();
                let tolerance = 1e-5 * expected.abs() + rounding * scale(place, here);
                assert!(
                    (derivative - expected).abs() <= tolerance,
                    "{name}, {by}, {} nm, {}: {derivative:e}, but by differences {expected:e} ± {tolerance:e}",
                    NM[wavelength],
                    describe(place)
                );
            }
        }
        compared += 1;
    }
    compared
}

/// Central differences over h and 2h, extrapolated: their error is of the order h⁴.
#[test]
fn derivatives_agree_with_central_differences() {
    let central = [(2.0, -1.0), (1.0, 8.0), (-1.0, -8.0), (-2.0, 1.0)].map(|(steps, weight)| (steps, weight / 12.0));
    let mut compared = 0;
    for (name, stack) in stacks() {
        let step = |_: &LayerVariable, at: f64| {
            let room = if at < 1.0 { at.min(1.0 - at) } else { at };
            (room > 0.0).then_some(1e-3 * room)
        };
        compared += compare(name, &stack, step, &central);
    }
    // Area and density of 20 layers, thickness of all but 2, cosines, grounds, and water and dirt where there is some.
    let of_snow = 20 + 20 + 18 + 7 + 5 + 1 + 2 * 4 + 2;
    // Area, density and dirt of 8 layers of snow, thickness of 8 and of 8 of ice, 4 cosines and 5 grounds.
    assert_eq!(compared, of_snow + 8 + 8 + 4 * 2 + 16 + 4 + 5);
}

/// Dirt, water and light from below where there is none; layers of no thickness; and depths at faces, where the
/// thickness above can only be less and at the ground only more.
#[test]
fn derivatives_at_ends_agree_with_differences_to_one_side() {
    let one_sided = [(1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)];
    let (fresh, old) = (snow(45.0, 120.0), snow(9.0, 400.0));
    let mut compared = 0;
    for (name, stack) in [
        ("clean", stack(&[(fresh, 2.0), (old, 5.0)], 30.0, 0.0, &[1.0, 4.0])),
        ("nothing", stack(&[(fresh, 2.0), (old, 0.0), (fresh, 3.0)], 30.0, 0.3, &[0.5, 4.0])),
        ("nothing on top", stack(&[(old, 0.0), (fresh, 3.0)], -1.0, 0.3, &[1.0])),
    ] {
        let step = |by: &LayerVariable, at: f64| match by.variable {
            Variable::Snow(Property::Impurity(Substance::SNOW_ALGAE) | Property::WaterSaturation) => None,
            Variable::Snow(Property::Impurity(Substance::BLACK_CARBON | Substance::BROWN_CARBON)) if at <= 0.0 => {
                Some(1e-3)
            }
            Variable::Snow(Property::Impurity(_)) if at <= 0.0 => Some(0.1),
            Variable::Thickness if at <= 0.0 => Some(1e-6),
            Variable::GroundAlbedo if at <= 0.0 => Some(1e-4),
            _ => None,
        };
        compared += compare(name, &stack, step, &one_sided);
    }
    let layers = [(fresh, 2.0), (old, 5.0)];
    let at_face = stack(&layers, 30.0, 0.2, &[2.0]);
    let thinner = |by: &LayerVariable, _: f64| (by.variable == Variable::Thickness).then_some(-1e-4);
    compared += compare("face", &at_face, thinner, &one_sided);
    let at_ground = Stack { depths_cm: vec![7.0], ..at_face };
    let thicker = |by: &LayerVariable, _: f64| (by.variable == Variable::Thickness).then_some(1e-4);
    compared += compare("ground", &at_ground, thicker, &one_sided);
    assert_eq!(compared, (4 * 2 + 1) + (4 * 3 + 1) + (4 * 2 + 1) + 2 + 2);
}

/// f(p + h) − f(p) − f' h is f'' h²/2 to leading order: half the step leaves a quarter of it.
#[test]
fn the_remainder_of_taylor_is_of_second_order() {
    let mut tested = 0;
    for (name, stack) in stacks() {
        let (found, here) = (differentiate(&stack, &variables(), &OPTIONS), values(&stack, &OPTIONS));
        let of_layers = LayerVariable::of_layers(&variables(), stack.layers.len());
        for (number, by) in of_layers.iter().enumerate() {
            let Some(at) = value(&stack, by).filter(|at| *at > 0.0) else { continue };
            let step = 4e-3 * if at < 1.0 { at.min(1.0 - at) } else { at };
            let there = [1.0, 0.5].map(|part| values(&with(&stack, by, at + part * step), &OPTIONS));
            for (wavelength, here) in here.iter().enumerate() {
                for (place, value) in here.iter().enumerate() {
                    let derivative = found[wavelength * of_layers.len() + number][place];
                    let [whole, half] = [1.0, 0.5].map(|part| {
                        let there = &there[usize::from(part < 1.0)];
                        there[wavelength][place] - value - derivative * part * step
                    });
                    // The next term is some h/p times the number of e-foldings, and where the curvature changes its
                    // sign it is not small. An error of first order leaves a ratio of 2.
                    let folds = 1.0 + value.abs().ln().abs();
                    let next = 0.05 * folds * (1.0 + 1e-5 * scale(place, here) / half.abs());
                    if next < 1.0 {
                        let ratio = whole / half;
                        assert!(
                            (ratio - 4.0).abs() < next,
                            "{name}, {by}, {} nm, {}: {ratio}",
                            NM[wavelength],
                            describe(place)
                        );
                        tested += 1;
                    }
                }
            }
        }
    }
    assert!(tested > 500, "{tested}");
}

/// One layer has the derivatives of the slab, which is solved by another method.
#[test]
fn one_layer_has_the_derivatives_of_the_slab() {
    let sample = dirty(SnowSample { water_saturation: 0.1, ..snow(20.0, 250.0) });
    for (thickness_cm, angle_deg, ground_albedo) in
        [(0.1, 40.0, 0.0), (4.0, 20.0, 0.5), (40.0, -1.0, 0.3), (f64::INFINITY, 60.0, 0.0), (2.0, 85.0, 0.2)]
    {
        let stack = stack(&[(sample, thickness_cm)], angle_deg, ground_albedo, &[]);
        let layered = differentiate(&stack, &variables(), &OPTIONS);
        let case = SlabCase {
            sample: 0,
            thickness_cm,
            incidence: stack.incidences[0],
            ground_albedo: f64::into(ground_albedo),
        };
        let batch = Batch { samples: vec![sample], cases: vec![case], wavelengths_nm: NM.to_vec() };
        let slab = differentiate_batch(&batch, &variables(), &OPTIONS, false, &|_| ()).unwrap();
        assert_eq!(layered.len(), slab.derivatives.len());
        for (number, (layered, slab)) in layered.iter().zip(&slab.derivatives).enumerate() {
            let variable = variables()[number % variables().len()];
            let values = &slab.to_array();
            for (place, expected) in values.iter().enumerate() {
                // And the rounding of a flux near 1.
                let tolerance = 1e-9 * expected.abs() + 1e-15;
                assert!(
                    (layered[place] - expected).abs() <= tolerance,
                    "{thickness_cm} cm, {variable}, {}: {:e} {expected:e}",
                    describe(place),
                    layered[place]
                );
            }
        }
    }
}

/// Slices of one snow have derivatives that sum up to those of the whole, as all of them change together.
#[test]
fn derivatives_of_slices_sum_up_to_those_of_the_layer() {
    let sample = dirty(snow(20.0, 250.0));
    let depths = [0.0, 1.0, 4.0, 9.0];
    let whole = stack(&[(sample, 12.0)], 50.0, 0.4, &depths);
    let sliced = stack(&[(sample, 2.0), (sample, 3.0), (sample, 7.0)], 50.0, 0.4, &depths);
    let soot = Variable::impurity(Substance::BLACK_CARBON);
    let variables = [
        Variable::Snow(Property::SurfaceArea),
        Variable::Snow(Property::Density),
        soot,
        Variable::GroundAlbedo,
        Variable::CosIncidence,
    ];
    let (of_whole, of_slices) =
        (differentiate(&whole, &variables, &OPTIONS), differentiate(&sliced, &variables, &OPTIONS));
    for wavelength in 0..NM.len() {
        let (whole, slices) = (&of_whole[5 * wavelength..][..5], &of_slices[11 * wavelength..][..11]);
        for place in 0..whole[0].len() {
            // A property of the snow at a depth belongs to the slice there.
            for variable in 0..5 {
                let sum = match variable {
                    0..3 => slices[3 * variable..][..3].iter().map(|slice| slice[place]).sum(),
                    _ => slices[6 + variable][place],
                };
                let expected: f64 = whole[variable][place];
                // And the rounding of a flux near 1.
                let tolerance = 1e-10 * expected.abs() + 1e-15;
                assert!((sum - expected).abs() <= tolerance, "{variable}, {}: {sum} {expected}", describe(place));
            }
        }
    }
}

/// Values are those without derivatives, and neither standard errors nor other lights change a bit of a derivative.
#[test]
fn values_and_derivatives_do_not_depend_on_each_other() {
    let (_, one) = stacks().remove(0);
    let mut lights = one.incidences.clone();
    lights.extend([Incidence::Diffuse, Incidence::Beam { angle_deg: 87.0 }]);
    let all = Stack { incidences: lights, ..one.clone() };
    let solved = differentiate_stack(&all, &variables(), &OPTIONS, true).unwrap();
    let bits = |rows: &[Vec<f64>]| rows.iter().flatten().map(|value| value.to_bits()).collect::<Vec<u64>>();
    let alone = bits(&differentiate(&one, &variables(), &OPTIONS));
    assert_eq!(bits(&derivatives(&solved)[..alone.len() / derivatives(&solved)[0].len()]), alone);
    let plain = solve_stack(&all, &OPTIONS).unwrap();
    for (with, without) in solved.fluxes.iter().zip(&plain) {
        assert_eq!(with, without);
    }
}

/// Light under a sun and a sky, in bands and layers, against central differences: the second derivative over a step of
/// 10⁻⁴ leaves 10⁻⁸, and rounding 10⁻¹² over the step.
#[test]
fn derivatives_of_light_in_layers_agree_with_differences() {
    let (fresh, old) = (snow(45.0, 120.0), dirty(snow(9.0, 400.0)));
    let wavelengths_nm: Vec<f64> = (40..=100).map(|tens| 10.0 * f64::from(tens)).collect();
    let snow = stack(&[(fresh, 3.0), (old, 6.0), (fresh, 2.0)], 60.0, 0.3, &[0.0, 1.0, 5.0]);
    let ice = iced(stack(&[(fresh, 3.0), (old, 6.0)], 60.0, 0.3, &[0.0, 1.0, 3.6]), &[(0, 0.4), (2, 0.5), (4, 1.0)]);
    let packs = [snow, ice].map(|pack| Stack { wavelengths_nm: wavelengths_nm.clone(), ..pack });
    let light = |elevation_deg| {
        let count = wavelengths_nm.len();
        Illumination::under_sun(elevation_deg, vec![1.0; count], vec![0.4; count])
    };
    let lights = [light(30.0), light(-3.0)];
    let soot = Variable::impurity(Substance::BLACK_CARBON);
    let variables = [
        Variable::Snow(Property::SurfaceArea),
        Variable::Snow(Property::Density),
        Variable::Thickness,
        soot,
        Variable::GroundAlbedo,
    ];
    let numbers = |light: &LightInLayers, band: Band| -> Vec<f64> {
        let light = light.band(band, &wavelengths_nm).unwrap();
        light.levels.iter().flat_map(|level| level.values()).chain(light.absorbed).collect()
    };
    for pack in &packs {
        let solved = differentiate_light_in_layers(pack, &lights, &variables, &OPTIONS).unwrap();
        let plain = light_in_layers(pack, &lights, &OPTIONS).unwrap();
        let of_layers = LayerVariable::of_layers(&variables, pack.layers.len());
        for (solved, plain) in solved.iter().zip(&plain) {
            assert_eq!(solved.light, *plain);
            assert_eq!(solved.derivatives.len(), of_layers.len());
        }
        for (number, by) in of_layers.iter().enumerate() {
            let Some(at) = value(pack, by).filter(|at| *at > 0.0) else { continue };
            let step = 1e-4 * at;
            let [more, less] =
                [1.0, -1.0].map(|sign| light_in_layers(&with(pack, by, at + sign * step), &lights, &OPTIONS).unwrap());
            for (place, solved) in solved.iter().enumerate() {
                for band in [Band::Par, Band::Visible] {
                    let [more, less] = [&more, &less].map(|all| numbers(&all[place], band));
                    let found = numbers(&solved.derivatives[number], band);
                    let sizes = numbers(&solved.light, band);
                    for (i, found) in found.iter().enumerate() {
                        let difference = (more[i] - less[i]) / (2.0 * step);
                        let tolerance = 1e-6 * difference.abs() + 1e-12 * sizes[i].abs().max(sizes[0]) / step;
                        assert!((found - difference).abs() < tolerance, "{by}, {i}: {found:e} {difference:e}");
                    }
                }
            }
        }
    }
}

/// From the finest and densest snow to the coarsest and loosest, black and white, in films and kilometres, under the
/// lowest sun.
#[test]
fn derivatives_of_extreme_layers_are_numbers() {
    let (finest, coarsest) = (snow(300.0, 900.0), snow(1.5, 10.0));
    let full = SnowSample { water_saturation: 1.0, ..dirty(finest) };
    let mut checked = 0;
    for layers in [
        vec![(finest, 1e5), (coarsest, 1e5)],
        vec![(coarsest, 1e-9), (finest, 1e5), (coarsest, f64::INFINITY)],
        vec![(full, 1e5), (finest, 0.0), (full, 1e-12)],
        vec![(finest, 0.0)],
    ] {
        let is_wet = layers.iter().any(|(sample, _)| sample.water_saturation > 0.0);
        let wavelengths_nm = if is_wet { vec![310.0, 460.0, 1395.0] } else { vec![310.0, 460.0, 1490.0] };
        let depths: &[f64] = if layers.len() > 1 { &[0.0, 1e-9, 1.0, 1e5] } else { &[0.0] };
        for (angle_deg, ground_albedo) in [(0.0, 0.0), (89.99, 1.0), (-1.0, 1.0)] {
            let wavelengths_nm = wavelengths_nm.clone();
            let stack = Stack { wavelengths_nm, ..stack(&layers, angle_deg, ground_albedo, depths) };
            // The table of water ends before 1490 nm.
            let has_table = |variable: &Variable| is_wet || *variable != Variable::Snow(Property::WaterSaturation);
            let variables: Vec<Variable> = variables().into_iter().filter(has_table).collect();
            // And with the thinnest ice on top, and the thickest below the first layer.
            let ice = [(0, ICE_THICKNESS_RANGE.least), (2, ICE_THICKNESS_RANGE.greatest)];
            let with_ice = iced(stack.clone(), if layers.len() > 1 { &ice } else { &ice[..1] });
            for stack in [stack, with_ice] {
                let solved = values(&stack, &OPTIONS);
                assert!(solved.iter().flatten().all(|value| *value > -1e-12), "{stack:?} {solved:?}");
                for row in differentiate(&stack, &variables, &OPTIONS) {
                    assert!(row.iter().all(|derivative| derivative.is_finite()), "{stack:?} {row:?}");
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 500, "{checked}");
}

/// Ice has no variable but its thickness.
#[test]
fn ice_has_no_property_of_snow() {
    for (name, stack) in iced_stacks() {
        let of_layers = LayerVariable::of_layers(&variables(), stack.layers.len());
        let rows = differentiate(&stack, &variables(), &OPTIONS);
        for (row, by) in rows.iter().zip(of_layers.iter().cycle()) {
            let is_none =
                by.variable != Variable::Thickness && by.layer.is_some_and(|layer| stack.layers[layer].is_ice());
            let is_zero = row.iter().all(|derivative| derivative.abs() <= 0.0);
            assert!(!is_none || is_zero, "{name}, {by}: {row:?}");
        }
    }
}
