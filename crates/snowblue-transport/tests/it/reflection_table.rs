//! The table of R₀ that shaders read, between its values.

use snowblue_transport::ordinates::HalfSpace;
use snowblue_transport::{PhaseFunction, PhasePlan, SnowSample};

/// Values along each argument, as on the page.
const COUNT: usize = 32;
/// Rays through grains, as for the light field.
const RAYS: u32 = 1 << 18;

/// The greatest relative error in the middle of the cells of the table, for cosines from 0.1.
fn greatest_error(phase: &PhaseFunction) -> f64 {
    let steps = COUNT - 1;
    let half_space = HalfSpace::new(phase);
    let table = half_space.reflection_table(u32::try_from(steps).unwrap());
    let mut greatest = 0.0_f64;
    for cell in (0..steps.pow(3)).step_by(7) {
        // The roots of the cosines of exit and of incidence, and the sine of half the azimuth.
        let cells = [cell / steps.pow(2), cell / steps % steps, cell % steps];
        let [exit, incidence, square] = cells.map(|cell| ((cell as f64 + 0.5) / steps as f64).powi(2));
        if exit.min(incidence) < 0.1 {
            continue;
        }
        let corner = |corner: usize| {
            let [exit, incidence, azimuth] = [2, 1, 0].map(|axis| cells[2 - axis] + (corner >> axis) % 2);
            f64::from(table[(exit * COUNT + incidence) * COUNT + azimuth])
        };
        let read = (0..8).map(corner).sum::<f64>() / 8.0 / (exit + incidence);
        let exact = half_space.reflection(exit, incidence, 1.0 - 2.0 * square);
        greatest = greatest.max((read / exact - 1.0).abs());
    }
    greatest
}

/// Light without a preferred direction needs few values. What is scattered forwards varies within a cell, and the phase
/// function of snow has noise besides. The bounds are the errors found, rounded up.
#[test]
fn a_table_is_read_between_its_values() {
    let snow = PhaseFunction::of_sample(&SnowSample::default(), 550.0, &PhasePlan { rays: RAYS, seed: 1 }).unwrap();
    let phases = [PhaseFunction::isotropic(), PhaseFunction::henyey_greenstein(0.7), snow];
    let errors = phases.each_ref().map(greatest_error);
    for (error, bound) in errors.iter().zip([0.001, 0.025, 0.04]) {
        assert!(*error < bound, "{errors:?}");
    }
}
