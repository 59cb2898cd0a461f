//! Every integrator renders every snow: of any grain size, wet and dirty, and between two kinds by a mask.

use glam::Vec3A;
use snowblue_render::scene::spectrum::Spectrum;
use snowblue_render::{Integrator, Preparation};

use crate::snow::{
    self, Estimate, analytic_table, block_of_ages, estimate, integrator, pcasnow, prepared, radiance,
    scene_of_few_grains,
};

/// Indices of 400, 550 and 700 nm.
const BANDS: [usize; 3] = [0, 15, 30];

/// A material of some keys.
fn material(name: &str, keys: &str) -> String {
    format!("[material.{name}]\ntype = \"snow\"\n{keys}\n")
}

/// A slab of 5 cm, lit from behind at 45° and from the front, for PCASnow.
fn backlit(name: &str, x_m: f64) -> String {
    format!("[[object]]\nshape = \"box\"\nsize = [1, 0.05, 1]\nposition = [{x_m}, 0, 0]\nmaterial = \"{name}\"\n")
}

const LAMPS: &str = "[[light]]\ntype = \"directional\"\ndirection = [1, -1, 0]\nirradiance_w_m2 = 10\n\
    illuminant = \"E\"\n[[light]]\ntype = \"directional\"\ndirection = [0, 1, 0]\n\
    irradiance_w_m2 = 1\nilluminant = \"E\"\n";

/// The front of a slab.
fn front(integrator: &mut Integrator, x_m: f32) -> Spectrum {
    radiance(integrator, Vec3A::new(x_m, -2.0, 0.1), Vec3A::new(x_m, -0.025, 0.0))
}

fn greatest_error(found: &Spectrum, known: &Spectrum) -> f32 {
    found.0.iter().zip(known.0).map(|(found, known)| (found / known - 1.0).abs()).fold(0.0, f32::max)
}

#[test]
fn curves_of_the_table_and_curves_that_are_solved_agree() {
    // On a node of the table, and between nodes.
    for (size_um, facetness, density_kg_m3) in [(400.0, 0.3, 300.0), (260.0, 0.2, 350.0)] {
        let keys = format!("grain_size_um = {size_um}\nfacetness = {facetness}\ndensity_kg_m3 = {density_kg_m3}");
        let text =
            format!("{}{}{}{LAMPS}", pcasnow("path = \"normal\""), material("snow", &keys), backlit("snow", 0.0));
        let mut of_table = integrator(&text, None, &[]);
        assert!(of_table.notes().is_empty(), "{:?}", of_table.notes());
        assert!(of_table.provenance().get("table").is_some());
        let mut other = analytic_table();
        other.axes.facetness = vec![0.9];
        let scene = snow::scene(&text, &[]);
        let preparation = Preparation { table: Some(&other), ..Preparation::default() };
        let mut solved = Integrator::prepare_with(&scene, preparation).unwrap();
        assert_eq!(solved.notes().len(), 1, "{:?}", solved.notes());
        let error = greatest_error(&front(&mut solved, 0.0), &front(&mut of_table, 0.0));
        assert!(error < 0.01, "{keys}: {error}");
    }
}

#[test]
fn pcasnow_solves_for_snow_off_the_table_and_says_so() {
    let reasons = [
        ("fine", "grain_size_um = [50, 70]", "its grains have other sizes or shapes than those of the table"),
        ("coarse", "grain_size_um = 1500", "grain size is 1500 µm, but the table covers 100–500 µm"),
        ("wet", "water_saturation = 0.1", "water saturation is 0.1, but the table has no such axis and holds only 0"),
        (
            "dirty",
            "impurities_ng_g = { black-carbon = 500 }",
            "black-carbon is 500 ng/g, but the table has no such axis",
        ),
        ("old_ice", "ice = \"picard2016\"", "the table was made with other constants of ice"),
    ];
    let mut text = pcasnow("path = \"normal\"") + &material("plain", "") + &backlit("plain", 0.0) + LAMPS;
    for (place, (name, keys, _)) in reasons.iter().enumerate() {
        text += &material(name, keys);
        text += &backlit(name, 2.0 * (place + 1) as f64);
    }
    let mut integrator = integrator(&text, None, &[]);
    for (name, _, reason) in &reasons {
        let notes = integrator.notes();
        let start = format!("material.{name}: its curves are solved for, because {reason}");
        assert!(notes.iter().any(|note| note.starts_with(&start)), "{start}: {notes:?}");
    }
    assert_eq!(integrator.notes().len(), reasons.len(), "snow of the table needs no note");
    let [plain, fine, coarse, wet, dirty, _] = [0, 1, 2, 3, 4, 5].map(|place: u16| {
        let seen = front(&mut integrator, 2.0 * f32::from(place));
        assert!(seen.0.iter().all(|sample| sample.is_finite() && *sample > 0.0), "{seen:?}");
        seen.0[15]
    });
    assert!(
        fine < 0.9 * plain && coarse > 1.4 * plain && wet > plain && dirty < plain,
        "{fine} {coarse} {wet} {dirty} {plain}"
    );
}

/// A block of 16 × 6 × 1 cm whose vertices lie at some x, in m, each with a value of the attribute "age".
fn block(ages: &[(f32, f32)]) -> String {
    block_of_ages([0.03, 0.005], ages)
}

const FINE: &str = "grain_size_um = 200";
const COARSE: &str = "grain_size_um = 400";

/// The block over a wide lamp, of snow between fine and coarse.
fn masked() -> String {
    let keys = format!("mask = {{ attribute = \"age\" }}\nbetween = [{{ {FINE} }}, {{ {COARSE} }}]");
    format!("{}{BLOCK}", material("snow", &keys))
}

/// The block of uniform snow.
fn uniform(keys: &str) -> String {
    format!("{}{BLOCK}", material("snow", keys))
}

const BLOCK: &str = "[light_field]\nstep_mm = 2\n[[light]]\ntype = \"rectangle\"\nposition = [0, 0, -1]\n\
    look_at = [0, 0, 0]\n\
    up = [0, 1, 0]\nsize = [20, 20]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n\
    [[object]]\nmesh = \"block.ply\"\nmaterial = \"snow\"\n";

/// The top of the block at some x, seen obliquely.
fn at_top(integrator: &mut Integrator, x_m: f32, samples: u32) -> [Estimate; 3] {
    let target = Vec3A::new(x_m, 0.003, 0.005);
    estimate(integrator, target + Vec3A::new(0.2, -0.5, 1.0), target, samples, BANDS)
}

#[test]
fn where_a_mask_is_0_or_1_everywhere_snow_is_that_of_one_end() {
    for (age, keys) in [(0.0, FINE), (1.0, COARSE)] {
        let file = [("block.ply", block(&[(-0.04, age), (0.04, age)]))];
        for (method, samples) in [("diffusion", 4), ("hybrid", 128)] {
            let [mut mask, mut known] = [masked(), uniform(keys)].map(|text| {
                let scene = scene_of_few_grains(method, &text, &file);
                prepared(&scene, None)
            });
            for x_m in [-0.02, 0.01] {
                let [mask, known] = [&mut mask, &mut known].map(|integrator| at_top(integrator, x_m, samples));
                for (mask, known) in mask.iter().zip(&known) {
                    // The field is solved for at other wavelengths: those that all kinds of the mask need.
                    let error = mask.standard_error.hypot(known.standard_error);
                    let difference = (mask.mean - known.mean).abs();
                    assert!(difference < 1e-3 * known.mean + 4.0 * error, "{method} {age}: {mask:?} {known:?}");
                    assert!(error < 0.02 * known.mean, "{method} {age}: {mask:?} {known:?}");
                }
            }
        }
    }
}

/// The ends of a block of two snows are as bright as blocks of one snow, and coarse snow transmits more light.
#[test]
fn far_from_a_plane_boundary_snow_is_that_of_its_side() {
    let boundary = [("block.ply", block(&[(-0.08, 0.0), (-0.0005, 0.0), (0.0005, 1.0), (0.08, 1.0)]))];
    let whole = [("block.ply", block(&[(-0.08, 0.0), (0.08, 0.0)]))];
    for method in ["diffusion", "hybrid"] {
        let at = |text: &str, file: &[(&str, String)], places: &[f32]| {
            let mut integrator = prepared(&scene_of_few_grains(method, text, file), None);
            places.iter().map(|x_m| at_top(&mut integrator, *x_m, 64)).collect::<Vec<_>>()
        };
        let found = at(&masked(), &boundary, &[-0.05, -0.003, 0.003, 0.05]);
        let [fine, coarse] =
            [(FINE, -0.05), (COARSE, 0.05)].map(|(keys, x_m)| at(&uniform(keys), &whole, &[x_m]).remove(0));
        for (found, known) in [(&found[0], fine), (&found[3], coarse)] {
            for (found, known) in found.iter().zip(&known) {
                // Light wanders a centimetre or two through a slab of one.
                let error = found.standard_error.hypot(known.standard_error);
                assert!(
                    (found.mean - known.mean).abs() < 1e-3 * known.mean + 4.0 * error,
                    "{method}: {found:?} {known:?}"
                );
            }
        }
        let red: Vec<f64> = found.iter().map(|bands| bands[2].mean).collect();
        assert!(red.windows(2).all(|pair| pair[1] > pair[0]) && red[3] > 1.4 * red[0], "{method}: {red:?}");
    }
}
